"""Direct evaluation, with the interface of a recording, where a program would not run often enough to pay."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ..batch import Array, Shape
from ..structure.parts import Row, Value
from .combination import Combination


class Arithmetic(Protocol):
    """The common interface of a recording and of direct evaluation."""

    def take(self, value: Value) -> Any:
        """A number as the calculation uses it: a term of a recording, or the number in double precision."""
        ...

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Linear combinations of `numbers` with the factors `rows`."""
        ...


def double(value: Value) -> Value:
    """A number in double precision."""
    return value.astype(np.float64, copy=False) if isinstance(value, np.ndarray) else float(value)


class Direct:
    """Direct evaluation with numbers.

    Parameters
    ----------
    shape
        Shape of the batch.
    """

    def __init__(self, shape: Shape) -> None:
        self.shape = shape

    def take(self, value: Value) -> Value:
        """A number in double precision."""
        return double(value)

    def products(self, rows: Sequence[Mapping[int, Value]], numbers: Mapping[int, Value]) -> list[Value]:
        """Linear combinations of `numbers` with the factors `rows`, as one matrix product.

        Rows that are a single number are left out of the product, as in a recording, since the position of a row in a
        matrix may affect the last bit of its product.
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
    """Whether a row is a single number with the factor one."""
    return len(row) == 1 and _constant(next(iter(row.values())), 1.0)
