"""Newton's method on one entry, recorded as a program with all its iterations.

What is recorded are the formulas of `PlanarEquations` and `EquilibriumEquations`, carried out on terms in place of
numbers. The program does not find out whether a tangent with a pivot that is not positive is singular by rounding.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..ldl import eliminated, substitute
from ..program.arranging import arranged
from ..program.program import Operation, Program
from ..program.recording import Recording, Term, choose
from .elimination import CLEAR, SymbolicFactorisation
from .equations import EquilibriumEquations
from .model import CONSTRAINED, Model
from .planar_equations import PlanarEquations
from .state import DisplacedState, Index, PlanarState, StateOfEntries

# Work of the last Newton step, relative to the strain energy: squared again by the step itself.
CLOSE = 1e-16
# Iterations after which an entry is given up: one that has not converged by then takes fewer in smaller steps.
ITERATIONS = 16
# Longest step, and one that is nothing, in radians or sizes of the frame.
LONGEST, NOTHING = 1.0, 1e-13
# Share of what a constraint resists alone that is left where others resist the same.
_INDEPENDENT = 1e-9
_LARGEST = float(np.finfo(np.float64).max)


def moved(model: Model, columns: Index, at: StateOfEntries) -> list[int]:
    """The numbers of a state that steps of the coordinates (k, nodes) change, multipliers included.

    `at` is a state of one entry that holds their places, counted through the state.
    """
    slides = len(columns) // 3 + 1
    out: list[int] = []
    for node in range(model.count):
        free = [k for k in range(len(columns)) if columns[k, node] != CONSTRAINED]
        if node in model.link_of:
            out += _places(at.own[free, model.link_of[node]])
            continue
        out += _places(at.displacements[[k for k in free if k < slides], node])
        if free and free[-1] >= slides:
            out += _places(at.rotations[..., node, :])
    ideal, loops = np.nonzero(model.multipliers >= 0)
    return out + _places(at.own[ideal, len(model.joints) + loops])


def constants(model: Model, at: StateOfEntries) -> list[int]:
    """The numbers of a state that steps leave as they are: what rigid contacts are taken to carry."""
    out: list[int] = []
    for number, place in model.contacts.items():
        out += _places(at.contact_force[list(model.edges[number].clearance_directions), place])
        out += _places(at.contact_stiffness[place])
    return out


def carried(model: Model, at: StateOfEntries) -> list[int]:
    """The numbers of a state that nodes attached to others take from these."""
    out: list[int] = []
    for joint in model.joints:
        out += _places(at.displacements[:, joint.child]) + _places(at.rotations[..., joint.child, :])
    return out


def _places(numbers: NDArray[Any]) -> list[int]:
    return [int(number) for number in numbers.reshape(-1)]


@dataclass(frozen=True)
class RecordedNewton:
    """Newton's method written down for a model.

    Attributes
    ----------
    program
        It takes the numbers of the equations, the inverse of the frame's length, the largest residual of prescribed
        coordinates, whether the first tangent holds the members' stresses there (1 or 0), then the numbers of the
        state: those that steps change, and those that stay as they are. It makes the former and those of nodes that are
        attached to others, whether that is an equilibrium, whether all pivots were above `CLEAR` in the last step, not
        the first, and the number of steps. Where joints have clearance, pivots are to be above rounding, and be it in
        the first step.
    places
        Which of these numbers it takes: those that bear on the result.
    given, made
        Which numbers of a state, laid out flat, it takes and makes.
    """

    program: Program
    places: list[int]
    given: list[int]
    made: list[int]


class NewtonRecording:
    """A recording of Newton's method.

    Parameters
    ----------
    recording
        Where it is written down.
    equations
        The equations of one entry, their numbers terms of the recording.
    elimination
        Order of the elimination.
    """

    def __init__(
        self,
        recording: Recording,
        equations: PlanarEquations | EquilibriumEquations,
        elimination: SymbolicFactorisation,
    ) -> None:
        self.recording, self.elimination, self.model = recording, elimination, equations.model
        self.equations: Any = equations
        self.flat = isinstance(equations, PlanarEquations)
        self.start: StateOfEntries = (PlanarState if self.flat else DisplacedState).start(self.model, 1)
        numbers = self.start.like(np.arange(float(len(self.start.flat())))[:, None])
        self.moved, self.carried = moved(self.model, equations.columns, numbers), carried(self.model, numbers)
        self.constant = constants(self.model, numbers)
        self.constraints = sorted(elimination.constrained)
        self.translations = set(self.model.columns[:3].reshape(-1).tolist())
        self.inverse_size, self.least, self.stressed = self._later(), self._later(), self._later()

    def recorded(self) -> RecordedNewton:
        """The method as a program."""
        begin = [self._later() for _ in self.moved]
        self.known = [self._later() for _ in self.constant]
        yes = self.recording.write(Operation.LESS, 0.0, 1.0)
        exact = self.equations.stresses(self._state(begin))
        self._shapes = [stress.shape for stress in exact]
        stresses = [term for stress in exact for term in stress.reshape(-1)]
        if self.model.has_clearance:
            stresses = [choose(self.stressed < 1.0, 0.0, each) for each in stresses]
        begins = [*begin, *stresses, yes, ~yes, ~yes, 0.0]
        _, after = self.recording.rounds(begins, self._round, ITERATIONS)
        state = self._state(after[: len(begin)])
        outputs = [*after[: len(begin)], *state.flat()[self.carried, 0], *after[-3:]]
        program, places = self.recording.program([self._term(x) for x in outputs])
        # What a round begins with varies, whatever it begins with first.
        program = program.over(program.masks[: program.given])
        given, made = [*self.moved, *self.constant], [*self.moved, *self.carried]
        return RecordedNewton(arranged(program), places, given, made)

    def _later(self) -> Any:
        return cast(Any, self.recording.later(1))

    def _state(self, values: list[Any]) -> Any:
        """The state with these numbers, in which links carry their nodes along."""
        numbers = self.start.flat().astype(object)
        numbers[[*self.moved, *self.constant], 0] = [*values, *self.known]
        state = self.start.like(numbers)
        self.equations.follow(state)
        return state

    def _round(self, begins: list[Any]) -> tuple[list[Any], Any]:
        n = len(self.moved)
        values, (moving, converged, definite, count) = begins[:n], begins[-4:]
        state = self._state(values)
        at = self.equations.linearised(state, self._stresses(begins[n:-4]))
        first = count < 1.0
        limit = (
            CLEAR
            if self.constraints
            else self.elimination.free
            if self.model.has_clearance
            else choose(first, self.elimination.free, CLEAR)
        )
        step, positive = self._solved(at, self.equations.prescribed_residual(state), limit)
        usable = positive | ~first
        for each in step:
            usable = usable & (abs(each) <= _LARGEST)
        step = [choose(usable, each, 0.0) for each in step]
        largest = self._largest(step)
        share = 1.0 / np.maximum(largest / LONGEST, 1.0)
        close = usable & (largest <= LONGEST) & self._close(at.forces[:, 0], at.energy[0], step, largest, first)
        whole = np.array([[share * each] for each in step], dtype=object)
        ahead = self.equations.advanced(state, whole)
        new = [choose(moving, a, b) for a, b in zip(ahead.flat()[self.moved, 0], values, strict=True)]
        clear = positive if self.constraints or self.model.has_clearance else positive & ~first
        converged, definite = choose(moving, close, converged), choose(moving, clear, definite)
        count = choose(moving, count + 1.0, count)
        moving = moving & usable & ~close
        predicted = [term for stress in self.equations.step_stresses(at, whole) for term in stress.reshape(-1)]
        return [*new, *predicted, moving, converged, definite, count], moving

    def _stresses(self, flat: list[Any]) -> list[Array]:
        out = []
        for shape in self._shapes:
            size = int(np.prod(shape))
            part = np.empty(size, dtype=object)
            part[:] = flat[:size]
            out.append(part.reshape(shape))
            flat = flat[size:]
        return out

    def _largest(self, step: list[Any]) -> Any:
        """Largest component of a step, in radians or sizes of the frame."""
        largest: dict[bool, Any] = {}
        for column, each in enumerate(step):
            if column in self.constraints:
                continue
            size, slides = abs(each), column in self.translations
            largest[slides] = np.maximum(largest[slides], size) if slides in largest else size
        if True in largest:
            largest[True] = largest[True] * self.inverse_size
        values = list(largest.values())
        return values[0] if len(values) == 1 else np.maximum(*values)

    def _close(self, forces: NDArray[Any], energy: Any, step: list[Any], largest: Any, first: Any) -> Any:
        """Whether the work of the unbalanced forces on the step, or the step itself, is nothing."""
        work = abs(sum((force * each for force, each in zip(forces, step, strict=True)), 0.0))
        near = (work <= CLOSE * energy) & (energy > 0.0)
        for each in step[self.model.free :]:
            near = near & (abs(each) <= self.least)
        return near | (largest <= choose(first, 0.0, NOTHING))

    def _solved(self, at: Any, residual: Array, limit: Any) -> tuple[list[Any], Any]:
        """Newton's step, and whether all pivots are above a limit, in units of the diagonal."""
        free, order, values, forces = self.model.free, self.elimination, at.values, at.forces
        load = np.array([[-force] for force in forces[:free, 0]], dtype=object)
        prescribed = residual[:, 0].tolist()
        for which, row, column in zip(*(each.tolist() for each in order.prescribed), strict=True):
            load[row, 0] = load[row, 0] - values[which, 0] * prescribed[column]
        work = np.full((order.entries, 1), 0.0, dtype=object)
        work[order.goal] = values[order.inside[order.source]]
        weights = self._stiffened(work[:, 0], load[:, 0])
        least = [limit * abs(work[k, 0]) for k in range(order.first_constraint)]
        columns = eliminated(work, order.steps)
        positive: Any = self.recording.write(Operation.LESS, 0.0, 1.0)
        for step in order.steps:
            k = step.unknown
            pivot = self._term(work[k, 0])
            positive = positive & (-pivot * weights[k] > _INDEPENDENT if k in weights else pivot > least[k])
        substitute(order.steps, columns, load)
        return [self._term(each) for each in (*load[:, 0], *prescribed)], positive

    def _stiffened(self, work: NDArray[Any], load: NDArray[Any]) -> dict[int, Any]:
        """Springs that resist what constraints forbid, by constraint, added to the matrix and to the loads.

        They change no solution, and leave positive pivots where the constraints alone hold something (M. R. Hestenes,
        J. Optim. Theory Appl. 4 (1969) 303-320). They are as stiff as the stiffest coordinate.
        """
        order = self.elimination
        if not self.constraints:
            return {}
        units = {k: self.inverse_size if k in self.translations else 1.0 for k in range(order.first_constraint)}
        stiffest: Any = 0.0
        for k, unit in units.items():
            stiffest = np.maximum(stiffest, abs(work[k]) / (unit * unit))
        out = {}
        for number in self.constraints:
            coupled = order.constrained[number]
            row = {k: work[order.place[number, k]] for k in coupled}
            size = sum(((each / units[k]) * (each / units[k]) for k, each in row.items()), 0.0)
            weight = out[number] = stiffest / size
            for place, i in enumerate(coupled):
                pushed = weight * row[i]
                load[i] = load[i] + pushed * load[number]
                for j in coupled[: place + 1]:
                    at = order.place[max(i, j), min(i, j)]
                    work[at] = work[at] + pushed * row[j]
        return out

    def _term(self, value: Any) -> Any:
        return value if isinstance(value, Term) else self.recording.constant(float(value))
