"""Newton's method on one entry written down as a program, its rounds and all.

What is recorded is what `PlanarEquations` says, whose formulas are carried out on terms. The program finds an
equilibrium or gives up; it tells nothing of tangents that are not positive definite.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..program.program import Operation
from ..program.recording import Recording, Term, choose
from .elimination import SymbolicFactorisation
from .joint_law import ContactMultipliers
from .limits import CLOSE, ITERATIONS, LONGEST, NOTHING
from .model import HELD
from .numbers import Numbers, Where
from .planar import PlanarEquations
from .planar_model import PlanarModel
from .planar_state import PlanarState

_LARGEST = float(np.finfo(np.float64).max)
# Numbers that stand in a program where a value is that for all entries.
_PLAIN = (0.0, 1.0, -1.0)


@dataclass(frozen=True)
class Given:
    """Numbers of a model that a program takes.

    Attributes
    ----------
    numbers
        The numbers.
    places
        Which of the components, flattened, are given; the others are 0, 1 or -1 everywhere.
    loaded
        Whether they are multiplied by the share of the loads.
    """

    numbers: Numbers
    places: tuple[int, ...]
    plain: tuple[float, ...]
    loaded: bool

    @classmethod
    def of(cls, numbers: Numbers, *, loaded: bool = False) -> Given:
        """What of some numbers has to be given."""
        array, ndim = numbers.array, numbers.ndim
        rows = array.reshape(-1, int(np.prod(array.shape[array.ndim - ndim :], dtype=np.int64)))
        first = rows[:, 0]
        alike = (rows == first[:, None]).all(axis=1) & np.isin(first, _PLAIN[:1] if loaded else _PLAIN)
        plain = np.where(alike, first, np.nan)
        return cls(numbers, tuple(np.flatnonzero(~alike).tolist()), tuple(plain.tolist()), loaded)

    @property
    def varies(self) -> bool:
        """Whether they vary over the batch."""
        shape = self.numbers.array.shape
        return max(shape[len(shape) - self.numbers.ndim :], default=1) > 1

    @property
    def key(self) -> tuple[object, ...]:
        """What the program depends on."""
        shape = self.numbers.array.shape
        told = tuple(x if x == x else None for x in self.plain)
        return shape[: len(shape) - self.numbers.ndim], told, self.varies

    def terms(self, recording: Recording) -> Numbers:
        """The numbers as terms of a recording, of one batch axis."""
        shape = self.numbers.array.shape[: self.numbers.array.ndim - self.numbers.ndim]
        out = np.array(self.plain, dtype=object)
        for place in self.places:
            out[place] = recording.later(int(self.varies))
        return Numbers(out.reshape(*shape, 1), 1)

    def at(self, where: Where, factor: float) -> list[Array]:
        """The given values at some entries, (m,) or (1,) each."""
        if not self.places:
            return []
        found = self.numbers.at(where)
        rows = found.reshape(-1, found.shape[-1])[list(self.places)]
        return list(np.ascontiguousarray(factor * rows if self.loaded else rows))


class PlanarNumbers:
    """What a program takes of a model in the plane, in the order in which it takes it.

    Parameters
    ----------
    model
        The model.
    """

    def __init__(self, model: PlanarModel) -> None:
        self.model = model
        self.stacks = [tuple(map(Given.of, (s.direction, s.length, s.stiffness))) for s in model.stacks]
        self.joints = [
            (*map(Given.of, (j.axes, j.sense, j.arm, j.stiffness)), Given.of(j.offset, loaded=True))
            for j in model.joints
        ]
        self.loads = Given.of(model.loads, loaded=True)
        self.prescribed = [Given.of(model.model.prescribed_values[key], loaded=True) for key in model.model.prescribed]

    @property
    def all(self) -> list[Given]:
        """All of them, in order."""
        parts = [each for part in (*self.stacks, *self.joints) for each in part]
        return [*parts, self.loads, *self.prescribed]

    @property
    def key(self) -> tuple[object, ...]:
        """What the program depends on beside the model's structure."""
        return tuple(each.key for each in self.all)

    def equations(self, recording: Recording) -> PlanarEquations:
        """The equations of one entry, of which the numbers are terms."""
        model = copy(self.model)
        model.stacks = [
            replace(stack, direction=a.terms(recording), length=b.terms(recording), stiffness=c.terms(recording))
            for stack, (a, b, c) in zip(self.model.stacks, self.stacks, strict=True)
        ]
        model.joints = [
            replace(
                joint,
                **{name: each.terms(recording) for name, each in zip(_JOINT, given, strict=True)},  # type: ignore[arg-type]
            )
            for joint, given in zip(self.model.joints, self.joints, strict=True)
        ]
        model.loads = self.loads.terms(recording)
        out = PlanarEquations(model, (np.zeros(1, dtype=np.int64),), 1)
        values = [each.terms(recording).array for each in self.prescribed]
        out.prescribed_values = np.concatenate([np.zeros((0, 1), dtype=object), *(v.reshape(1, 1) for v in values)])
        return out

    def values(self, where: Where, factor: float) -> list[Array]:
        """What is given at some entries."""
        return [row for each in self.all for row in each.at(where, factor)]


_JOINT = ("axes", "sense", "arm", "stiffness", "offset")


@dataclass(frozen=True)
class Coordinate:
    """A number of the state that is unknown or prescribed: of a plain node, or of a link's own displacement."""

    component: int
    node: int
    link: int
    column: int

    def of(self, state: PlanarState) -> Any:
        """Its value (m,)."""
        if self.link >= 0:
            return state.own[self.component, self.link]
        return state.displacements[self.component, self.node] if self.component < 2 else state.rotations[self.node]

    def put(self, state: PlanarState, value: Any) -> None:
        """Change its value."""
        if self.link >= 0:
            state.own[self.component, self.link] = value
        elif self.component < 2:
            state.displacements[self.component, self.node] = value
        else:
            state.rotations[self.node] = value


def coordinates(model: PlanarModel) -> list[Coordinate]:
    """The numbers of a state that steps change."""
    links = {joint.joint.child: number for number, joint in enumerate(model.joints)}
    return [
        Coordinate(k, node, links.get(node, -1), int(model.columns[k, node]))
        for node in range(model.model.count)
        for k in range(3)
        if model.columns[k, node] != HELD
    ]


class RecordedNewton:
    """Newton's method written down for a model in the plane.

    Parameters
    ----------
    numbers
        Numbers that it takes.
    elimination
        Order of the elimination.
    zero
        Pivot, in units of the diagonal, that is rounding.

    Attributes
    ----------
    program
        It takes what `PlanarNumbers` gives, then the inverse of the frame's length and the largest residual of
        prescribed coordinates, then the coordinates at the beginning. It makes the coordinates, the displacements and
        angles of nodes that are attached to others, whether that is a stable equilibrium, and the number of steps.
    """

    def __init__(self, numbers: PlanarNumbers, elimination: SymbolicFactorisation, zero: float) -> None:
        self.elimination, self.zero = elimination, zero
        self.recording = Recording(fixed=True)
        self.equations = numbers.equations(self.recording)
        self.model = numbers.model
        self.coordinates = coordinates(self.model)
        self.inverse_size, self.least = self._later(), self._later()
        begin = [self._later() for _ in self.coordinates]
        yes = self.recording.write(Operation.LESS, 0.0, 1.0)
        no = ~yes
        exact = self.equations.linearised(self._state(begin)).stresses
        flat = [term for stress in exact for term in stress.reshape(-1)]
        begins = [*begin, *flat, yes, no, 0.0]
        _, after = self.recording.rounds(begins, self._round, ITERATIONS)
        n = len(begin)
        state = self._state(after[:n])
        children = [joint.joint.child for joint in self.model.joints]
        attached = [state.displacements[k, child, 0] for child in children for k in range(2)]
        attached += [state.rotations[child, 0] for child in children]
        outputs = [*after[:n], *attached, *after[-2:]]
        program, self.places = self.recording.program([self._term(x) for x in outputs])
        # What a round begins with varies, whatever it begins with first.
        self.program = program.over(program.masks[: program.given])

    def state(self, outs: list[Array], before: PlanarState) -> PlanarState:
        """The state from what the program has made of that `before`, (m,) each."""
        out = replace(
            before,
            displacements=before.displacements.copy(),
            rotations=before.rotations.copy(),
            own=before.own.copy(),
        )
        for coordinate, value in zip(self.coordinates, outs, strict=False):
            coordinate.put(out, value)
        children = [joint.joint.child for joint in self.model.joints]
        places = outs[len(self.coordinates) :]
        for number, child in enumerate(children):
            out.displacements[:, child] = places[2 * number : 2 * number + 2]
            out.rotations[child] = places[2 * len(children) + number]
        return out

    def _later(self) -> Any:
        return cast(Any, self.recording.later(1))

    def _state(self, values: list[Any]) -> PlanarState:
        """The state with these coordinates, in which links carry their nodes along."""
        model = self.model.model
        count, links = model.count, len(self.model.joints)
        state = PlanarState(_none(2, count, 1), _none(count, 1), _none(3, links, 1), ContactMultipliers.none(0, 1))
        for coordinate, value in zip(self.coordinates, values, strict=True):
            coordinate.put(state, value)
        self.equations.follow(state)
        return state

    def _round(self, begins: list[Any]) -> tuple[list[Any], Any]:
        n = len(self.coordinates)
        values, (moving, good, count) = begins[:n], begins[-3:]
        state, stresses = self._state(values), self._stresses(begins[n:-3])
        at = self.equations.linearised(state, stresses)
        residual = self.equations.prescribed_residual(state)
        step, positive = self._solved(at.values, at.forces, residual)
        first = count < 1.0
        usable = positive | ~first
        for each in step:
            usable = usable & (abs(each) <= _LARGEST)
        step = [choose(usable, each, 0.0) for each in step]
        largest = self._largest(step)
        share = 1.0 / np.maximum(largest / LONGEST, 1.0)
        close = usable & (largest <= LONGEST) & self._close(at.forces[:, 0], at.energy[0], step, largest, first)
        moved = [share * each for each in step]
        predicted = self.equations.step_stresses(at, np.array(moved, dtype=object)[:, None])
        new = [value + moved[c.column] for c, value in zip(self.coordinates, values, strict=True)]
        new = [choose(moving, a, b) for a, b in zip(new, values, strict=True)]
        good = choose(moving, close & positive, good)
        count = choose(moving, count + 1.0, count)
        moving = moving & usable & ~close
        flat = [term for stress in predicted for term in stress.reshape(-1)]
        return [*new, *flat, moving, good, count], moving

    def _stresses(self, flat: list[Any]) -> list[Array]:
        out, place = [], 0
        for stack in self.model.stacks:
            size = 3 * len(stack.ends)
            out.append(np.array(flat[place : place + size], dtype=object).reshape(3, -1, 1))
            place += size
        return out

    def _largest(self, step: list[Any]) -> Any:
        """Largest component of a step, in radians or sizes of the frame."""
        largest: dict[bool, Any] = {}
        for coordinate in self.coordinates:
            # Own coordinates of links stand where the model in space has them.
            place = self.model.model.columns[:3] == coordinate.column
            size = abs(step[coordinate.column])
            slides = bool(place.any())
            largest[slides] = np.maximum(largest[slides], size) if slides in largest else size
        if True in largest:
            largest[True] = largest[True] * self.inverse_size
        values = list(largest.values())
        return values[0] if len(values) == 1 else np.maximum(*values)

    def _close(self, forces: NDArray[Any], energy: Any, step: list[Any], largest: Any, first: Any) -> Any:
        """Whether the work of the unbalanced forces on the step, or the step itself, is nothing."""
        work = abs(sum((force * each for force, each in zip(forces, step, strict=True)), 0.0))
        near = (work <= CLOSE * energy) & (energy > 0.0)
        for each in step[self.model.model.free :]:
            near = near & (abs(each) <= self.least)
        return near | (largest <= choose(first, 0.0, NOTHING))

    def _solved(self, values: Array, forces: Array, residual: Array) -> tuple[list[Any], Any]:
        """Newton's step, and whether all pivots are positive."""
        free, order = self.model.model.free, self.elimination
        load = [-force for force in forces[:free, 0]]
        prescribed = residual[:, 0].tolist()
        for which, row, column in zip(*(each.tolist() for each in order.prescribed), strict=True):
            load[row] = load[row] - values[which, 0] * prescribed[column]
        work: list[Any] = [0.0] * order.entries
        for goal, inside in zip(order.goal.tolist(), order.inside.tolist(), strict=True):
            work[goal] = values[inside, 0]
        least = [self.zero * abs(work[k]) for k in range(order.size)]
        positive: Any = self.recording.write(Operation.LESS, 0.0, 1.0)
        done: list[tuple[int, list[int], list[Any], Any]] = []
        for k, below, column, target, first, second in order.steps:
            pivot = self._term(work[k])
            positive = positive & np.less(least[k], pivot)
            inverse = 1.0 / pivot
            entries = [work[place] for place in column.tolist()]
            low = [entry * inverse for entry in entries]
            for place, i, j in zip(target.tolist(), first.tolist(), second.tolist(), strict=True):
                work[place] = work[place] - low[i] * entries[j]
            for i, each in zip(below, low, strict=True):
                load[i] = load[i] - each * load[k]
            done.append((k, below, low, inverse))
        for k, below, low, inverse in reversed(done):
            load[k] = load[k] * inverse
            for i, each in zip(below, low, strict=True):
                load[k] = load[k] - each * load[i]
        return [self._term(each) for each in (*load, *prescribed)], positive

    def _term(self, value: Any) -> Any:
        return value if isinstance(value, Term) else self.recording.constant(float(value))


def _none(*shape: int) -> Array:
    return np.zeros(shape).astype(object)
