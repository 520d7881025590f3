"""Arithmetic that is done at once, where a program would not run often enough to be written down first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ..batch import Array, Shape
from ..structure.parts import Row, Value
from .combination import Combination


class Arithmetic(Protocol):
    """What a calculation is carried out on: a recording, or numbers themselves."""

    def take(self, value: Value) -> Any:
        """What stands for a number."""
        ...

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Sums of products of the factors `rows` with `numbers`."""
        ...


def double(value: Value) -> Value:
    """A number in double precision."""
    return value.astype(np.float64, copy=False) if isinstance(value, np.ndarray) else float(value)


class Direct:
    """Numbers stand for themselves.

    Parameters
    ----------
    shape
        The batch.
    """

    def __init__(self, shape: Shape) -> None:
        self.shape = shape

    def take(self, value: Value) -> Value:
        """A number in double precision."""
        return double(value)

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Sums of products of the factors `rows` with `numbers`, as one matrix product.

        What is no sum stays out of it, as out of one that is recorded: the place of a row in its matrix may tell in
        the last bit.
        """
        given = {k: value for k, value in numbers.items() if not _constant(value, 0.0)}
        taken = [{k: self.take(v) for k, v in row.items() if k in given} for row in rows]
        found: list[Value] = [given[next(iter(row))] if _alone(row) else 0.0 for row in taken]
        sums = [at for at, row in enumerate(taken) if row and not _alone(row)]
        for at, value in zip(sums, self._sums([taken[at] for at in sums], given), strict=True):
            found[at] = value
        return found

    def _sums(self, rows: Sequence[Row], numbers: Mapping[int, Value]) -> list[Array]:
        columns = {k: place for place, k in enumerate(numbers)}
        stack = np.empty((*self.shape[:-1], len(numbers), self.shape[-1]))
        for place, value in enumerate(numbers.values()):
            stack[..., place, :] = value
        sums = np.empty((*self.shape[:-1], len(rows), self.shape[-1]))
        if rows:
            Combination.of(rows, columns, self.shape).times(stack, sums)
        return [sums[..., k, :] for k in range(len(rows))]


def _constant(value: Value, number: float) -> bool:
    return isinstance(value, float) and value == number


def _alone(row: Row) -> bool:
    """Whether a row is one number as it stands."""
    return len(row) == 1 and _constant(next(iter(row.values())), 1.0)
