"""A linkage compiled: its tree of links, its state, and the programs for position, closure and rates."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.cache import COMPILED, alike
from ....framework.program.recording import Recording, Term
from ....framework.program.source import Functions
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..description.places import place as place_of
from .closure import closing_bias, closing_rows
from .joint_motion import motion_at
from .linear import Pattern
from .moving_links import Column, MovingLink
from .rates import Rates, rates_of
from .terms import Scalar, Value, Vector, combine, minus, plus, times
from .tree import Branch, Tree, spanning_tree

# Groups of numbers that programs take.
_STATE, _PARAMETERS, _VELOCITIES, _CHANGES = range(4)
_FURTHER = 2
EPS = float(np.finfo(np.float64).eps)


class Mechanism:
    """The relative joint coordinates of a linkage on a spanning tree, and its loops.

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
        Power of two near the greatest distance in the drawing.
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
    begun
        Nominal dimensions, loops and closed drawing, once they have been found. The assembly finds them and puts them
        here, so that they live as long as the mechanism.
    starts
        Closed drawings of all members of the batch, likewise.
    usual_speeds
        How fast points and links move in general, likewise, by tolerance, point and link.
    framed
        The frame of the linkage at a single pose, and what it was made with, from which those at others are made.
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
        self.begun: tuple[list[float], Any, Any] | None = None
        self.starts: Any = None
        self.usual_speeds: dict[tuple[float, str | None, str], Array] = {}
        self.framed: Any = None
        self._counting: dict[str, Mechanism] = {}
        self._described = linkage.alike()
        self._checked = False
        self._points: dict[tuple[str, str], Array] = {}
        self._arms: dict[tuple[str, bytes], list[Value]] = {}
        self._poses: dict[str, Functions] = {}
        self._rates: dict[str, Functions] = {}
        self._on_links: dict[tuple[str, tuple[int, ...]], Functions] = {}
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

    def check_free(self) -> None:
        """`LinkageDescription.check_free` of what was compiled: looked at once.

        Raises
        ------
        FrameError
            As there.
        """
        if not self._checked:
            self.linkage.check_free()
            self._checked = True

    def counting(self, joint: str) -> Mechanism:
        """The linkage as it was compiled, with the coordinates of a joint among its state."""
        if joint not in self._counting:
            self._counting[joint] = Mechanism(self._described, joint)
        return self._counting[joint]

    # -- writing it down --------------------------------------------------------------------------------------------

    def _ground(self) -> None:
        """The ground's axes are those of the first joint on it, so that what is planar looks planar."""
        pair = self.tree.branches[0].pair if self.tree.branches else None
        place, axes = np.zeros(3), np.eye(3)
        if pair is not None:
            place = self.place(GROUND, pair.point)
            axes = pair.axes if pair.axes.ndim == 2 else axes
        self.bodies[GROUND] = MovingLink(
            [0.0, 0.0, 0.0], [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], place, axes
        )

    def place(self, link: str, point: str) -> Array:
        """Where a link has a point, in drawn coordinates, (..., 3), with the link's true length."""
        own = self.tree.twins.get(link, link), point
        if own not in self._points:
            self._points[own] = place_of(self.linkage, *own)
        return self._points[own]

    def arm(self, link: str, place: Array) -> list[Value]:
        """Components of the vector from a link's reference point to a drawn place, in units of `size`."""
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
        """Numbers (..., 3) of the drawing, written down: those that are always 0, 1 or -1 as such."""
        out: list[Scalar] = []
        for k in range(3):
            part = value[..., k]
            for exact in (0.0, 1.0, -1.0):
                if np.all(np.abs(part - exact) <= self._rounding):
                    out.append(exact)
                    break
            else:
                out.append(self._parameter(part))
        return out

    def _later(self, group: int, place: int) -> Term:
        """What is given when a program runs."""
        self._places.append((group, place))
        return cast(Term, self.recording.later(0))

    def _parameter(self, value: Array) -> Term:
        """A dimension; the same one where it has been met before."""
        key = value.shape, value.tobytes()
        if key not in self._met:
            self._met[key] = self._later(_PARAMETERS, len(self.parameters))
            self.parameters.append(float(value) if value.ndim == 0 else np.ascontiguousarray(value))
        return self._met[key]

    @cached_property
    def _rounding(self) -> float:
        largest = max(float(np.abs(point).max(initial=0.0)) for point in self.linkage.points.values())
        return 4.0 * EPS * max(1.0, largest / self.size)

    def point_on(self, body: MovingLink, place: Array) -> Vector:
        """A point fixed on a body that was drawn at `place`."""
        arm = _along(body.reference_axes, place - body.place) / self.size
        return plus(body.origin, combine(body.axes, self.constant(arm)))

    def axes_on(self, body: MovingLink, reference_axes: Array) -> list[Vector]:
        """Axes fixed on a body that were the columns of `reference_axes`."""
        if reference_axes is body.reference_axes or np.array_equal(reference_axes, body.reference_axes):
            return body.axes
        rotated = np.einsum("...ji,...jk->...ik", body.reference_axes, reference_axes)
        return [combine(body.axes, self.constant(rotated[..., k])) for k in range(3)]

    def _attach(self, branch: Branch) -> None:
        pair, parent = branch.pair, self.bodies[branch.parent]
        names = [
            f"s{len(self.state_names) + k}" for k in range(4 if pair.kind.name == "spherical" else pair.kind.freedom)
        ]
        own = [self._later(_STATE, len(self.state_names) + k) for k in range(len(names))]
        self.states[pair.name] = slice(len(self.state_names), len(self.state_names) + len(names))
        self.state_names += names
        axes = self.axes_on(parent, pair.axes)
        here = self.point_on(parent, self.place(branch.parent, pair.point))
        step = motion_at(pair.kind.name, own, self._pitch(pair))
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
        sign = -1.0 if branch.is_reversed else 1.0
        for component in pair.kind.coordinates:
            carrier = 1 if (pair.kind.name, component) == ("universal", "rx") else 0
            axis = (second if carrier else first)["xyz".index(component[1])]
            angular: Vector = axis if component[0] == "r" else [0.0, 0.0, 0.0]
            linear: Vector = axis if component[0] == "u" else [0.0, 0.0, 0.0]
            if pair.kind.name == "screw":
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

    # -- programs ---------------------------------------------------------------------------------------------------

    def program(self, outputs: Iterable[Scalar]) -> Functions:
        """(state, parameters) to `outputs`; (state, parameters, v, dv/dt) where these come in."""
        terms = [x if isinstance(x, Term) else self.recording.constant(x) for x in outputs]
        program, given = self.recording.program(terms)
        return Functions.of(program, tuple(self._places[k] for k in given))

    @cached_property
    def closing(self) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
        """Active residuals, and the entries of their Jacobian by the unknowns and by the drives, row by row."""
        rows = self.active
        return (
            [self._residual[i] for i in rows],
            [self._jacobian[i][k] for i in rows for k in self.unknown],
            [self._jacobian[i][k] for i in rows for k in self.driven],
        )

    @cached_property
    def acting(self) -> list[int]:
        """Rows that some coordinate acts on; the others hold by construction, or not at all."""
        return [i for i, row in enumerate(self._jacobian) if any(map(_acts, row))]

    @cached_property
    def active(self) -> list[int]:
        """Rows that some unknown acts on; the others hold by construction, or not at all."""
        return [i for i, row in enumerate(self._jacobian) if any(_acts(row[k]) for k in self.unknown)]

    @cached_property
    def pattern(self) -> Pattern:
        """Which unknown acts on which active row, (rows, unknowns)."""
        acts = [_acts(self._jacobian[i][k]) for i in self.active for k in self.unknown]
        return np.array(acts, dtype=bool).reshape(len(self.active), len(self.unknown))

    @cached_property
    def newton(self) -> Functions:
        """(state, parameters) to active residuals, then the Jacobian of the active rows by the unknowns."""
        residual, jacobian, _ = self.closing
        return self.program([*residual, *jacobian])

    @cached_property
    def full(self) -> Functions:
        """As `newton`, with the Jacobian of the active rows by the drives behind."""
        residual, jacobian, drives = self.closing
        return self.program([*residual, *jacobian, *drives])

    @cached_property
    def residual(self) -> Functions:
        """(state, parameters) to the residuals of all rows."""
        return self.program(self._residual)

    @cached_property
    def all_entries(self) -> Functions:
        """(state, parameters) to the Jacobian of all rows by all velocity coordinates."""
        return self.program([entry for row in self._jacobian for entry in row])

    @cached_property
    def acting_places(self) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
        """Row, counted among those in `acting`, and column of each entry of their Jacobian that is not always zero."""
        places = [(i, k) for i, row in enumerate(self.acting) for k, x in enumerate(self._jacobian[row]) if _acts(x)]
        rows, columns = np.array(places, dtype=np.intp).reshape(-1, 2).T
        return rows, columns

    @cached_property
    def acting_closure(self) -> Functions:
        """(state, parameters) to the residuals of the rows in `acting`, then the entries at `acting_places`."""
        entries = [self._jacobian[self.acting[i]][k] for i, k in zip(*self.acting_places, strict=True)]
        return self.program([*(self._residual[i] for i in self.acting), *entries])

    def pose_of(self, link: str) -> Functions:
        """(state, parameters) to reference point and axes, twelve numbers, of a link."""
        if link not in self._poses:
            body = self.bodies[link]
            self._poses[link] = self.program([x for v in (body.origin, *body.axes) for x in v])
        return self._poses[link]

    def point_of(self, link: str, kept: tuple[int, ...]) -> Functions:
        """(state, parameters, arm and size) to a place of a link, three numbers in the ground's axes.

        The arm leads there from the link's reference point; it has the components `kept`, along the link's axes.
        """
        if (link, kept) not in self._on_links:
            body, given = self.bodies[link], [self._later(_FURTHER, k) for k in range(len(kept) + 1)]
            there: Vector = [0.0, 0.0, 0.0]
            for k, x in zip(kept, given, strict=False):
                there = plus(there, times(x, body.axes[k]))
            self._on_links[link, kept] = self.program(times(given[-1], plus(body.origin, there)))
        return self._on_links[link, kept]

    @cached_property
    def joint_points(self) -> Functions:
        """(state, parameters) to the points of all joints on their first links, by name."""
        return self.program([x for name in sorted(self.linkage.joints) for x in self.frames[name][1]])

    def joint_axes(self, pair: Pair) -> Functions:
        """(state, parameters) to the axes x y z, nine numbers, of a joint that closes a loop, on its first link."""
        axes, _, _, _ = self._joined(pair)
        return self.program([x for axis in axes for x in axis])

    def rates_of(self, link: str) -> Functions:
        """(state, parameters, v, dv/dt) to ω, velocity of the reference point, α and its acceleration, of a link."""
        if link not in self._rates:
            _, rates = self._moving
            own = rates[link]
            values = [x for v in (own.omega, own.v, own.alpha, own.a) for x in v]
            self._rates[link] = self.program(values)
        return self._rates[link]

    @cached_property
    def poses(self) -> Functions:
        """As `pose_of`, of all links in the order of the linkage."""
        bodies = (self.bodies[link] for link in self.linkage.links)
        return self.program([x for body in bodies for v in (body.origin, *body.axes) for x in v])

    @cached_property
    def rates(self) -> Functions:
        """As `rates_of`, of all links in the order of the linkage."""
        _, rates = self._moving
        moves = (rates[link] for link in self.linkage.links)
        values = [x for own in moves for v in (own.omega, own.v, own.alpha, own.a) for x in v]
        return self.program(values)

    @cached_property
    def relative(self) -> dict[str, Functions]:
        """By joint: (state, parameters) to axes x y z and point on the first link, axes and point on the second."""
        return {
            name: self.program([x for v in (*first, here, *second, there) for x in v])
            for name, (first, here, second, there) in self.frames.items()
        }

    @cached_property
    def bias(self) -> Functions:
        """(state, parameters, v, dv/dt) to the second time derivative of the active rows."""
        bias, _ = self._moving
        return self.program([bias[i] for i in self.active])

    @cached_property
    def _moving(self) -> tuple[list[Scalar], dict[str, Rates]]:
        v, w = ([self._later(group, k) for k in range(len(self.columns))] for group in (_VELOCITIES, _CHANGES))
        rates = rates_of(self.tree, self.bodies, self.frames, self._columns, self.velocities, v, w)
        bias = [
            x
            for pair in self.tree.cuts
            for x in closing_bias(pair, self._joined(pair), rates[pair.first], rates[pair.second])
        ]
        return bias, rates

    def jacobian(self, state: Array) -> Array:
        """Jacobian of all closing rows by all velocity coordinates, (..., rows, columns), at states (..., n)."""
        entries = self.all_entries[1](tuple(np.moveaxis(state, -1, 0)), tuple(self.parameters))
        return stacked(entries).reshape(*stacked(entries).shape[:-1], len(self.rows), len(self.columns))


def stacked(entries: tuple[Value, ...]) -> Array:
    """Entries, which broadcast, along a last axis."""
    if not entries:
        return np.zeros(0)
    return np.stack(np.broadcast_arrays(*entries), axis=-1)


def _along(axes: Array, vectors: Array) -> Array:
    """Components (..., 3) of vectors along axes, which are columns (..., 3, 3)."""
    if axes.ndim == 2:
        return np.asarray(vectors @ axes)
    return np.asarray(np.einsum("...ji,...j->...i", axes, vectors))


def _acts(entry: Scalar) -> bool:
    return isinstance(entry, Term) or entry != 0.0


def _size(linkage: LinkageDescription) -> float:
    """Power of two just above the extent of the drawing; 1 where it has none."""
    corners = [point.reshape(-1, 3) for point in linkage.points.values()]
    places = np.concatenate(corners) if corners else np.zeros((1, 3))
    extent = float(np.linalg.norm(places.max(axis=0) - places.min(axis=0)))
    return float(2.0 ** np.ceil(np.log2(extent))) if extent > 0.0 else 1.0


def compiled(linkage: LinkageDescription) -> Mechanism:
    """The linkage's mechanism, compiled once for as long as its description stays the same."""
    last: tuple[tuple[object, ...], Mechanism] | None = COMPILED.get(linkage)
    version = linkage.version
    if last is None or not alike(last[0], version):
        last = version, Mechanism(linkage.alike())
        COMPILED.put(linkage, last)
    return last[1]
