"""The minimisation in balls as two recorded programs, for long batches: multipliers, then the minimum.

They do the operations of `ball_formulas` for one entry, and give the bits that arrays give. A recording is kept by the
components of the balls alone, for all frames.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, cast

import numpy as np

from ..batch import Array
from ..cache import KERNELS
from ..elementwise import less, where
from ..program import machine_code
from ..program.arranging import in_order_of_need
from ..program.calculation import COMPILING, MOST, TWICE, Calculation, Choice
from ..program.program import Operation, Program
from ..program.recording import Recording, Term
from ..structure.parts import Value
from . import ball_formulas as formulas
from .ball_formulas import Iterate
from .ball_problem import ROUNDING, BallProblem, Groups, Minimum

# Largest number of steps in the multipliers alone, and of Newton's method after them.
FIRST, STEPS = 4, 11
# Error at which an entry has converged, and number of steps without improvement after which a converged one, and any
# other, stops.
CONVERGED, STAGNANT, PATIENCE = 4e-15, 2, 6
# Entries handled at a time, so that the memory for multipliers is small.
CHUNK = 2**16
# Seconds of an operation on arrays, rounds included: alone, and for each entry. And how many times as long as arrays
# compiling may take, less what they took before, as what is compiled is likely to be run again.
_ALONE, _EACH, _TIMES = 1e-6, 3e-9, 10


def improved(error: Any, least: Any, failed: Any) -> tuple[Any, Any, Any]:
    """Whether an error is the least so far, the least, and the number of steps since it was found."""
    better = less(error, least)
    return better, where(better, error, least), where(better, 0.0, failed + 1.0)


def unfinished(least: Any, failed: Any) -> Any:
    """Whether an entry goes on, by its own criteria, so that its result does not depend on the others."""
    patience = where(less(CONVERGED, least), float(PATIENCE), float(STAGNANT))
    return less(ROUNDING, least) & less(failed, patience)


@dataclass(frozen=True)
class BallPrograms:
    """The two programs for some balls.

    Attributes
    ----------
    multipliers, minimum
        Programs that give the multipliers and the number of steps; and from these and the number of steps offsets,
        forces on the spheres, whether the minimum was found and is unique, and the number of all steps.
    given
        For each, which of the numbers of the problem it takes, multipliers and number of steps included.
    """

    multipliers: Program
    minimum: Program
    given: tuple[list[int], list[int]]

    @classmethod
    def of(cls, groups: Groups) -> BallPrograms | None:
        """The programs for some balls, cached; None if they are too long."""
        steps = _estimated(groups)
        if steps > MOST:
            return None
        key = "balls", groups.own.tobytes()
        found: BallPrograms = KERNELS.found(key, lambda: _recorded(groups), 2 * steps)
        return found

    def run(self, problem: BallProblem, out: Minimum, *, compiled: bool) -> None:
        """Fill in the minima of a problem, as machine code or by NumPy."""
        count, balls = problem.force.shape[-1], problem.groups.count
        with np.errstate(all="ignore"):
            for start in range(0, count, CHUNK):
                part = slice(start, min(start + CHUNK, count))
                numbers = _numbers(problem.at(part))
                first = self._done(0, numbers, [*np.empty((balls + 1, part.stop - start))], compiled)
                last = [row[part] for whole in out.arrays for row in np.atleast_2d(whole)]
                self._done(1, [*numbers, *first], last, compiled)

    def _done(self, which: int, numbers: list[Value], outs: list[Any], compiled: bool) -> list[Any]:
        given = [numbers[k] for k in self.given[which]]
        masks = tuple(int(isinstance(each, np.ndarray)) for each in given)
        bare = (self.multipliers, self.minimum)[which]
        program: Program = KERNELS.found(("over", bare, masks), lambda: bare.over(masks), len(bare.steps))
        Calculation(program, given, outs[0].shape, compiled=compiled).run(0, slice(None), outs)
        return outs


class _Met:
    """Seconds that arrays took for some balls so far."""

    def __init__(self) -> None:
        self.seconds = 0.0


def chosen(groups: Groups, count: int) -> Choice:
    """How the minima of so many entries are to be found, by what that takes now and took for such balls before."""
    steps = _estimated(groups)
    compiling = COMPILING * steps * (1.0 + steps / TWICE)
    if not machine_code.available():
        return Choice(False, "by NumPy, as llvmlite (extra 'fast'), which would compile it, is not installed")
    if steps > MOST:
        return Choice(False, f"by NumPy, as about {steps} operations would take too long to compile")
    met: _Met = KERNELS.found(("balls met", groups.own.tobytes()), _Met)
    arrays = steps * (_ALONE + _EACH * count)
    if met.seconds + _TIMES * arrays < compiling:
        met.seconds += arrays
        return Choice(False, "by NumPy, as for so few entries compiling would take longer")
    return Choice(True, f"as machine code, about {steps} operations that take {1e3 * compiling:.2g} ms once to compile")


def _estimated(groups: Groups) -> int:
    """Number of operations of both programs, to within a third."""
    n, balls = len(groups.own), groups.count
    return 3 * (n**3 + n * n * (6 + 3 * balls // 2) + 2 * balls**3 + 25 * balls**2 + 70 * n) // 2


def _numbers(problem: BallProblem) -> list[Value]:
    """The numbers that programs take: S above the diagonal, f, members, and radii; floats where they do not vary."""
    n = len(problem.force)
    above = [problem.stiffness[i, j] for i in range(n) for j in range(i, n)]
    count = problem.force.shape[-1]
    rows = [*above, *problem.force, *problem.members, *problem.radius]
    return [row if row.shape[-1] == count else row.item() for row in rows]


# -- recording --------------------------------------------------------------------------------------------------------


def _recorded(groups: Groups) -> BallPrograms:
    (multipliers, one), (minimum, other) = _Multipliers(groups).recorded(), _Minimum(groups).recorded()
    return BallPrograms(multipliers, minimum, (one, other))


class _BallRecording(ABC):
    """The problem of one entry as terms of a recording."""

    def __init__(self, groups: Groups) -> None:
        self.groups, self.recording = groups, Recording(fixed=True, signless=True)
        n = len(groups.own)
        stiffness = np.empty((n, n, 1), dtype=object)
        for i in range(n):
            for j in range(i, n):
                stiffness[i, j, 0] = stiffness[j, i, 0] = self.recording.later(1)
        self.problem = BallProblem(groups, stiffness, self._later(n), self._later(n), self._later(groups.count))
        self.quadratic, self.scaling = self.problem.scaled()

    def recorded(self) -> tuple[Program, list[int]]:
        """The program, and which of the numbers it takes."""
        program, given = self.recording.program([self._term(x) for x in self._outputs()])
        # what a round begins with varies, whatever it begins with first
        return in_order_of_need(program.over(program.masks[: program.given])), given

    @abstractmethod
    def _outputs(self) -> list[Any]:
        """The results of the program."""

    def _later(self, count: int) -> Array:
        out = np.empty((count, 1), dtype=object)
        out[:, 0] = self.recording.later_ones(1, count)
        return cast(Array, out)

    def _term(self, value: Any) -> Term:
        return value if isinstance(value, Term) else self.recording.constant(value)

    def _true(self) -> Array:
        return np.array([self.recording.write(Operation.LESS, 0.0, 1.0)], dtype=object)


class _Multipliers(_BallRecording):
    def _outputs(self) -> list[Any]:
        begins = [*formulas.first_multipliers(self.quadratic)[:, 0], 0.0, self._true()[0]]
        return self.recording.rounds(begins, self._round, FIRST)[1][:-1]

    def _round(self, begins: list[Any]) -> tuple[list[Any], Any]:
        before, (count, going) = _column(begins[:-2]), _column(begins[-2:])
        found, settled = formulas.next_multipliers(self.quadratic, before)
        after, count = where(going, found, before), where(going, count + 1.0, count)
        going = going & ~settled
        return [*after[:, 0], count[0], going[0]], going[0]


class _Minimum(_BallRecording):
    def _outputs(self) -> list[Any]:
        quadratic, groups = self.quadratic, self.groups
        self._layout = len(groups.own), groups.count
        multiplier, count = self._later(groups.count), self._later(1)[0]
        start = Iterate.of(quadratic, formulas.inside_balls(quadratic, multiplier), multiplier)
        least, failed = start.error(quadratic.largest), _column([0.0])[0]
        going = unfinished(least, failed)
        begins = [*_flat(start), *start.x[:, 0], *start.multiplier[:, 0], *least, *failed, *count, *going]
        _, after = self.recording.rounds(begins, self._round, STEPS)
        _, best, (least, _, count, _) = self._parts(after)
        x, multiplier = formulas.on_spheres(groups, *best)
        sound = less(least, np.inf) & ~less(CONVERGED, least) & formulas.determined(quadratic, multiplier)
        offset, pressing = self.scaling.back(x, multiplier, groups.own)
        unbalanced = self.problem.unbalanced(offset, pressing)
        return [*offset[:, 0], *pressing[:, 0], *unbalanced[:, 0], sound[0], count[0]]

    def _round(self, begins: list[Any]) -> tuple[list[Any], Any]:
        iterate, (best_x, best_multiplier), (least, failed, count, going) = self._parts(begins)
        iterate = iterate.next(self.quadratic)
        better, least_now, failed = improved(iterate.error(self.quadratic.largest), least, failed)
        put, least = going & better, where(going, least_now, least)
        best_x, best_multiplier = where(put, iterate.x, best_x), where(put, iterate.multiplier, best_multiplier)
        count = where(going, count + 1.0, count)
        going = going & unfinished(least, failed)
        best = [*best_x[:, 0], *best_multiplier[:, 0]]
        return [*_flat(iterate), *best, *least, *failed, *count, *going], going[0]

    def _parts(self, values: list[Any]) -> tuple[Iterate, tuple[Array, Array], list[Array]]:
        """Iterate, best point with multipliers, and least error, failures, number of steps and whether to go on."""
        n, balls = self._layout
        cuts = np.cumsum([n, balls, n, balls, balls, n, balls]).tolist()
        parts = [_column(values[a:b]) for a, b in zip([0, *cuts], [*cuts, len(values)], strict=True)]
        return Iterate(*parts[:5]), (parts[5], parts[6]), list(parts[7])


def _flat(iterate: Iterate) -> list[Any]:
    parts = (iterate.x, iterate.multiplier, iterate.residual, iterate.inside, iterate.touched)
    return [term for part in parts for term in part[:, 0]]


def _column(values: Sequence[Any]) -> Array:
    out = np.empty((len(values), 1), dtype=object)
    out[:, 0] = values
    return cast(Array, out)
