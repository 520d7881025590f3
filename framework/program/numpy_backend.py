"""Running a program by NumPy: one ufunc call for each step, in memory that is reused and so stays in the cache."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import cast

import numpy as np

from ..batch import Array, Shape
from ..cache import KERNELS
from ..structure.parts import Value
from .combination import Combination
from .program import Operation, Program, Rounds


def _multiply_add(a: Value, b: Value, c: Value, out: Array) -> None:
    np.add(np.multiply(a, b), c, out=out)


def _multiply_subtract(a: Value, b: Value, c: Value, out: Array) -> None:
    np.subtract(np.multiply(a, b), c, out=out)


def _subtract_product(a: Value, b: Value, c: Value, out: Array) -> None:
    np.subtract(c, np.multiply(a, b), out=out)


def _choose(condition: Value, a: Value, b: Value, out: Array) -> None:
    out[...] = np.where(condition, a, b)


def _search(table: Array, x: Value, out: Array) -> None:
    out[...] = np.searchsorted(table, x, side="right")


def _look_up(table: Array, place: Array, out: Array) -> None:
    out[...] = table[place.astype(np.intp)]


def _carry(begin: Value, out: Array) -> None:
    out[...] = begin


# The functions of the operations; conditions are 1 or 0.
_FUNCTIONS: dict[Operation, Callable[..., object]] = {
    Operation.ADD: np.add,
    Operation.SUBTRACT: np.subtract,
    Operation.MULTIPLY: np.multiply,
    Operation.DIVIDE: np.divide,
    Operation.NEGATE: np.negative,
    Operation.MINIMUM: np.minimum,
    Operation.MAXIMUM: np.maximum,
    Operation.MULTIPLY_ADD: _multiply_add,
    Operation.MULTIPLY_SUBTRACT: _multiply_subtract,
    Operation.SUBTRACT_PRODUCT: _subtract_product,
    Operation.SINE: np.sin,
    Operation.COSINE: np.cos,
    Operation.SQUARE_ROOT: np.sqrt,
    Operation.ABSOLUTE: np.absolute,
    Operation.LESS: np.less,
    Operation.LESS_EQUAL: np.less_equal,
    Operation.AND: np.logical_and,
    Operation.OR: np.logical_or,
    Operation.NOT: np.logical_not,
    Operation.CHOOSE: _choose,
    Operation.SEARCH: _search,
    Operation.LOOK_UP: _look_up,
    Operation.CARRY: _carry,
}
# For functions of a product and a third number: the second operation, and whether the product is its first operand.
_TWO: dict[Callable[..., object] | None, tuple[Callable[..., object], bool]] = {
    _multiply_add: (np.add, True),
    _multiply_subtract: (np.subtract, True),
    _subtract_product: (np.subtract, False),
}
# A function with its input arrays and its output array.
_Bound = tuple[Callable[..., object], list[Value | None], Value | None]
# A piece of memory: the mask of its axes, and its number among those with that mask.
_Place = tuple[int, int]


@dataclass(frozen=True)
class _Call:
    """One step: a function, the numbers of its operands and of its result; a matrix product if the function is None."""

    function: Callable[..., object] | None
    operands: tuple[int, ...]
    out: int


class Schedule:
    """The steps of a program that NumPy runs, and the memory for each value: that of a value no longer needed.

    Parameters
    ----------
    program
        The program.
    """

    def __init__(self, program: Program) -> None:
        self.program = program
        # Range of the calls that make up a round.
        self.rounds = (0, 0)
        calls = list(self._calls())
        self.calls = calls if program.rounds is None else self._staged(calls, program.rounds)
        self.places: dict[int, _Place] = {}
        self._allot()

    @staticmethod
    def whole(program: Program) -> Schedule:
        """The schedule of a program without matrix products, cached."""
        schedule: Schedule = KERNELS.found(("whole", program), partial(Schedule, program), len(program.steps))
        return schedule

    def _staged(self, calls: list[_Call], rounds: Rounds) -> list[_Call]:
        """The calls before the rounds, the rounds, and the calls after them."""
        carried = {begins for begins, _ in rounds.carried}
        late = set(carried)
        for call in calls:
            if not late.isdisjoint(call.operands):
                late.add(call.out)
        again = self.program.again - carried
        before = [call for call in calls if call.out not in late]
        before += [call for call in calls if call.out in carried]
        inside = [call for call in calls if call.out in again]
        self.rounds = len(before), len(before) + len(inside)
        after = late - again - carried
        return [*before, *inside, *(call for call in calls if call.out in after)]

    def _calls(self) -> Iterator[_Call]:
        program = self.program
        starts = {each.steps[0]: number for number, each in enumerate(program.products)}
        inside = {k for each in program.products for k in range(*each.steps)}
        for k, step in enumerate(program.steps):
            if k in starts:
                numbers = program.products[starts[k]].numbers
                yield _Call(None, tuple(n for n in numbers if isinstance(n, int)), starts[k])
            elif k not in inside:
                yield _Call(_FUNCTIONS[step.operation], step.operands, program.first + k)

    def _allot(self) -> None:
        outputs = frozenset(self.program.outputs)
        last = {k: turn for turn, call in enumerate(self.calls) for k in call.operands}
        self._keep_for_rounds(last)
        free: dict[int, list[int]] = {}
        counts: dict[int, int] = {}
        for turn, call in enumerate(self.calls):
            # An operand that is no longer needed may be overwritten, so that its memory stays in the cache.
            for k in set(call.operands):
                if last[k] == turn and k in self.places:
                    free.setdefault(self.places[k][0], []).append(self.places[k][1])
            if call.function is not None and call.out not in outputs:
                mask = self.program.masks[call.out]
                waiting = free.get(mask)
                if not waiting:
                    counts[mask] = counts.get(mask, 0) + 1
                self.places[call.out] = mask, waiting.pop() if waiting else counts[mask] - 1

    def _keep_for_rounds(self, last: dict[int, int]) -> None:
        """Keep values from before the rounds during all of them, and values that rounds hand on until the next one."""
        rounds, (start, stop) = self.program.rounds, self.rounds
        if rounds is None or start == stop:
            return
        inside = {call.out for call in self.calls[start:stop]}
        kept = {k for call in self.calls[start:stop] for k in call.operands} - inside
        kept |= {rounds.again, *(k for pair in rounds.carried for k in pair)}
        for k in kept:
            last[k] = max(last.get(k, 0), stop)


class Memory:
    """Arrays for a schedule at one shape of the batch.

    Parameters
    ----------
    schedule
        The steps and their memory.
    shape
        Shape of the batch, or of a chunk of it.
    """

    def __init__(self, schedule: Schedule, shape: Shape) -> None:
        self.schedule, self.shape = schedule, shape
        program = schedule.program
        arrays: dict[_Place, Array] = {}
        self._values: list[Value | None] = [*(None,) * program.given, *program.constants, *(None,) * len(program.steps)]
        for k, place in schedule.places.items():
            if place not in arrays:
                arrays[place] = np.empty(self.of(place[0]))
            self._values[k] = arrays[place]
        self._stacks: dict[int, tuple[Array, Array]] = {}

    def of(self, mask: int) -> Shape:
        """Shape of a number that varies over the axes of a mask."""
        return tuple(n if mask >> axis & 1 else 1 for axis, n in enumerate(self.shape))

    def run(self, given: Sequence[Value], outputs: Mapping[int, Array], combinations: Sequence[Combination]) -> None:
        """Run the steps.

        Parameters
        ----------
        given
            Input values, cut to the shape of this memory.
        outputs
            Arrays to fill, by number of the value: outputs, and other values that are kept.
        combinations
            The matrix products, cut to the same shape.
        """
        values = self._values
        values[: len(given)] = given
        for k, out in outputs.items():
            values[k] = out
        start, stop = self.schedule.rounds
        self._call(self.schedule.calls[:start], outputs, combinations)
        if stop > start:
            self._do_rounds(self.schedule.calls[start:stop])
        self._call(self.schedule.calls[stop:], outputs, combinations)

    def _call(self, calls: Sequence[_Call], outputs: Mapping[int, Array], combinations: Sequence[Combination]) -> None:
        values = self._values
        for call in calls:
            if call.function is None:
                self._multiply(call.out, combinations[call.out], outputs)
            elif len(call.operands) == 2:
                a, b = call.operands
                call.function(values[a], values[b], out=values[call.out])
            else:
                call.function(*map(values.__getitem__, call.operands), out=values[call.out])

    def _do_rounds(self, calls: Sequence[_Call]) -> None:
        values, rounds = self._values, self.schedule.program.rounds
        assert rounds is not None
        bound = list(self._bound(calls))
        begins = {k for k, _ in rounds.carried}
        for turn in range(rounds.most):
            for function, operands, out in bound:
                function(*operands, out=out)
            if turn == rounds.most - 1 or not np.any(cast(Array, values[rounds.again])):
                return
            after = [(k, np.copy(cast(Array, values[a])) if a in begins else values[a]) for k, a in rounds.carried]
            for k, value in after:
                cast(Array, values[k])[...] = cast(Value, value)

    def _bound(self, calls: Sequence[_Call]) -> Iterator[_Bound]:
        """Functions with their arrays; a product with a sum as two functions."""
        values, spare = self._values, np.empty(self.shape)
        for call in calls:
            operands, out = [values[k] for k in call.operands], values[call.out]
            if call.function in _TWO and isinstance(out, np.ndarray) and out.shape == self.shape:
                a, b, c = operands
                last, product_first = _TWO[call.function]
                yield np.multiply, [a, b], spare
                yield last, [spare, c] if product_first else [c, spare], out
            else:
                yield cast(Callable[..., object], call.function), operands, out

    def _multiply(self, index: int, combination: Combination, outputs: Mapping[int, Array]) -> None:
        product = self.schedule.program.products[index]
        if index not in self._stacks:
            lead, length = self.shape[:-1], self.shape[-1]
            stack = np.empty((*lead, len(product.numbers), length))
            self._stacks[index] = stack, np.empty((*lead, len(product.outputs), length))
        stack, sums = self._stacks[index]
        for place, number in enumerate(product.numbers):
            stack[..., place, :] = self._values[number] if isinstance(number, int) else number
        combination.times(stack, sums)
        for place, number in enumerate(product.outputs):
            shape = self.of(self.schedule.program.masks[number])
            # a sum of numbers that are the same along an axis is so itself
            found = sums[..., place, :][tuple(slice(size) for size in shape)]
            if number in outputs:
                outputs[number][...] = found
            else:
                self._values[number] = found


def combinations(program: Program, given: Sequence[Value], shape: Shape) -> list[Combination]:
    """The matrix products of a program, with factors for the whole batch taken from its input values."""
    number: Callable[[int | float], Value] = lambda k: given[k] if isinstance(k, int) else k  # noqa: E731
    out = []
    for each in program.products:
        rows = [{place: number(k) for place, k in row.items()} for row in each.factors]
        out.append(Combination.of(rows, {k: k for k in range(len(each.numbers))}, shape))
    return out
