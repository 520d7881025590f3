"""Arithmetic that is written down instead of being done.

A calculation that is carried out on `Term`s instead of arrays leaves its operations in a `Recording`. Zeros and ones
that hold for all time drop out, equal steps are taken once, and what no result needs is left away.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, cast

import numpy as np

from ..batch import Same
from ..structure.parts import Value
from .program import NONE, Operation, Products, Program, Step

_UFUNCS: dict[np.ufunc, Callable[..., Any]] = {
    np.add: lambda a, b: a + b,
    np.subtract: lambda a, b: a - b,
    np.multiply: lambda a, b: a * b,
    np.divide: lambda a, b: a / b,
    np.negative: lambda a: -a,
    np.minimum: lambda a, b: _recording(a, b).write(Operation.MINIMUM, *sorted((a, b), key=_number)),
    np.maximum: lambda a, b: _recording(a, b).write(Operation.MAXIMUM, *sorted((a, b), key=_number)),
}


class Term:
    """A number known when the program runs."""

    __slots__ = ("number", "recording")

    def __init__(self, recording: Recording, number: int) -> None:
        self.recording, self.number = recording, number

    @property
    def mask(self) -> int:
        """The batch axes over which it varies."""
        return self.recording.masks[self.number]

    def __add__(self, other: Any) -> Any:
        if _constant(other, 0.0):
            return self
        return self.recording.write(Operation.ADD, *_sorted(self, other))

    __radd__ = __add__

    def __sub__(self, other: Any) -> Any:
        return self if _constant(other, 0.0) else self.recording.write(Operation.SUBTRACT, self, other)

    def __rsub__(self, other: Any) -> Any:
        return -self if _constant(other, 0.0) else self.recording.write(Operation.SUBTRACT, other, self)

    def __mul__(self, other: Any) -> Any:
        if _constant(other, 0.0):
            return 0.0
        if _constant(other, 1.0) or _constant(other, -1.0):
            return self if other == 1.0 else -self
        return self.recording.write(Operation.MULTIPLY, *_sorted(self, other))

    __rmul__ = __mul__

    def __truediv__(self, other: Any) -> Any:
        return self if _constant(other, 1.0) else self.recording.write(Operation.DIVIDE, self, other)

    def __rtruediv__(self, other: Any) -> Any:
        return 0.0 if _constant(other, 0.0) else self.recording.write(Operation.DIVIDE, other, self)

    def __neg__(self) -> Any:
        return self.recording.write(Operation.NEGATE, self)

    def __array_ufunc__(self, ufunc: np.ufunc, method: str, *operands: Any, **options: Any) -> Any:
        if ufunc not in _UFUNCS or method != "__call__" or options:
            return NotImplemented
        recording = self.recording
        return _UFUNCS[ufunc](*(recording.take(each) for each in operands))


def _constant(value: object, constant: float) -> bool:
    return isinstance(value, float) and value == constant


def _sorted(a: Any, b: Any) -> tuple[Any, Any]:
    """Two operands of which either may come first."""
    a, b = (a.recording.take(b), a) if isinstance(a, Term) else (a, b)
    return (a, b) if _number(a) <= _number(b) else (b, a)


def _number(value: Any) -> int:
    return value.number if isinstance(value, Term) else NONE


def _factor(value: Any) -> int | float:
    return value.number if isinstance(value, Term) else float(value)


def _recording(*values: Any) -> Recording:
    return next(value.recording for value in values if isinstance(value, Term))


class Recording:
    """Steps of a calculation, in order.

    Attributes
    ----------
    given
        What was given, by number among the given values; None for what is given when the program runs.
    masks
        By value: the batch axes over which it varies.
    """

    def __init__(self) -> None:
        self.given: list[Value | None] = []
        self.masks: list[int] = []
        # By value: the step that makes it; of one that is given its place, of a constant its number.
        self._made: list[Step | int | float] = []
        self._known: dict[object, int] = {}
        self._products: list[Products] = []

    # -- values ------------------------------------------------------------------------------------------------------

    def take(self, value: Any) -> Any:
        """What stands for a number: itself where it is a term, or exactly 0, 1 or -1; a given value otherwise."""
        if isinstance(value, Term):
            return value
        if not isinstance(value, np.ndarray):
            plain = float(value)
            if plain in (0.0, 1.0, -1.0):
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

    def write(self, operation: Operation, *operands: Any) -> Any:
        """Write down a step, unless it has been before."""
        taken = [self.take(each) for each in operands]
        step = Step(operation, *(each.number if isinstance(each, Term) else self._literal(each) for each in taken))
        if step not in self._known:
            self._known[step] = self._step(step)
        return Term(self, self._known[step])

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Sums of products of the factors `rows` with `numbers`, as one matrix product."""
        taken = [{k: self.take(v) for k, v in row.items()} for row in rows]
        start = len(self._made)
        outs = [self._sum(row, numbers) for row in taken]
        places = {k: place for place, k in enumerate(numbers)}
        made = [(row, out) for row, out in zip(taken, outs, strict=True) if _number(out) >= start]
        if made:
            factors = [{places[k]: _factor(v) for k, v in row.items()} for row, _ in made]
            values = tuple(_factor(value) for value in numbers.values())
            found = tuple(_number(out) for _, out in made)
            self._products.append(Products((start, len(self._made)), found, values, tuple(factors)))
        return outs

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
        numbers = (each.number if isinstance(each, Term) else self._literal(each) for each in operands)
        return Term(self, self._step(Step(operation, *numbers)))

    def _literal(self, value: Any) -> int:
        key = "constant", float(value)
        if key not in self._known:
            self._known[key] = self._new(float(value), 0)
        return self._known[key]

    def _step(self, step: Step) -> int:
        mask = 0
        for k in step.operands:
            mask |= self.masks[k]
        return self._new(step, mask)

    def _new(self, made: Step | int | float, mask: int) -> int:
        self._made.append(made)
        self.masks.append(mask)
        return len(self._made) - 1

    # -- the program -------------------------------------------------------------------------------------------------

    def program(self, outputs: Sequence[Term]) -> tuple[Program, list[int]]:
        """What makes `outputs`, and the places in `given` of the values that it takes."""
        asked = [output.number for output in outputs]
        needed = self._needed(asked)
        given = [k for k in needed if type(self._made[k]) is int]
        constants = [k for k in needed if type(self._made[k]) is float]
        steps = [k for k in needed if isinstance(self._made[k], Step)]
        new = {old: number for number, old in enumerate([*given, *constants, *steps])}
        new[NONE] = NONE
        program = Program(
            given=len(given),
            constants=tuple(cast(float, self._made[k]) for k in constants),
            steps=tuple(Step(s.operation, new[s.a], new[s.b], new[s.c]) for s in map(self._made.__getitem__, steps)),  # type: ignore[union-attr]
            masks=tuple(self.masks[k] for k in new if k != NONE),
            outputs=tuple(new[k] for k in asked),
            products=tuple(self._renumbered(new, len(given) + len(constants))),
        )
        return program, [cast(int, self._made[k]) for k in given]

    def _needed(self, asked: list[int]) -> list[int]:
        """Values that lead to those asked for, in order."""
        needed, waiting = set(asked), list(asked)
        while waiting:
            made = self._made[waiting.pop()]
            if isinstance(made, Step):
                fresh = [k for k in made.operands if k not in needed]
                needed.update(fresh)
                waiting += fresh
        return sorted(needed)

    def _renumbered(self, new: Mapping[int, int], first: int) -> list[Products]:
        out = []
        for each in self._products:
            kept = [new[k] - first for k in range(*each.steps) if k in new and isinstance(self._made[k], Step)]
            rows = [(new[k], row) for k, row in zip(each.outs, each.factors, strict=True) if k in new]
            if not rows:
                continue
            used = sorted({place for _, row in rows for place in row})
            places = {place: index for index, place in enumerate(used)}
            out.append(
                Products(
                    (kept[0], kept[-1] + 1),
                    tuple(k for k, _ in rows),
                    tuple(_new(each.numbers[place], new) for place in used),
                    tuple({places[p]: _new(v, new) for p, v in row.items()} for _, row in rows),
                )
            )
        return out


def _new(number: int | float, new: Mapping[int, int]) -> int | float:
    return new[number] if isinstance(number, int) else number


def mask_of(value: object) -> int:
    """The batch axes over which a number varies, as bits."""
    if not isinstance(value, np.ndarray):
        return 0
    return sum(1 << axis for axis, n in enumerate(value.shape) if n > 1)
