"""The last unknowns of an elimination, those that vary over most of the batch, for one chunk of it.

They are few and all coupled: a dense LDL^T in place, each operation one pass over arrays that stay in the cache.
"""

from __future__ import annotations

import numpy as np

from .parts import Parts, Value, is_zero, total
from .stage import Matrix, Pivot, reciprocal


class Tail:
    """Dense factorisation of what is left of a stage.

    Parameters
    ----------
    matrix, scale
        What is left, cut to the chunk.
    pivots
        The unknowns in order.
    loads
        Their loads.
    """

    def __init__(self, matrix: Matrix, scale: dict[int, Parts], pivots: list[int], loads: dict[int, Value]) -> None:
        self.order = pivots
        self.entries = {
            (i, j): _own(total(matrix[i][j])[1])
            for a, i in enumerate(pivots)
            for j in pivots[a:]
            if matrix.get(i, {}).get(j)
        }
        self.scale = {k: _own(total(parts)[1]) for k, parts in scale.items()}
        self.loads = {k: _own(load) for k, load in loads.items()}
        self.steps: dict[int, Pivot] = {}
        self.margin: Value = np.inf
        for a, k in enumerate(pivots):
            self._step(k, pivots[a + 1 :])

    def _step(self, k: int, rest: list[int]) -> None:
        pivot = self.entries.get((k, k), 0.0)
        inverse = reciprocal(pivot)
        below = [j for j in rest if (k, j) in self.entries]
        lower = {j: self.entries[k, j] * inverse for j in below}
        weight = self.scale.get(k, 0.0)
        self.margin = np.minimum(self.margin, pivot * reciprocal(weight))
        load = self.loads.get(k, 0.0)
        for a, i in enumerate(below):
            low = lower[i]
            for j in below[a:]:
                self._subtract(i, j, low * self.entries[k, j])
            self.scale[i] = _sum(self.scale.get(i, 0.0), low * low * weight)
            if not is_zero(load):
                self.loads[i] = _sum(self.loads.get(i, 0.0), -low * load)
        self.steps[k] = Pivot(0, inverse, lower)

    def _subtract(self, i: int, j: int, product: Value) -> None:
        entry = self.entries.get((i, j), 0.0)
        if isinstance(entry, np.ndarray) and entry.shape == np.shape(product):
            np.subtract(entry, product, out=entry)
        else:
            self.entries[i, j] = entry - product


def _sum(target: Value, term: Value) -> Value:
    if isinstance(target, np.ndarray) and target.shape == np.shape(term):
        return np.add(target, term, out=target)
    return target + term


def _own(value: Value) -> Value:
    """The value in memory that may be written to."""
    return value.copy() if isinstance(value, np.ndarray) else value
