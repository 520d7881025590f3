"""The last unknowns of an elimination, those that vary over most of the batch, for one chunk of it.

They are few and all coupled: a dense LDL^T in place, each operation one pass over arrays that stay in the cache.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .parts import Parts, Row, Value, combine, is_zero, total
from .stage import Matrix, Sources, collapsed, reciprocal


class Tail:
    """Dense factorisation and solution of what is left of a stage.

    Parameters
    ----------
    matrix, scale
        What is left, cut to the chunk.
    order
        The unknowns in order.
    forces
        Their loads for a unit of each known number.
    knowns
        The known numbers.
    """

    def __init__(
        self,
        matrix: Matrix,
        scale: dict[int, Parts],
        order: list[int],
        forces: dict[int, Sources],
        knowns: Sequence[Value],
    ) -> None:
        self.margin: Value = np.inf
        self.known = {-1 - s: value for s, value in enumerate(knowns)}
        self._entries = {
            (i, j): _own(total(matrix[i][j])[1])
            for a, i in enumerate(order)
            for j in order[a:]
            if matrix.get(i, {}).get(j)
        }
        self._scale = {k: _own(total(parts)[1]) for k, parts in scale.items()}
        self._loads = {k: _own(collapsed(by_source, knowns)) for k, by_source in forces.items()}
        lower = {k: self._step(k, order[a + 1 :]) for a, k in enumerate(order)}
        for k in reversed(order):
            value = self._loads.pop(k)
            for j, low in lower[k].items():
                value = _minus(value, low * self.known[j])
            self.known[k] = value
        del self._entries, self._scale, self._loads

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns and the known numbers."""
        return [combine([(factor, self.known[k]) for k, factor in row.items()]) for row in rows]

    def _step(self, k: int, rest: list[int]) -> dict[int, Value]:
        """Eliminate k and return the column below it; its load becomes that of ``D^-1 L^-1 f``."""
        pivot = self._entries.get((k, k), 0.0)
        inverse = reciprocal(pivot)
        below = [j for j in rest if (k, j) in self._entries]
        lower = {j: self._entries[k, j] * inverse for j in below}
        weight, load = self._scale.get(k, 0.0), self._loads[k]
        self.margin = np.minimum(self.margin, pivot * reciprocal(weight))
        for a, i in enumerate(below):
            low = lower[i]
            for j in below[a:]:
                self._entries[i, j] = _minus(self._entries.get((i, j), 0.0), low * self._entries[k, j])
            if not is_zero(load):
                self._loads[i] = _minus(self._loads[i], low * load)
            self._scale[i] = self._scale.get(i, 0.0) + low * low * weight
        self._loads[k] = load * inverse
        return lower


def _minus(target: Value, term: Value) -> Value:
    """`target` - `term`, in the memory of `target` where it is of the same shape."""
    if isinstance(target, np.ndarray) and isinstance(term, np.ndarray) and target.shape == term.shape:
        return np.subtract(target, term, out=target)
    return target - term


def _own(value: Value) -> Value:
    """The value in memory that may be written to."""
    return value.copy() if isinstance(value, np.ndarray) else value
