"""Linear combinations of numbers as matrix products, where the factors do not vary along the last batch axis."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from ..batch import Array
from ..structure.parts import Row, Value, combine

# Number of columns multiplied at a time; fixed, so that the order of every sum does not depend on the chunks.
BLOCK = 256
# No matrix is formed if it has a smaller share of nonzero factors, or if the last axis is shorter than this.
_FULL = 0.2
_SHORT = 16


@dataclass(frozen=True)
class Combination:
    """m linear combinations of n numbers.

    Attributes
    ----------
    rows
        For each combination its factors by key of the number.
    columns
        Column of each number, by key.
    matrix
        The factors, (..., m, n), if they do not vary along the last batch axis and are not mostly zero; else None.
    """

    rows: Sequence[Row]
    columns: Mapping[int, int]
    matrix: Array | None

    @classmethod
    def of(cls, rows: Sequence[Row], columns: Mapping[int, int], shape: tuple[int, ...]) -> Combination:
        """The combination of some `rows` for a batch of a `shape`."""
        factors = [factor for row in rows for factor in row.values()]
        varying = np.broadcast_shapes((1,) * len(shape), *(np.shape(factor) for factor in factors))
        if shape[-1] < _SHORT or varying[-1] > 1 or len(factors) < _FULL * len(rows) * len(columns):
            return cls(rows, columns, None)
        matrix = np.zeros((*varying[:-1], len(rows), len(columns)))
        for i, row in enumerate(rows):
            for k, factor in row.items():
                matrix[..., i, columns[k]] = factor[..., 0] if isinstance(factor, np.ndarray) else factor
        return cls(rows, columns, matrix)

    def cut(self, axis: int, indices: slice) -> Combination:
        """The combination at some indices of a batch axis."""
        part = (slice(None),) * axis + (indices,)
        if self.matrix is None:
            return replace(self, rows=[{k: _cut(factor, axis, part) for k, factor in row.items()} for row in self.rows])
        last = axis == self.matrix.ndim - 2
        return self if last or self.matrix.shape[axis] == 1 else replace(self, matrix=self.matrix[part])

    def times(self, numbers: Array, out: Array) -> None:
        """Write the combinations of `numbers` (..., n, length) into `out` (..., m, length)."""
        if self.matrix is None:
            for i, row in enumerate(self.rows):
                out[..., i, :] = combine([(f, numbers[..., self.columns[k], :]) for k, f in row.items()])
            return
        for start in range(0, out.shape[-1], BLOCK):
            part = slice(start, start + BLOCK)
            np.matmul(self.matrix, numbers[..., part], out=out[..., part])


def _cut(factor: Value, axis: int, part: tuple[slice, ...]) -> Value:
    return factor[part] if isinstance(factor, np.ndarray) and factor.shape[axis] > 1 else factor
