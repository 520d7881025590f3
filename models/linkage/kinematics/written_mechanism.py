"""A linkage written down: its tree of links, its state, and what holds in its joints, as formulas of the state."""

from __future__ import annotations

from functools import cached_property
from typing import cast

import numpy as np

from ....framework.batch import Array
from ....framework.program.recording import Recording, Term
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..description.places import place as place_of
from .closure import closing_rows
from .joint_motion import motion_at
from .moving_links import Column, MovingLink
from .terms import Scalar, Value, Vector, combine, minus, plus, times
from .tree import LinkBranch, Tree, spanning_tree

# Groups of numbers that programs take: state, parameters, velocities and their time derivatives; what else is given
# stands where velocities do.
STATE, PARAMETERS, VELOCITIES, CHANGES, FURTHER = 0, 1, 2, 3, 2
EPS = float(np.finfo(np.float64).eps)


class WrittenMechanism:
    """The relative joint coordinates of a linkage on a spanning tree, and its loops, as formulas.

    Joints of the tree hold by construction. Each other joint closes a loop with as many equations as it holds
    components. Lengths are divided by `size`, a power of two.

    Parameters
    ----------
    linkage
        The description.
    counted
        A joint whose coordinates must be among the state, so that their whole turns are known; else None.

    Attributes
    ----------
    tree
        Its spanning tree.
    size
        Power of two near the greatest distance of points in the reference configuration.
    columns
        Joint and component of each velocity coordinate: angular velocity, in the joint's axes on its first link, for
        a ball; rate of the coordinate otherwise.
    states, velocities
        Where each joint's numbers lie in the state, zero in the reference configuration (four Euler parameters for a
        ball), and among the velocity coordinates, by joint.
    driven, unknown
        Indices of the driven velocity coordinates, in the order of ``linkage.drives``, and of the others.
    rows
        Joint and component of each closing equation.
    parameters
        Dimensions that the programs take, in units of `size`.
    bodies, frames
        Places of the links; and by joint axes and point on the first and on the second link.
    paths
        By link: numbers of the velocity coordinates that move it.
    """

    def __init__(self, linkage: LinkageDescription, counted: str | None = None) -> None:
        self.linkage = linkage
        self.tree: Tree = spanning_tree(linkage, counted)
        self.size = _size(linkage)
        self.recording = Recording(fixed=True)
        # Of what is given when a program runs: its group (state, parameters, v, dv/dt), and its place there.
        self._places: list[tuple[int, int]] = []
        self._met: dict[tuple[tuple[int, ...], bytes], Term] = {}
        self.parameters: list[Value] = []
        self._points: dict[tuple[str, str], Array] = {}
        self._arms: dict[tuple[str, bytes], list[Value]] = {}
        self.bodies: dict[str, MovingLink] = {}
        self.frames: dict[str, tuple[list[Vector], Vector, list[Vector], Vector]] = {}
        self._columns: list[Column] = []
        self.paths: dict[str, frozenset[int]] = {GROUND: frozenset()}
        self.states: dict[str, slice] = {}
        self.velocities: dict[str, slice] = {}
        self.state_names: list[str] = []
        self._ground()
        for branch in self.tree.branches:
            self._attach(branch)
        for pair in self.tree.cuts:
            self.frames[pair.name if pair.first not in self.tree.twins else pair.first] = self._joined(pair)
        self.columns = [(column.joint, column.component) for column in self._columns]
        self.driven = [self.columns.index((name, c)) for name, those in linkage.drives.items() for c in those]
        self.unknown = [k for k in range(len(self.columns)) if k not in self.driven]
        self._close()

    def _ground(self) -> None:
        """The ground's axes are those of the first joint on it, so that what is planar looks planar."""
        pair = self.tree.branches[0].edge if self.tree.branches else None
        place, axes = np.zeros(3), np.eye(3)
        if pair is not None:
            place = self.place(GROUND, pair.point)
            axes = pair.axes if pair.axes.ndim == 2 else axes
        self.bodies[GROUND] = MovingLink(
            [0.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], place, axes
        )

    def place(self, link: str, point: str) -> Array:
        """Where a link has a point, in the reference configuration, (..., 3), with the link's true length."""
        own = self.tree.twins.get(link, link), point
        if own not in self._points:
            self._points[own] = place_of(self.linkage, *own)
        return self._points[own]

    def arm(self, link: str, place: Array) -> list[Value]:
        """Components, by `size`, of the vector from a link's reference point to a place before it moves."""
        key = link, place.tobytes() if place.ndim == 1 else b""
        if key in self._arms:
            return self._arms[key]
        body = self.bodies[link]
        arm = _along(body.reference_axes, place - body.place) / self.size
        components: list[Value] = [arm[..., k] if np.any(arm[..., k]) else 0.0 for k in range(3)]
        if arm.ndim == 1:
            components = arm.tolist()
        if place.ndim == 1:
            self._arms[key] = components
        return components

    @cached_property
    def upright(self) -> bool:
        """Whether the ground's axes are the global ones."""
        return np.array_equal(self.bodies[GROUND].reference_axes, np.eye(3))

    def constant(self, value: Array) -> list[Scalar]:
        """Numbers (..., 3) of the description, written down: those that are always 0, 1 or -1 as such."""
        parts = value.tolist() if value.ndim == 1 else np.moveaxis(value, -1, 0)
        return [self._constant(part) for part in parts]

    def _constant(self, part: float | Array) -> Scalar:
        for exact in (0.0, 1.0, -1.0):
            off = abs(part - exact) if isinstance(part, float) else float(np.abs(part - exact).max(initial=0.0))
            if off <= self._rounding:
                return exact
        return self._parameter(np.asarray(part))

    def _later(self, group: int, place: int) -> Term:
        """What is given when a program runs."""
        self._places.append((group, place))
        return cast(Term, self.recording.later(0))

    def _parameter(self, value: Array) -> Term:
        """A dimension; the same one where it has been met before."""
        key = value.shape, value.tobytes()
        if key not in self._met:
            self._met[key] = self._later(PARAMETERS, len(self.parameters))
            self.parameters.append(float(value) if value.ndim == 0 else np.ascontiguousarray(value))
        return self._met[key]

    @cached_property
    def _rounding(self) -> float:
        largest = max(float(np.abs(point).max(initial=0.0)) for point in self.linkage.points.values())
        return 4.0 * EPS * max(1.0, largest / self.size)

    def point_on(self, body: MovingLink, place: Array) -> Vector:
        """A point fixed on a body that is at `place` in the reference configuration."""
        arm = _along(body.reference_axes, place - body.place) / self.size
        return plus(body.origin, combine(body.axes, self.constant(arm)))

    def axes_on(self, body: MovingLink, reference_axes: Array) -> list[Vector]:
        """Axes fixed on a body that were the columns of `reference_axes`."""
        if reference_axes is body.reference_axes or np.array_equal(reference_axes, body.reference_axes):
            return body.axes
        rotated = np.einsum("...ji,...jk->...ik", body.reference_axes, reference_axes)
        return [combine(body.axes, self.constant(rotated[..., k])) for k in range(3)]

    def _attach(self, branch: LinkBranch) -> None:
        pair, parent = branch.edge, self.bodies[branch.parent]
        names = [
            f"s{len(self.state_names) + k}" for k in range(4 if pair.kind.name == "spherical" else pair.kind.freedom)
        ]
        own = [self._later(STATE, len(self.state_names) + k) for k in range(len(names))]
        self.states[pair.name] = slice(len(self.state_names), len(self.state_names) + len(names))
        self.state_names += names
        axes = self.axes_on(parent, pair.axes)
        here = self.point_on(parent, self.place(branch.parent, pair.point))
        step = motion_at(pair.kind, own, self._pitch(pair))
        first_point: Vector
        second_point: Vector
        if branch.is_reversed:
            second, second_point = axes, here
            first = step.rotated_back(second)
            first_point = minus(here, combine(first, step.shift))
        else:
            first, first_point = axes, here
            second = step.rotated(first)
            second_point = plus(here, combine(first, step.shift))
        self.frames[pair.name] = first, first_point, second, second_point
        own_axes, own_point = (first, first_point) if branch.is_reversed else (second, second_point)
        place = self.place(branch.child, pair.point)
        self.bodies[branch.child] = MovingLink(own_point, own_axes, place, pair.axes)
        start = len(self._columns)
        sign = branch.sign
        for component in pair.kind.coordinates:
            carrier = 1 if (pair.kind.name, component) == ("universal", "rx") else 0
            axis = (second if carrier else first)["xyz".index(component[1])]
            angular: Vector = axis if component[0] == "r" else [0.0, 0.0, 0.0]
            linear: Vector = axis if component[0] == "u" else [0.0, 0.0, 0.0]
            if pair.kind.tied:
                linear = times(self._pitch(pair), axis)
            self._columns.append(Column(pair.name, component, sign, angular, linear, second_point, carrier))
        self.velocities[pair.name] = slice(start, len(self._columns))
        self.paths[branch.child] = self.paths[branch.parent] | set(range(start, len(self._columns)))

    def _pitch(self, pair: Pair) -> Scalar:
        """Advance per radian."""
        if pair.pitch is None:
            return 0.0
        return self.constant((pair.pitch / (2.0 * np.pi * self.size))[..., None] * np.ones(3))[0]

    def _joined(self, pair: Pair) -> tuple[list[Vector], Vector, list[Vector], Vector]:
        out: list[list[Vector] | Vector] = []
        for link in (pair.first, pair.second):
            body = self.bodies[link]
            out += [self.axes_on(body, pair.axes), self.point_on(body, self.place(link, pair.point))]
        return out[0], out[1], out[2], out[3]  # type: ignore[return-value]

    def _close(self) -> None:
        self.rows: list[tuple[str, str]] = []
        self._residual: list[Scalar] = []
        self._jacobian: list[list[Scalar]] = []
        for pair in self.tree.cuts:
            joined = self._joined(pair)
            for row in closing_rows(pair, joined, self._columns, self.paths[pair.first], self.paths[pair.second]):
                self.rows.append((pair.name, row.component))
                self._residual.append(row.residual)
                self._jacobian.append(row.entries)


def _along(axes: Array, vectors: Array) -> Array:
    """Components (..., 3) of vectors along axes, which are columns (..., 3, 3)."""
    if axes.ndim == 2:
        return np.asarray(vectors @ axes)
    return np.asarray(np.einsum("...ji,...j->...i", axes, vectors))


def _size(linkage: LinkageDescription) -> float:
    """Power of two just above the extent of the linkage; 1 where it has none."""
    corners = [point.reshape(-1, 3) for point in linkage.points.values()]
    places = np.concatenate(corners) if corners else np.zeros((1, 3))
    extent = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return float(2.0 ** np.ceil(np.log2(extent))) if extent > 0.0 else 1.0
