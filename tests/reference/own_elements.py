"""Elements as a user writes them: built-in ones written anew, and a beam on Winkler foundation as fourteen springs."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from linkframe.elements import Beam
from linkframe.framework import Frame
from linkframe.framework.joint_protocol import JointElement
from linkframe.framework.protocol import LineElement, PointElement
from numpy.typing import NDArray

Array = NDArray[Any]
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(4)
POINTS, WEIGHTS = 0.5 * (1.0 + _POINTS), 0.5 * _WEIGHTS


class Delegating(LineElement):
    """What answers as another element does; `inner` is that element."""

    inner: LineElement

    @property
    def segments(self) -> int:  # type: ignore[override]
        return self.inner.segments

    @property
    def releases(self) -> tuple[tuple[int, int], ...]:  # type: ignore[override]
        return self.inner.releases

    @property
    def shape(self) -> tuple[int, ...]:
        return self.inner.shape

    @property
    def kind(self) -> Hashable:
        return self.inner.kind

    @property
    def exact(self) -> bool:
        return self.inner.exact

    @property
    def roundings(self) -> float:
        return self.inner.roundings

    @property
    def quadrature(self) -> int:
        return self.inner.quadrature

    def part(self, index: int, count: int) -> LineElement:
        return replace(self, inner=self.inner.part(index, count))  # type: ignore[type-var]

    def check(self, chord: Array) -> None:
        self.inner.check(chord)

    def axes(self, chord: Array) -> Array:
        return self.inner.axes(chord)

    def stiffness_matrix(self, length: Array) -> Array:
        return self.inner.stiffness_matrix(length)

    def springs(self, length: Array) -> tuple[Array, Array]:
        return self.inner.springs(length)

    def mass_matrix(self, length: Array) -> Array:
        return self.inner.mass_matrix(length)

    def geometric_matrix(self, length: Array, axial: Array) -> Array:
        return self.inner.geometric_matrix(length, axial)

    def end_forces(self, length: Array, displacement: Array) -> Array:
        return self.inner.end_forces(length, displacement)

    def shape_functions(self, length: Array, x: Array) -> Array:
        return self.inner.shape_functions(length, x)

    def section_flexibility(self, fraction: Array) -> Array:
        return self.inner.section_flexibility(fraction)

    def mass_per_length(self, fraction: Array) -> Array:
        return self.inner.mass_per_length(fraction)

    def stress(self, fraction: Array, forces: Array) -> Array:
        return self.inner.stress(fraction, forces)


@dataclass(frozen=True, eq=False)
class Rewritten(Delegating):
    """A line element with its springs in the other order, the first `halved` given as two halves; as it is where -1."""

    inner: LineElement
    halved: int = 2

    @property
    def kind(self) -> Hashable:
        return self.inner.kind, self.halved

    def springs(self, length: Array) -> tuple[Array, Array]:
        k, rows = self.inner.springs(length)
        if self.halved < 0:
            return k, rows
        order = [*reversed(range(6)), *range(self.halved)]
        share = np.where(np.isin(order, range(self.halved)), 0.5, 1.0)
        return share * k[..., order], rows[..., order, :]


class Softer(Beam):
    """A beam of half the stiffness, of whatever section."""

    def springs(self, length: Array) -> tuple[Array, Array]:
        stiffness, rows = super().springs(length)
        return 0.5 * stiffness, rows

    def stiffness_matrix(self, length: Array) -> Array:
        return 0.5 * super().stiffness_matrix(length)

    def end_forces(self, length: Array, displacement: Array) -> Array:
        return 0.5 * super().end_forces(length, displacement)

    def section_flexibility(self, fraction: Array) -> Array:
        return 2.0 * super().section_flexibility(fraction)


class RewrittenJoint(JointElement):
    """A joint that holds what another holds."""

    def __init__(self, inner: JointElement) -> None:
        self.inner = inner
        self.stiffness, self.axes, self.clearance = inner.stiffness, inner.axes, inner.clearance
        self.clearance_directions, self.pitch = inner.clearance_directions, inner.pitch

    @property
    def shape(self) -> tuple[int, ...]:
        return self.inner.shape

    def matrix(self) -> Array:
        return self.inner.matrix()

    def typical(self) -> JointElement:
        return RewrittenJoint(self.inner.typical())


@dataclass(frozen=True, eq=False)
class RewrittenMass(PointElement):
    """A mass with the matrix of another."""

    inner: PointElement

    @property
    def shape(self) -> tuple[int, ...]:
        return self.inner.shape

    def mass_matrix(self) -> Array:
        return self.inner.mass_matrix()


@dataclass(frozen=True, eq=False)
class Winkler(Delegating):
    """Beam on an elastic foundation: six springs of the beam, and two of the foundation at each of four Gauss points.

    The foundation resists displacement across the beam with `modulus` (...), force per length and displacement; the
    points integrate the beam's cubics exactly, so that this is the consistent foundation matrix.
    """

    inner: Beam
    modulus: Array
    points: Array = field(default_factory=lambda: POINTS, metadata={"trailing": 1})
    weights: Array = field(default_factory=lambda: WEIGHTS, metadata={"trailing": 1})

    @property
    def shape(self) -> tuple[int, ...]:
        return np.broadcast_shapes(self.inner.shape, self.modulus.shape)

    @property
    def kind(self) -> Hashable:
        return self.inner.kind, self.modulus.shape, self.modulus.tobytes()

    @property
    def exact(self) -> bool:
        return False

    def springs(self, length: Array) -> tuple[Array, Array]:
        k, rows = self.inner.springs(length)
        length = np.asarray(length)
        shape = np.broadcast_shapes(k.shape[:-1], self.modulus.shape)
        below = np.zeros((*length.shape, 2, len(self.points), 12), np.result_type(length, np.float64))
        for p, s in enumerate(self.points):
            v = (
                1.0 - 3.0 * s**2 + 2.0 * s**3,
                length * (s - 2.0 * s**2 + s**3),
                3.0 * s**2 - 2.0 * s**3,
                length * (s**3 - s**2),
            )
            for plane, (dofs, sign) in enumerate((((1, 5, 7, 11), 1.0), ((2, 4, 8, 10), -1.0))):
                for dof, value, turn in zip(dofs, v, (1.0, sign, 1.0, sign), strict=True):
                    below[..., plane, p, dof] = value * turn
        below = below.reshape(*length.shape, -1, 12)
        resist = (self.modulus * np.asarray(length, np.float64))[..., None] * np.tile(self.weights, 2)
        batch = np.broadcast_shapes(rows.shape[:-2], below.shape[:-2])
        parts = [np.broadcast_to(part, (*batch, *part.shape[-2:])) for part in (rows, below)]
        both = [np.broadcast_to(part, (*shape, part.shape[-1])) for part in (k, resist)]
        return np.concatenate(both, axis=-1), np.concatenate(parts, axis=-2)

    def stiffness_matrix(self, length: Array) -> Array:
        k, rows = self.springs(np.asarray(length, np.float64))
        out: Array = np.swapaxes(rows, -1, -2) @ (k[..., None] * rows)
        return out

    def end_forces(self, length: Array, displacement: Array) -> Array:
        k, rows = self.springs(np.asarray(length, np.float64))
        pulls = k * np.einsum("...ij,...j->...i", rows, displacement)
        return np.einsum("...ij,...i->...j", rows, pulls)


def rebuilt(frame: Frame, *, halved: int = 2) -> Frame:
    """The frame with all its elements written anew."""
    out = Frame()
    out.tolerance = frame.tolerance
    for name, body in frame.bodies.items():
        out.body(name, body.origin, body.axes)
    for name, node in frame.nodes.items():
        out.node(name, node.coordinates, node.body)
    again: dict[int, LineElement] = {}
    for name, member in frame.members.items():
        element = again.setdefault(id(member.element), Rewritten(member.element, halved))
        out.add(name, element, member.start, member.end)
    for name, joint in frame.joints.items():
        out.add(name, RewrittenJoint(joint.element), joint.first, joint.second)
    for name, mass in frame.masses.items():
        out.add(name, RewrittenMass(mass.element), mass.node)
    for name in ("aliases", "ties", "supports", "offsets", "loads", "member_loads", "weight", "absent"):
        setattr(out, name, getattr(frame.copy(), name))
    out.shape, out._shapes = frame.shape, dict(frame._shapes)
    return out
