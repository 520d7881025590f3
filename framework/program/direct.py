"""Arithmetic that is done at once, where a program would not run often enough to be written down first."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Protocol

import numpy as np

from ..batch import Shape
from ..structure.parts import Value
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
        """Sums of products of the factors `rows` with `numbers`, as one matrix product."""
        columns = {k: place for place, k in enumerate(numbers)}
        combination = Combination.of([{k: self.take(v) for k, v in row.items()} for row in rows], columns, self.shape)
        stack = np.empty((*self.shape[:-1], len(numbers), self.shape[-1]))
        for place, value in enumerate(numbers.values()):
            stack[..., place, :] = value
        sums = np.empty((*self.shape[:-1], len(rows), self.shape[-1]))
        combination.times(stack, sums)
        return [sums[..., k, :] if row else 0.0 for k, row in enumerate(rows)]
