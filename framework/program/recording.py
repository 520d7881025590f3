"""Arithmetic that is written down instead of being done.

A calculation that is carried out on `Term`s instead of arrays leaves its operations in a `Recording`. Zeros and ones
that hold for all time drop out, equal steps are taken once, and what no result needs is left away.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np

from ..batch import Same
from ..structure.parts import Value, mask_of
from .program import NONE, Operation, Products, Program, Rounds
from .selection import Made, selected

_UFUNCS: dict[np.ufunc, Callable[..., Any]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.divide: lambda a, b: a / b,
    np.negative: lambda a: -a,
    np.minimum: lambda a, b: _recording(a, b).either(Operation.MINIMUM, a, b),
    np.maximum: lambda a, b: _recording(a, b).either(Operation.MAXIMUM, a, b),
    np.less: lambda a, b: _recording(a, b).write(Operation.LESS, a, b),
    np.greater: lambda a, b: _recording(a, b).write(Operation.LESS, b, a),
    np.less_equal: lambda a, b: _recording(a, b).write(Operation.LESS_EQUAL, a, b),
    np.greater_equal: lambda a, b: _recording(a, b).write(Operation.LESS_EQUAL, b, a),
    np.sqrt: lambda a: _recording(a).write(Operation.SQUARE_ROOT, a),
    np.sin: lambda a: _recording(a).write(Operation.SINE, a),
    np.cos: lambda a: _recording(a).write(Operation.COSINE, a),
    np.abs: lambda a: _recording(a).write(Operation.ABSOLUTE, a),
}

# Kinds of the constants of a formula; to put them together anew for each step takes longer than to look.
_PLAIN_NUMBERS = (float, int)

# Operations whose operands may change their signs with that of the result.
_SIGNED = frozenset({Operation.ADD, Operation.SUBTRACT, Operation.MULTIPLY, Operation.DIVIDE, Operation.NEGATE})


class Term:
    """A number known when the program runs."""

    __slots__ = ("number", "recording")

    def __init__(self, recording: Recording, number: int) -> None:
        self.recording, self.number = recording, number

    @property
    def mask(self) -> int:
        """The batch axes over which it varies."""
        return self.recording.masks[self.number]

    # Most operands are terms, and there are many: they come first.

    def __add__(self, other: Any) -> Any:
        if type(other) is Term:
            a, b = self.number, other.number
            return self.recording.step(Operation.ADD, a, b) if a <= b else self.recording.step(Operation.ADD, b, a)
        return self if _constant(other, 0.0) else self.recording.either(Operation.ADD, self, other)

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        if type(other) is Term:
            if self.number == other.number and self.recording.fixed:
                return 0.0
            return self.recording.step(Operation.SUBTRACT, self.number, other.number)
        return self if _constant(other, 0.0) else self.recording.write(Operation.SUBTRACT, self, other)

    def __rsub__(self, other: Any) -> Any:
        return -self if _constant(other, 0.0) else self.recording.write(Operation.SUBTRACT, other, self)

    def __mul__(self, other: Any) -> Any:
        if type(other) is Term:
            a, b = self.number, other.number
            return self.recording.step(Operation.MULTIPLY, *((a, b) if a <= b else (b, a)))
        if _constant(other, 0.0):
            return 0.0
        if _constant(other, 1.0) or _constant(other, -1.0):
            return self if other == 1.0 else -self
        return self.recording.either(Operation.MULTIPLY, self, other)

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self if _constant(other, 1.0) else self.recording.write(Operation.DIVIDE, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return 0.0 if _constant(other, 0.0) else self.recording.write(Operation.DIVIDE, other, self)

    def __neg__(self) -> Any:
        return self.recording.step(Operation.NEGATE, self.number)

    def __lt__(self, other: Any) -> Any:
        return self.recording.write(Operation.LESS, self, other)

    def __gt__(self, other: Any) -> Any:
        return self.recording.write(Operation.LESS, other, self)

    def __le__(self, other: Any) -> Any:
        return self.recording.write(Operation.LESS_EQUAL, self, other)

    def __ge__(self, other: Any) -> Any:
        return self.recording.write(Operation.LESS_EQUAL, other, self)

    def __and__(self, other: Any) -> Any:
        return self.recording.either(Operation.AND, self, other)

    __rand__ = __and__

    def __or__(self, other: Any) -> Any:
        return self.recording.either(Operation.OR, self, other)

    __ror__ = __or__

    def __invert__(self) -> Any:
        return self.recording.write(Operation.NOT, self)

    def __abs__(self) -> Any:
        return self.recording.write(Operation.ABSOLUTE, self)

    def chosen(self, a: Any, b: Any) -> Any:
        """a where this holds, b elsewhere."""
        return self.recording.write(Operation.CHOOSE, self, a, b)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *operands: Any, **options: Any) -> Any:
        if ufunc not in _UFUNCS or method != "__call__" or options:
            return NotImplemented
        recording = self.recording
        return _UFUNCS[ufunc](*(recording.take(each) for each in operands))


def _constant(value: object, constant: float) -> bool:
    return isinstance(value, _PLAIN_NUMBERS) and value == constant


def _number(value: Any) -> int:
    return value.number if isinstance(value, Term) else NONE


def _factor(value: Any) -> int | float:
    return value.number if isinstance(value, Term) else float(value)


def _recording(*values: Any) -> Recording:
    return next(value.recording for value in values if isinstance(value, Term))


def choose(condition: Any, a: Any, b: Any) -> Any:
    """a where a condition holds, b elsewhere: of numbers, of arrays, or written down."""
    if isinstance(condition, Term):
        return condition.chosen(a, b)
    return np.where(condition, a, b)


# Operations on terms, on numbers, or on both.
_PLAIN: dict[Operation, Callable[..., Any]] = {
    Operation.ADD: operator.add,
    Operation.SUBTRACT: operator.sub,
    Operation.MULTIPLY: operator.mul,
    Operation.DIVIDE: operator.truediv,
    Operation.NEGATE: operator.neg,
    Operation.MINIMUM: np.minimum,
    Operation.MAXIMUM: np.maximum,
    Operation.SINE: np.sin,
    Operation.COSINE: np.cos,
    Operation.SQUARE_ROOT: np.sqrt,
    Operation.ABSOLUTE: np.abs,
    Operation.LESS: np.less,
    Operation.LESS_EQUAL: np.less_equal,
    Operation.CHOOSE: choose,
}


def done(program: Program, given: Sequence[Any]) -> list[Any]:
    """Outputs of a program whose steps are done one by one, on numbers or on terms of another recording."""
    values = [*given, *program.constants]
    for step in program.steps:
        values.append(_PLAIN[step.operation](*map(values.__getitem__, step.operands)))
    return [values[k] for k in program.outputs]


class Recording:
    """Steps of a calculation, in order.

    Parameters
    ----------
    fixed
        Whether plain numbers are part of the program, as those of a formula are; they are given otherwise.
    signless
        Whether what differs in sign alone is calculated once. Results are the same but for the sign of zero.

    Attributes
    ----------
    given
        What was given, by number among the given values; None for what is given when the program runs.
    masks
        By value: the batch axes over which it varies.
    """

    def __init__(self, *, fixed: bool = False, signless: bool = False) -> None:
        self.fixed, self.signless = fixed, signless
        self.given: list[Value | None] = []
        self.masks: list[int] = []
        # By value: the step that makes it; of one that is given its place, of a constant its number.
        self._made: list[Made] = []
        self._known: dict[object, int] = {}
        self._products: list[Products] = []
        self._rounds: Rounds | None = None

    # -- values ------------------------------------------------------------------------------------------------------

    def take(self, value: Any) -> Any:
        """What stands for a number: itself where it is a term, or exactly 0, 1 or -1; a given value otherwise."""
        if isinstance(value, Term):
            return value
        if not isinstance(value, np.ndarray):
            plain = float(value)
            if self.fixed or plain in (0.0, 1.0, -1.0):
                return plain
        key = Same(value)
        if key not in self._known:
            self._known[key] = self._new(len(self.given), mask_of(value))
            self.given.append(value)
        return Term(self, self._known[key])

    def later(self, mask: int) -> Value:
        """A value that is given when the program runs, after those that were taken; it varies over these axes."""
        self.given.append(None)
        return cast(Value, Term(self, self._new(len(self.given) - 1, mask)))

    def later_ones(self, mask: int, count: int) -> list[Value]:
        """So many values that are given when the program runs."""
        return [self.later(mask) for _ in range(count)]

    def write(self, operation: Operation, *operands: Any) -> Term:
        """Write down a step, unless it has been before."""
        return self.step(operation, *map(self._standing, operands))

    def either(self, operation: Operation, *operands: Any) -> Term:
        """Write down a step in which the order of the operands does not matter."""
        return self.step(operation, *sorted(map(self._standing, operands)))

    def step(self, operation: Operation, a: int, b: int = NONE, c: int = NONE) -> Term:
        """Write down a step on the values of these numbers, unless it has been before."""
        if self.signless and operation in _SIGNED:
            return self._signed(operation, a, b)
        return self._step(operation, a, b, c)

    def _signed(self, operation: Operation, a: int, b: int) -> Term:
        """The step on the values without their signs, and the sign of the result."""
        (a, down), (b, under) = self._unsigned(a), self._unsigned(b)
        if operation == Operation.NEGATE:
            return Term(self, a) if down else self._step(Operation.NEGATE, a)
        if operation in (Operation.MULTIPLY, Operation.DIVIDE):
            pair = (b, a) if b < a and operation == Operation.MULTIPLY else (a, b)
            return self._with_sign(self._step(operation, *pair), down != under)
        under ^= operation == Operation.SUBTRACT
        if down == under:
            return self._with_sign(self._step(Operation.ADD, min(a, b), max(a, b)), down)
        return self._with_sign(self._step(Operation.SUBTRACT, min(a, b), max(a, b)), down == (a < b))

    def _unsigned(self, number: int) -> tuple[int, bool]:
        """A value whose sign is that of another turned round: the other."""
        made = self._made[number] if number != NONE else None
        return (made[1], True) if isinstance(made, tuple) and made[0] == Operation.NEGATE else (number, False)

    def _with_sign(self, term: Term, negative: bool) -> Term:
        return self._step(Operation.NEGATE, term.number) if negative else term

    def _step(self, operation: Operation, a: int, b: int = NONE, c: int = NONE) -> Term:
        made = operation, a, b, c
        number = self._known.get(made)
        if number is None:
            number = self._known[made] = len(self._made)
            self._made.append(made)
            mask = self.masks[a] if b == NONE else self.masks[a] | self.masks[b]
            self.masks.append(mask if c == NONE else mask | self.masks[c])
        return Term(self, number)

    def search(self, table: Any, x: Any) -> Term:
        """How many numbers of a table, which rise and end in inf, are not above x."""
        return self.write(Operation.SEARCH, table, x)

    def look_up(self, table: Any, place: Any) -> Term:
        """The number at a place of a table, which counts from 0."""
        return self.write(Operation.LOOK_UP, table, place)

    def rounds(
        self, begins: Sequence[Any], one: Callable[[list[Any]], tuple[list[Any], Any]], most: int
    ) -> tuple[list[Any], list[Any]]:
        """Write down a round that is done over and over, once in a recording.

        Parameters
        ----------
        begins
            Values with which the first round begins.
        one
            From the values with which a round begins to those that it makes of them, and whether there is another.
        most
            Number of rounds at most.

        Returns
        -------
        before, after
            The values with which the last round begins and ends.
        """
        before = [self._alone(Operation.CARRY, value) for value in begins]
        after, again = one(list(before))
        numbers = [self._standing(value) for value in after]
        self._rounds = Rounds(tuple((x.number, k) for x, k in zip(before, numbers, strict=True)), again.number, most)
        return before, [Term(self, k) for k in numbers]

    def _standing(self, value: Any) -> int:
        """Number of the value that stands for a number."""
        taken = self.take(value)
        return taken.number if isinstance(taken, Term) else self._literal(taken)

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Sums of products of the factors `rows` with `numbers`, as one matrix product."""
        taken = [{k: self.take(v) for k, v in row.items()} for row in rows]
        start = len(self._made)
        outputs = [self._sum(row, numbers) for row in taken]
        places = {k: place for place, k in enumerate(numbers)}
        made = [(row, out) for row, out in zip(taken, outputs, strict=True) if _number(out) >= start]
        if made:
            factors = [{places[k]: _factor(v) for k, v in row.items()} for row, _ in made]
            values = tuple(_factor(value) for value in numbers.values())
            found = tuple(_number(out) for _, out in made)
            self._products.append(Products((start, len(self._made)), found, values, tuple(factors)))
        return outputs

    def _sum(self, row: Mapping[int, Any], numbers: Mapping[int, Value]) -> Any:
        """One sum, from left to right, of steps that nothing else shares."""
        total: Any = 0.0
        for k, value in numbers.items():
            if k in row:
                total = self._added(total, row[k], value)
        return total

    def _added(self, total: Any, factor: Any, value: Any) -> Any:
        if not isinstance(value, Term):
            factor, value = value, factor
        if isinstance(factor, Term):
            if _constant(total, 0.0):
                return self._alone(Operation.MULTIPLY, factor, value)
            return self._alone(Operation.MULTIPLY_ADD, factor, value, total)
        if factor == 0.0 or _constant(value, 0.0):
            return total
        if not isinstance(value, Term):
            return self._alone(Operation.ADD, total, factor * value) if isinstance(total, Term) else factor * value
        if _constant(total, 0.0):
            return value if factor > 0.0 else self._alone(Operation.NEGATE, value)
        return self._alone(Operation.ADD if factor > 0.0 else Operation.SUBTRACT, total, value)

    def _alone(self, operation: Operation, *operands: Any) -> Term:
        a, b, c = [*map(self._standing, operands), NONE, NONE][:3]
        mask = 0
        for k in (a, b, c):
            mask |= self.masks[k] if k != NONE else 0
        return Term(self, self._new((operation, a, b, c), mask))

    def constant(self, value: float) -> Term:
        """A number that is part of the program."""
        return Term(self, self._literal(value))

    def _literal(self, value: float) -> int:
        key = "constant", float(value)
        if key not in self._known:
            self._known[key] = self._new(float(value), 0)
        return self._known[key]

    def _new(self, made: Made, mask: int) -> int:
        self._made.append(made)
        self.masks.append(mask)
        return len(self._made) - 1

    def program(self, outputs: Sequence[Term]) -> tuple[Program, list[int]]:
        """What makes `outputs`, and the places in `given` of the values that it takes."""
        return selected([output.number for output in outputs], self._made, self.masks, self._products, self._rounds)
