"""Recording of arithmetic: a calculation with `Term` objects in place of arrays stores its operations in a `Recording`.

Operations with constant zeros and ones are left out, equal steps are recorded once, and steps that no result needs are
dropped.
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

# Types of the constants in a formula; a tuple here, as building it for each step would cost time.
_PLAIN_NUMBERS = (float, int)

# Operations for which signs of operands can be moved to the result.
_SIGNED = frozenset({Operation.ADD, Operation.SUBTRACT, Operation.MULTIPLY, Operation.DIVIDE, Operation.NEGATE})


class Term:
    """A number whose value is known when the program runs; arithmetic with it is recorded."""

    __slots__ = ("number", "recording")

    def __init__(self, recording: Recording, number: int) -> None:
        self.recording, self.number = recording, number

    @property
    def mask(self) -> int:
        """Mask of the batch axes over which it varies."""
        return self.recording.masks[self.number]

    @property
    def batch_mask(self) -> int:
        """`mask`, as far as it counts in sums of parts."""
        return self.recording.masks[self.number] & self.recording.axes

    # Most operands are terms, so that case is tested first.

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
        """a where this condition holds, else b."""
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
    """a where a condition holds, else b: for numbers, arrays or terms."""
    if isinstance(condition, Term):
        return condition.chosen(a, b)
    return np.where(condition, a, b)


# Functions of the operations for terms, numbers, or both.
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
    """Outputs of a program, its steps run one by one with numbers or with terms of another recording."""
    values = [*given, *program.constants]
    for step in program.steps:
        values.append(_PLAIN[step.operation](*map(values.__getitem__, step.operands)))
    return [values[k] for k in program.outputs]


class Recording:
    """The recorded steps of a calculation, in order.

    Parameters
    ----------
    fixed
        Whether plain numbers become constants of the program, as in a formula; otherwise they become inputs.
    signless
        Whether values that differ in sign alone are computed once. Results are the same except for the sign of zero.
    axes
        Mask of the batch axes by which sums of numbers are divided into parts.

    Attributes
    ----------
    given
        Values of the inputs; None for those that are passed when the program runs.
    masks
        For each value the mask of the batch axes over which it varies.
    """

    def __init__(self, *, fixed: bool = False, signless: bool = False, axes: int = 0) -> None:
        self.fixed, self.signless, self.axes = fixed, signless, axes
        self.given: list[Value | None] = []
        self.masks: list[int] = []
        # For each value: the step that computes it; for an input its index, for a constant the float.
        self._made: list[Made] = []
        self._known: dict[object, int] = {}
        self._products: list[Products] = []
        self._rounds: Rounds | None = None

    # -- values ------------------------------------------------------------------------------------------------------

    def take(self, value: Any) -> Any:
        """The term for a number, a new input; or the number itself if it is a term already, or exactly 0, 1 or -1."""
        if isinstance(value, Term):
            return value
        if not isinstance(value, np.ndarray):
            plain = float(value)
            if self.fixed or plain in (0.0, 1.0, -1.0):
                return plain
        key = Same(value)
        number = self._known.get(key)
        if number is None:
            number = self._known[key] = self._new(len(self.given), mask_of(value))
            self.given.append(value)
        return Term(self, number)

    def later(self, mask: int) -> Value:
        """The term of an input that is passed when the program runs; it varies over the axes of a mask."""
        self.given.append(None)
        return cast(Value, Term(self, self._new(len(self.given) - 1, mask)))

    def later_ones(self, mask: int, count: int) -> list[Value]:
        """The terms of several inputs that are passed when the program runs."""
        return [self.later(mask) for _ in range(count)]

    def write(self, operation: Operation, *operands: Any) -> Term:
        """Record a step, unless it has been recorded before; its result."""
        return self.step(operation, *map(self._standing, operands))

    def either(self, operation: Operation, *operands: Any) -> Term:
        """Record a step in which the order of the operands does not matter; its result."""
        return self.step(operation, *sorted(map(self._standing, operands)))

    def step(self, operation: Operation, a: int, b: int = NONE, c: int = NONE) -> Term:
        """Record a step on values given by number, unless it has been recorded before; its result."""
        if self.signless and operation in _SIGNED:
            return self._signed(operation, a, b)
        return self._step(operation, a, b, c)

    def _signed(self, operation: Operation, a: int, b: int) -> Term:
        """Record a step on the operands without their signs, and apply the sign of the result."""
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
        """A value and whether it is to be negated: for the negative of another value, that other one and True."""
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
        """How many numbers of a table, ascending and ending with inf, are not above x."""
        return self.write(Operation.SEARCH, table, x)

    def look_up(self, table: Any, place: Any) -> Term:
        """The number at an index of a table, counted from 0."""
        return self.write(Operation.LOOK_UP, table, place)

    def rounds(
        self, begins: Sequence[Any], one: Callable[[list[Any]], tuple[list[Any], Any]], most: int
    ) -> tuple[list[Any], list[Any]]:
        """Record a round of steps that is repeated; a recording can have one such loop.

        Parameters
        ----------
        begins
            Values with which the first round begins.
        one
            Function from the values with which a round begins to those after it, and the condition for another round.
        most
            Largest number of rounds.

        Returns
        -------
        before, after
            The values with which the last round begins, and those with which it ends.
        """
        before = [self._alone(Operation.CARRY, value) for value in begins]
        after, again = one(list(before))
        numbers = [self._standing(value) for value in after]
        self._rounds = Rounds(tuple((x.number, k) for x, k in zip(before, numbers, strict=True)), again.number, most)
        return before, [Term(self, k) for k in numbers]

    def _standing(self, value: Any) -> int:
        """Number of the value that represents a number, recorded if need be."""
        taken = self.take(value)
        return taken.number if isinstance(taken, Term) else self._literal(taken)

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Linear combinations of `numbers` with the factors `rows`, recorded as one matrix product."""
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
        """One linear combination, summed from left to right by steps that nothing else shares."""
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
        """The term of a constant of the program."""
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
        """The program that computes `outputs`, and the indices in `given` of its inputs."""
        return selected([output.number for output in outputs], self._made, self.masks, self._products, self._rounds)
