"""Corotational pieces in a plane, in closed form: an elongation and two angles each; see `corotation`."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import added, angle, is_recorded, rounded, square_root
from .numbers import Numbers, Stack
from .state import PlanarState

# Elongation of the axis, its bow included, and the bow's derivatives by the end angles.
Bow = tuple[Array, Array, Array]
# The plane's two axes in the sense of positive rotation, by the axis across it.
AXES = ((1, 2), (2, 0), (0, 1))
# Places in a piece's tangent of its ten different entries: which of (x1 y1 r1 x2 y2 r2) they join, with what sign.
TERMS = ((0, 0), (1, 0), (1, 1), (0, 2), (1, 2), (0, 3), (1, 3), (2, 2), (3, 2), (3, 3))
ENDS = (((3, 1.0), (0, -1.0)), ((4, 1.0), (1, -1.0)), ((2, 1.0),), ((5, 1.0),))


def _places() -> tuple[NDArray[np.int64], Array]:
    """Which different entry stands where in the tangent of a piece (6, 6), and with what sign (6, 6, 1)."""
    entry, sign = np.zeros((6, 6), dtype=np.int64), np.zeros((6, 6, 1))
    for number, (p, q) in enumerate(TERMS):
        for i, first in ENDS[p]:
            for j, second in ENDS[q]:
                entry[i, j] = entry[j, i] = number
                sign[i, j] = sign[j, i] = first * second
    return entry, sign


ENTRY, SIGN = _places()


@dataclass(frozen=True)
class PlanarStack:
    """A stack of pieces: ends (n, 2), direction at rest (2, n, ...), length; stiffness k00 k11 k12 k22 and bow g11 g12
    g22 (7, n, ...)."""

    ends: NDArray[np.int64]
    direction: Numbers
    length: Numbers
    stiffness: Numbers

    @classmethod
    def of(cls, stack: Stack, normal: int, ndim: int) -> PlanarStack:
        """What of a stack in space lies in the plane."""
        local_axes = stack.local_axes.array
        along = local_axes[0][list(AXES[normal])]
        about = local_axes[:, normal]
        k = stack.stiffness.array
        parts = [k[0, 0]]
        for whole, first in ((k, 1), (stack.bow.array, 0)):
            for i, j in ((0, 0), (0, 3), (3, 3)):
                block = whole[first + i : first + i + 3, first + j : first + j + 3]
                parts.append(sum(about[a] * block[a, b] * about[b] for a in range(3) for b in range(3)))
        return cls(stack.ends, Numbers(along, ndim), stack.length, Numbers(np.stack(np.broadcast_arrays(*parts)), ndim))

    @property
    def batch(self) -> tuple[tuple[int, ...], ...]:
        """Batch shapes of direction, length and stiffness."""
        return tuple(
            each.array.shape[each.array.ndim - each.ndim :] for each in (self.direction, self.length, self.stiffness)
        )

    @classmethod
    def joined(cls, stacks: Sequence[PlanarStack]) -> PlanarStack:
        """Stacks of one batch shape as one."""

        def together(pick: Callable[[PlanarStack], Numbers]) -> Numbers:
            arrays = [pick(stack).array for stack in stacks]
            pieces = -1 - (ndim := pick(stacks[0]).ndim)
            whole = [
                np.repeat(array, len(stack.ends), axis=pieces) if array.shape[pieces] == 1 else array
                for stack, array in zip(stacks, arrays, strict=True)
            ]
            return Numbers(np.concatenate(whole, axis=pieces), ndim)

        ends = np.concatenate([stack.ends for stack in stacks])
        return cls(ends, together(lambda s: s.direction), together(lambda s: s.length), together(lambda s: s.stiffness))


def shape(stack: PlanarStack, pieces: tuple[Array, Array, Array], state: PlanarState) -> tuple[Array, Array, Array]:
    """Direction (2, n, m) and length (n, m) of the chord, elongation and end angles (3, n, m)."""
    (c0, s0), length, _ = pieces
    first, second = stack.ends.T
    x, y = state.displacements[:, second] - state.displacements[:, first]
    along, across = c0 * x + s0 * y, c0 * y - s0 * x
    ahead = length + along
    chord = square_root(ahead * ahead + across * across)
    chord_rotation = angle(across, ahead)
    out = np.empty((3, *chord.shape), chord.dtype)
    out[0] = ((length + ahead) * along + across * across) / (chord + length)
    out[1], out[2] = state.rotations[first] - chord_rotation, state.rotations[second] - chord_rotation
    if is_recorded(out) or np.abs(out[1:]).max(initial=0.0) > 3.0:
        out[1:] -= 2.0 * np.pi * rounded((out[1] + out[2]) / (4.0 * np.pi))
    c, s = ahead / chord, across / chord
    return np.stack([c0 * c - s0 * s, s0 * c + c0 * s]), chord, out


def bent(stiffness: Array, deformation: Array) -> Bow:
    """Elongation of the axis, its bow included, and the bow's derivatives by the end angles (n, m)."""
    _, _, _, _, g11, g12, g22 = stiffness
    stretch, first, second = deformation
    one, two = g11 * first + g12 * second, g12 * first + g22 * second
    return stretch + 0.5 * (first * one + second * two), one, two


def stress(stiffness: Array, deformation: Array, bow: Bow) -> Array:
    """Axial force and both end moments (3, n, m)."""
    k0, k11, k12, k22, *_ = stiffness
    axis, one, two = bow
    _, first, second = deformation
    out = np.empty_like(deformation)
    axial_force = np.multiply(k0, axis, out=out[0])
    out[1] = k11 * first + k12 * second + axial_force * one
    out[2] = k12 * first + k22 * second + axial_force * two
    return out


def strain_energy(stiffness: Array, deformation: Array, bow: Bow) -> Array:
    """Twice the strain energy of all pieces (m,)."""
    k0, k11, k12, k22, *_ = stiffness
    axis, _, _ = bow
    _, first, second = deformation
    each = k0 * axis * axis + (k11 * first + 2.0 * k12 * second) * first + k22 * second * second
    out: Array = added(each)
    return out


def stiffness(stiffness: Array, bow: Bow, axial_force: Array) -> Array:
    """Derivatives of `stress` 00 01 02 11 12 22 (6, n, m); `axial_force` resists further bowing."""
    k0, k11, k12, k22, g11, g12, g22 = stiffness
    _, one, two = bow
    out = np.empty((6, *axial_force.shape), axial_force.dtype)
    out[0] = k0
    np.multiply(k0, one, out=out[1])
    np.multiply(k0, two, out=out[2])
    out[3] = k11 + axial_force * g11 + out[1] * one
    out[4] = k12 + axial_force * g12 + out[1] * two
    out[5] = k22 + axial_force * g22 + out[2] * two
    return out


def forces(axes: Array, chord: Array, stress: Array) -> Array:
    """Fx Fy on the second end, and both end moments (4, n, m)."""
    c, s = axes
    shear = (stress[1] + stress[2]) / chord
    return np.stack([stress[0] * c + shear * s, stress[0] * s - shear * c, stress[1], stress[2]])


def terms(stiffness: Array, axes: Array, chord: Array, stress: Array) -> Array:
    """The ten different entries of the tangent in (x2 - x1, y2 - y1, r1, r2), in the order of `TERMS` (10, n, m)."""
    k00, k01, k02, k11, k12, k22 = stiffness
    c, s = axes
    bend1, bend2 = (k11 + k12) / chord, (k12 + k22) / chord
    across = (bend1 + bend2 + stress[0]) / chord
    mixed = (stress[1] + stress[2]) / (chord * chord) - (k01 + k02) / chord
    cc, ss, cs = c * c, s * s, c * s
    twice = 2.0 * cs * mixed
    out = np.empty((10, *chord.shape), chord.dtype)
    out[0] = k00 * cc + across * ss - twice
    out[1] = (k00 - across) * cs + mixed * (cc - ss)
    out[2] = k00 * ss + across * cc + twice
    out[3], out[4] = k01 * c + bend1 * s, k01 * s - bend1 * c
    out[5], out[6] = k02 * c + bend2 * s, k02 * s - bend2 * c
    out[7], out[8], out[9] = k11, k12, k22
    return out


def six(entries: Array) -> Array:
    """The tangent of one piece in (x1 y1 r1 x2 y2 r2), (6, 6, m), from its different entries (10, m)."""
    return np.asarray(SIGN * entries[ENTRY])
