"""Newton's method on the loops recorded as programs, iterations included, to run as machine code on long batches.

The programs do the same operations as `Loops`. A pose that they do not close, for whatever reason, is left to
`Loops.close_all`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Protocol, cast

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Shape
from ....framework.cache import KERNELS
from ....framework.program.calculation import Choice, choose
from ....framework.program.program import Operation, Program
from ....framework.program.recording import Recording, done
from ....framework.program.source import Functions, Places, calculation
from .equations import LEAST_PIVOT_RATIO, Equations
from .linear import Linear
from .mechanism import Mechanism
from .terms import Value

Mask = NDArray[np.bool_]


class ClosingArithmetic(Protocol):
    """The part of `Loops` that works on arrays and on recorded terms alike."""

    mechanism: Mechanism
    linear: Linear
    rows: int
    columns: int
    iterations: int
    singles: list[tuple[int, int]]
    spherical: list[tuple[int, int]]
    driven_states: list[int]
    driven_spherical: list[int]

    @property
    def equations(self) -> Equations:
        """Programs of the Newton step."""
        ...

    @property
    def unknown_states(self) -> list[int]:
        """Entries of the state that the drives do not give."""
        ...

    def placed(self, unknown: Sequence[Any], state: Sequence[Any]) -> list[Any]:
        """A state with these values of the unknowns."""
        ...

    def unit(self, state: list[Any]) -> list[Any]:
        """A state with Euler parameters of unit length."""
        ...

    def contracted(
        self, step: Sequence[Any], state: list[Any], trusted: Any, moving: Any, before: Any
    ) -> tuple[list[Any], Any, Any, Any]:
        """An iteration of `Loops.close_all`."""
        ...

    def converged(self, before: Any) -> Any:
        """Whether the last step was small enough."""
        ...

    def approached(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, first: Any, last: Any
    ) -> tuple[list[Any], Any, Any, Any, Any]:
        """An iteration of `Loops.poses`."""
        ...

    def arrived(
        self, step: Sequence[Any], state: list[Any], good: Any, moving: Any, last: Any
    ) -> tuple[list[Any], Any, Any]:
        """The last step of `Loops.poses`."""
        ...

    def velocities_of(self, entries: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """All velocity coordinates."""
        ...

    def accelerations_of(self, jacobian: Sequence[Any], bias: Sequence[Any], drives: Sequence[Any]) -> list[Any]:
        """Time derivatives of all velocity coordinates."""
        ...

    def standing(self, drives: Sequence[Any]) -> list[Any]:
        """Derivatives of the velocity coordinates if only the drives move."""
        ...


@dataclass(frozen=True, eq=False)
class RecordedProgram:
    """A recorded program with the places of its inputs and outputs.

    Attributes
    ----------
    program
        The program.
    given
        Group and place in it of each given value.
    outputs
        Number of outputs in each part of the result.
    """

    program: Program
    given: tuple[tuple[int, int], ...]
    outputs: tuple[int, ...]

    def choice(self, shape: Shape) -> Choice:
        """The back end for values that vary over the whole batch."""
        whole = (1 << len(shape)) - 1
        return choose(self.program.over([whole] * self.program.given), shape)

    def run(self, inputs: Sequence[Sequence[Value]], shape: Shape) -> tuple[list[list[Any]], str] | None:
        """Results over a batch, part by part, and why machine code makes them; None where that does not pay."""
        work = calculation(self.program, [inputs[group][place] for group, place in self.given], shape)
        if work is None:
            return None
        with np.errstate(all="ignore"):
            outs = work.results()
        whole = [out if np.shape(out) == shape else np.array(np.broadcast_to(out, shape)) for out in outs]
        cuts = np.cumsum((0, *self.outputs)).tolist()
        return [whole[a:b] for a, b in pairwise(cuts)], work.choice.reason


class Closing:
    """Recorded programs that close loops; each documents its inputs by group, then its results.

    Parameters
    ----------
    loops
        The loops.
    """

    def __init__(self, loops: ClosingArithmetic) -> None:
        self.loops = loops
        self.residual = loops.mechanism.residual
        self.step = loops.equations.written(0)
        # Everything that the programs depend on beside the functions in them.
        states = loops.singles, loops.spherical, loops.driven_spherical, loops.driven_states
        columns = loops.mechanism.unknown, loops.mechanism.driven, loops.linear.pattern.tobytes()
        self._layout = loops.mechanism.entries, repr(states), repr(columns)

    @property
    def shares(self) -> list[float]:
        """Inverse sizes of the reference pivots, if the equations are solved by a recorded elimination; else none."""
        return self.loops.equations.shares if self.step is not None and self.step[1] else []

    def close(self) -> RecordedProgram | None:
        """(guess, parameters, shares) to the unknown states, `trusted`, and the determinants."""
        return self._found("close", self._close)

    def poses(self) -> RecordedProgram | None:
        """(guess, parameters, shares) to results of `Loops.poses`.

        States, follow, determinants, first and last step, good.
        """
        exact = self.loops.equations.written(len(self.loops.mechanism.driven))
        return None if exact is None else self._found("poses", self._poses, exact[0])

    def sweep(self) -> RecordedProgram | None:
        """(driven states, parameters, shares, tables of `continuation.sweep`) to poses along a path."""
        return self._found("sweep", self._sweep, self.residual)

    def rates(self) -> RecordedProgram | None:
        """(state, parameters, -, rates and accelerations of the drives) to velocity coordinates and their derivatives.

        None where the equations are not solved by Cramer's rule.
        """
        mechanism = self.loops.mechanism
        if not self.loops.linear.compact:
            return None
        return self._found("rates", self._rates, mechanism.full, mechanism.bias)

    def gap(self) -> RecordedProgram:
        """(state, parameters) to the closure error."""
        key = "gap", *_told(self.residual)
        made: RecordedProgram = KERNELS.found(key, self._gap, len(self.residual.program.steps))
        return made

    def _found(self, what: str, make: Callable[[], RecordedProgram], *also: Functions) -> RecordedProgram | None:
        """A program made of the Newton step and of other functions, kept by content."""
        if self.step is None:
            return None
        parts = self.step[0], *also
        key = what, self.step[1], self._layout, *(part for functions in parts for part in _told(functions))
        weight = 2 * sum(len(functions.program.steps) for functions in parts)
        made: RecordedProgram = KERNELS.found(key, make, weight)
        return made

    # -- recording ---------------------------------------------------------------------------------------------------

    def _close(self) -> RecordedProgram:
        sheet = _ProgramRecording(self.loops)
        state, trusted, determinants = self._rounds(sheet, list(sheet.state))
        return sheet.written([self._unknown(state), [trusted], determinants])

    def _gap(self) -> RecordedProgram:
        sheet = _ProgramRecording(self.loops)
        return sheet.written([[self._error(sheet, sheet.state)]])

    def _rates(self) -> RecordedProgram:
        loops, sheet = self.loops, _ProgramRecording(self.loops)
        mechanism = loops.mechanism
        drives, changes = (sheet.more(len(mechanism.driven)) for _ in range(2))
        entries = sheet.done(mechanism.full, sheet.state)
        v = loops.velocities_of(entries, drives)
        bias = sheet.done(mechanism.bias, sheet.state, v, loops.standing(changes))
        return sheet.written([v, loops.accelerations_of(entries[loops.rows :], bias, changes)])

    def _sweep(self) -> RecordedProgram:
        """Close guesses by the cubic between the nodes of a path; good are poses that are closed on its branch."""
        loops, sheet = self.loops, _ProgramRecording(self.loops)
        recording, unknown = sheet.recording, loops.unknown_states
        along, least = sheet.more(2)
        nodes = sheet.more(1)[0]
        table = iter(sheet.more(3 + 4 * len(unknown) + loops.linear.signs))
        place = np.maximum(recording.search(nodes, along) - 1.0, 0.0)

        def here() -> Any:
            return recording.look_up(next(table), place)

        plain, begin, h = here(), here(), here()
        t = (along - begin) / h
        tt, back = t * t, (1.0 - t) * (1.0 - t)
        p, q = (1.0 + 2.0 * t) * back, t * back * h
        u, v = tt * (3.0 - 2.0 * t), tt * (t - 1.0) * h
        guess = list(sheet.state)
        for k in unknown:
            guess[k] = (p * here() + q * here()) + (u * here() + v * here())
        state, good, determinants = self._rounds(sheet, loops.unit(guess))
        good = good & (plain > 0.0)
        for determinant in determinants:
            good = good & (determinant * here() >= 0.0)
        error = self._error(sheet, state)
        return sheet.written([self._unknown(state), [good & (error < least)], [error]])

    def _rounds(self, sheet: _ProgramRecording, state: list[Any]) -> tuple[list[Any], Any, list[Any]]:
        """State, `trusted` and determinants by Newton's method from a guess."""
        loops, n = self.loops, self.loops.columns
        assert self.step is not None
        functions, pivots = self.step

        def one(begins: list[Any]) -> tuple[list[Any], Any]:
            *entries, sure, trusted, moving, before = begins
            at = loops.placed(entries, state)
            found = sheet.done(functions, at)
            if pivots:
                sure = sure & ~(moving & ~_firm(sheet.shares, found[-pivots:]))
            at, trusted, moving, before = loops.contracted(found[:n], at, trusted, moving, before)
            return [*self._unknown(at), sure, trusted, moving, before], moving

        yes = sheet.yes
        begins = [*self._unknown(state), yes, yes, yes, np.inf]
        before, after = sheet.recording.rounds(begins, one, loops.iterations)
        *entries, sure, trusted, _, last = after
        found = sheet.done(functions, loops.placed(before[: len(entries)], state))
        determinants = found[n : len(found) - pivots]
        return loops.placed(entries, state), sure & trusted & loops.converged(last), determinants

    def _poses(self) -> RecordedProgram:
        loops, sheet = self.loops, _ProgramRecording(self.loops)
        n, count = loops.columns, len(loops.mechanism.driven)
        assert self.step is not None
        functions, pivots = self.step
        exact = loops.equations.written(count)
        assert exact is not None

        def one(begins: list[Any]) -> tuple[list[Any], Any]:
            *entries, sure, good, moving, first, last = begins
            at = loops.placed(entries, sheet.state)
            found = sheet.done(functions, at)
            if pivots:
                sure = sure & ~(moving & ~_firm(sheet.shares, found[-pivots:]))
            at, good, moving, first, last = loops.approached(found[:n], at, good, moving, first, last)
            return [*self._unknown(at), sure, good, moving, first, last], moving

        yes = sheet.yes
        begins = [*self._unknown(sheet.state), yes, yes, yes, -1.0, 0.0]
        _, after = sheet.recording.rounds(begins, one, loops.iterations)
        *entries, sure, good, moving, first, last = after
        at = loops.placed(entries, sheet.state)
        found = sheet.done(exact[0], at)
        if pivots:
            sure = sure & _firm(sheet.shares, found[-pivots:])
        at, good, last = loops.arrived(found[:n], at, good, moving, last)
        behind = n + len(loops.equations.followers)
        return sheet.written(
            [self._unknown(at), found[n:behind], found[behind : len(found) - pivots], [first, last], [good & sure]]
        )

    def _error(self, sheet: _ProgramRecording, state: Sequence[Any]) -> Any:
        square: Any = 0.0
        for row in sheet.done(self.residual, state):
            square = square + row * row
        return np.sqrt(square) if not isinstance(square, float) else square

    def _unknown(self, state: Sequence[Any]) -> list[Any]:
        return [state[k] for k in self.loops.unknown_states]


def _told(functions: Functions) -> tuple[Program, Places]:
    return functions.program, functions.places


class _ProgramRecording:
    """A recording whose inputs are groups: state, parameters, inverse pivots, and further values as needed."""

    def __init__(self, loops: ClosingArithmetic) -> None:
        mechanism = loops.mechanism
        self.recording = Recording(fixed=True)
        self._given: list[tuple[int, int]] = []
        self._more = 0
        self.state = self._later(0, mechanism.entries)
        self.parameters = self._later(1, len(mechanism.parameters))
        order = None if loops.linear.compact else loops.linear.order
        self.shares = self._later(2, sum(map(len, order.sizes)) if order is not None else 0)

    @property
    def yes(self) -> Any:
        """A term that is always true."""
        return self.recording.write(Operation.LESS, 0.0, 1.0)

    def more(self, count: int) -> list[Any]:
        """`count` further inputs of the last group."""
        self._more += count
        return self._later(3, count, self._more - count)

    def _later(self, group: int, count: int, start: int = 0) -> list[Any]:
        self._given += [(group, start + k) for k in range(count)]
        return [cast(Any, self.recording.later(0)) for _ in range(count)]

    def done(self, functions: Functions, state: Sequence[Any], *others: Sequence[Any]) -> list[Any]:
        """Results of functions of (state, parameters, others...)."""
        groups = state, self.parameters, *others
        return done(functions.program, [groups[group][place] for group, place in functions.places])

    def written(self, parts: Sequence[Sequence[Any]]) -> RecordedProgram:
        """The program whose outputs are these parts of a result."""
        outputs = [x if hasattr(x, "number") else self.recording.constant(x) for part in parts for x in part]
        program, given = self.recording.program(outputs)
        return RecordedProgram(program, tuple(self._given[k] for k in given), tuple(map(len, parts)))


def _firm(shares: Sequence[Any], pivots: Sequence[Any]) -> Any:
    """Whether no pivot is much smaller than in the pose from which their order was chosen."""
    least = abs(shares[0] * pivots[0])
    for share, pivot in zip(shares[1:], pivots[1:], strict=True):
        least = np.minimum(least, abs(share * pivot))
    return least >= LEAST_PIVOT_RATIO
