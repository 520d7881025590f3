"""The recorded formulas of a linkage: places of its links and its closing equations as functions of its state."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property
from typing import NamedTuple, cast

import numpy as np
from numpy.typing import NDArray

from ....framework.program.recording import Recording, Term
from ....framework.program.source import Functions
from ..description.parts import GROUND, Pair
from .closure import Joined, closing_bias, closing_rows
from .dimensions import Dimensions, Mount, Number
from .joint_motion import motion_at
from .linear import Pattern
from .moving_links import Column, MovingLink
from .rates import Rates, rates_of
from .terms import Scalar, Vector, combine, minus, plus, times

# Groups of inputs of a program: state, parameters, velocities and their time derivatives; further inputs take the place
# of the velocities.
STATE, PARAMETERS, VELOCITIES, CHANGES, FURTHER = 0, 1, 2, 3, 2


class ClosingEquations(NamedTuple):
    """The closing equations of a linkage.

    Attributes
    ----------
    rows
        Joint and component of each row.
    acting, active
        Rows on which some coordinate acts, and on which some unknown acts; other rows do not depend on the motion.
    pattern
        Whether each unknown acts on each active row, (rows, unknowns).
    acting_places
        Row, as an index into `acting`, and column of each Jacobian entry that is not identically zero.
    """

    rows: list[tuple[str, str]]
    acting: list[int]
    active: list[int]
    pattern: Pattern
    acting_places: tuple[NDArray[np.intp], NDArray[np.intp]]


class Formulas:
    """Places of the links and closing equations, recorded as functions of state and parameters.

    Joints of the tree are satisfied by construction. Every other joint closes a loop, with one equation for each
    component that it constrains.

    Parameters
    ----------
    dimensions
        The linkage; formulas depend on its `Dimensions.formula_key` alone.

    Attributes
    ----------
    bodies, frames
        Places of the links; by joint, its axes and point on the first link and on the second.
    rows, residual, jacobian
        For each closing equation its joint and component, its residual, and an entry for each velocity coordinate.
    unknown, driven
        As in `Dimensions`.
    """

    def __init__(self, dimensions: Dimensions) -> None:
        self._dimensions = dimensions
        self.unknown, self.driven = dimensions.unknown, dimensions.driven
        self.recording = Recording(fixed=True)
        # For each input: its group (state, parameters, v, dv/dt) and its place in it.
        self._places: list[tuple[int, int]] = []
        self._parameters: dict[int, Term] = {}
        axes: list[Vector] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
        self.bodies: dict[str, MovingLink] = {GROUND: MovingLink([0.0, 0.0, 0.0], axes)}
        self.frames: dict[str, Joined] = {}
        self._columns: list[Column] = []
        # By link, indices of the velocity coordinates that move it.
        self._paths: dict[str, frozenset[int]] = {GROUND: frozenset()}
        tree = dimensions.tree
        for branch in tree.branches:
            self._attach(branch.edge, branch.parent, branch.child, branch.sign)
        self._cuts = [(pair, self._joined(pair)) for pair in tree.cuts]
        self.frames |= {pair.first if pair.first in tree.twins else pair.name: joined for pair, joined in self._cuts}
        self.rows: list[tuple[str, str]] = []
        self.residual: list[Scalar] = []
        self.jacobian: list[list[Scalar]] = []
        for pair, joined in self._cuts:
            for row in closing_rows(pair, joined, self._columns, self._paths[pair.first], self._paths[pair.second]):
                self.rows.append((pair.name, row.component))
                self.residual.append(row.residual)
                self.jacobian.append(row.entries)

    def program(self, outputs: Iterable[Scalar]) -> Functions:
        """Program from (state, parameters), or (state, parameters, v, dv/dt), to `outputs`."""
        terms = [x if isinstance(x, Term) else self.recording.constant(x) for x in outputs]
        program, given = self.recording.program(terms)
        return Functions.of(program, tuple(self._places[k] for k in given))

    # -- links and joints -------------------------------------------------------------------------------------------

    def _later(self, group: int, place: int) -> Term:
        """An input of the programs."""
        self._places.append((group, place))
        return cast(Term, self.recording.later(0))

    def _scalar(self, number: Number) -> Scalar:
        if isinstance(number, float):
            return number
        if number.place not in self._parameters:
            self._parameters[number.place] = self._later(PARAMETERS, number.place)
        return self._parameters[number.place]

    def _mounted(self, mount: Mount, body: MovingLink) -> tuple[list[Vector], Vector]:
        """Axes and point of a joint on a link, in the axes of the ground."""
        axes = body.axes
        if mount.axes is not None:
            axes = [combine(body.axes, [*map(self._scalar, axis)]) for axis in mount.axes]
        return axes, plus(body.origin, combine(body.axes, [*map(self._scalar, mount.point)]))

    def _attach(self, pair: Pair, parent: str, child: str, sign: float) -> None:
        given = self._dimensions
        states, columns = given.states[pair.name], given.velocities[pair.name]
        own = [self._later(STATE, k) for k in range(states.start, states.stop)]
        axes, here = self._mounted(given.mounts[pair.name, parent], self.bodies[parent])
        pitch = self._scalar(given.pitches.get(pair.name, 0.0))
        step = motion_at(pair.kind, own, pitch)
        first, second, first_point, second_point = axes, axes, here, here
        if sign < 0.0:
            first = step.rotated_back(second)
            first_point = minus(here, combine(first, step.shift))
        else:
            second = step.rotated(first)
            second_point = plus(here, combine(first, step.shift))
        self.frames[pair.name] = first, first_point, second, second_point
        own_axes, own_point = (first, first_point) if sign < 0.0 else (second, second_point)
        self.bodies[child] = MovingLink(own_point, own_axes)
        for component in pair.kind.coordinates:
            carrier = 1 if (pair.kind.name, component) == ("universal", "rx") else 0
            axis = (second if carrier else first)["xyz".index(component[1])]
            angular: Vector = axis if component[0] == "r" else [0.0, 0.0, 0.0]
            linear: Vector = axis if component[0] == "u" else [0.0, 0.0, 0.0]
            if pair.kind.tied:
                linear = times(pitch, axis)
            self._columns.append(Column(sign, angular, linear, second_point, carrier))
        self._paths[child] = self._paths[parent] | set(range(columns.start, columns.stop))

    def _joined(self, pair: Pair) -> Joined:
        mounts = self._dimensions.mounts
        first, here = self._mounted(mounts[pair.name, pair.first], self.bodies[pair.first])
        second, there = self._mounted(mounts[pair.name, pair.second], self.bodies[pair.second])
        return first, here, second, there

    # -- loops ------------------------------------------------------------------------------------------------------

    @cached_property
    def equations(self) -> ClosingEquations:
        """The closing equations, which of them are solved, and their pattern."""
        rows = range(len(self.rows))
        acting = [i for i in rows if any(map(_acts, self.jacobian[i]))]
        active = [i for i in rows if any(_acts(self.jacobian[i][k]) for k in self.unknown)]
        there = [_acts(self.jacobian[i][k]) for i in active for k in self.unknown]
        pattern = np.array(there, dtype=bool).reshape(len(active), len(self.unknown))
        places = [(i, k) for i, row in enumerate(acting) for k, x in enumerate(self.jacobian[row]) if _acts(x)]
        acting_rows, columns = np.array(places, dtype=np.intp).reshape(-1, 2).T
        return ClosingEquations(self.rows, acting, active, pattern, (acting_rows, columns))

    @cached_property
    def closing(self) -> tuple[list[Scalar], list[Scalar], list[Scalar]]:
        """Active residuals, and the entries of their Jacobian by the unknowns and by the drives, row by row."""
        rows = self.equations.active
        return (
            [self.residual[i] for i in rows],
            [self.jacobian[i][k] for i in rows for k in self.unknown],
            [self.jacobian[i][k] for i in rows for k in self.driven],
        )

    @property
    def acting_closure(self) -> list[Scalar]:
        """Residuals of the acting rows, then the entries of their Jacobian that are not identically zero."""
        acting, places = self.equations.acting, zip(*self.equations.acting_places, strict=True)
        return [*(self.residual[i] for i in acting), *(self.jacobian[acting[i]][k] for i, k in places)]

    # -- outputs of programs ----------------------------------------------------------------------------------------

    def pose_of(self, links: Iterable[str]) -> list[Scalar]:
        """Reference point and axes of each link, twelve numbers."""
        return [x for link in links for v in (self.bodies[link].origin, *self.bodies[link].axes) for x in v]

    def point_of(self, link: str, kept: tuple[int, ...]) -> list[Scalar]:
        """Position of a point of a link, by its arm's nonzero components `kept` and the size, which are inputs."""
        body, given = self.bodies[link], [self._later(FURTHER, k) for k in range(len(kept) + 1)]
        there: Vector = [0.0, 0.0, 0.0]
        for k, x in zip(kept, given, strict=False):
            there = plus(there, times(x, body.axes[k]))
        return times(given[-1], plus(body.origin, there))

    def rates_of(self, links: Iterable[str]) -> list[Scalar]:
        """ω, velocity of the reference point, α, and acceleration of the reference point, of each link."""
        moves = [self._moving[1][link] for link in links]
        return [x for own in moves for v in (own.omega, own.v, own.alpha, own.a) for x in v]

    @property
    def bias(self) -> list[Scalar]:
        """Second time derivatives of the active rows."""
        return [self._moving[0][i] for i in self.equations.active]

    @cached_property
    def _moving(self) -> tuple[list[Scalar], dict[str, Rates]]:
        given = self._dimensions
        v, w = ([self._later(group, k) for k in range(len(self._columns))] for group in (VELOCITIES, CHANGES))
        rates = rates_of(given.tree, self.bodies, self.frames, self._columns, given.velocities, v, w)
        bias = [
            x for pair, joined in self._cuts for x in closing_bias(pair, joined, rates[pair.first], rates[pair.second])
        ]
        return bias, rates


def _acts(entry: Scalar) -> bool:
    return isinstance(entry, Term) or entry != 0.0
