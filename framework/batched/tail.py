"""The last unknowns of an elimination, those that vary over most of the batch: a sparse LDL^T, chunk by chunk.

Each operation is one pass over arrays that stay in the cache. Loads and results, which are sums over known numbers and
unknowns with factors that mostly vary less than these, are matrix products.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ..batch import Array, Shape
from ..structure.parts import Grid, Parts, Value, total
from .combination import Combination
from .stage import Stage, reciprocal

# A coupling smaller than this share of the two diagonal entries is less than the rounding of what it came from, in
# extended precision. There are such: forces in a statically determinate linkage do not depend on its springs.
_NOTHING = 2.0**-60
# Least ratio of pivots to their scale from which on nothing needs to be watched.
_SOUND = 1e-6


@dataclass(frozen=True)
class Remainder:
    """What is left of a stage when all that many entries share is done, in double precision.

    Attributes
    ----------
    pivots
        The unknowns in order.
    matrix
        Parts of the entries by place: of each row the diagonal and what is above it, room for the fill included.
    scale
        Parts of the stiffness whose rounding the diagonal carries.
    margin
        What no ratio of a pivot to its scale falls below; 0.0 where that is not known beforehand.
    loads
        Loads on the unknowns, over the known numbers.
    knowns
        The known numbers.
    negligible
        Number of couplings left out because they are less than rounding.
    """

    pivots: list[int]
    matrix: list[dict[int, Parts]]
    scale: list[Parts]
    margin: float
    loads: Combination
    knowns: list[Value]
    negligible: int

    @classmethod
    def of(cls, stage: Stage, pivots: list[int], knowns: list[Value], grid: Grid, done: set[int]) -> Remainder:
        """What `stage` leaves of `pivots` after steps that vary over the masks `done`."""
        matrix = _upper(stage, pivots)
        left = set(pivots)
        coupled = sum(len(left & stage.matrix.get(k, {}).keys() - {k}) for k in pivots) // 2
        negligible = coupled - sum(len(row) - 1 for row in matrix)
        _fill(matrix)
        forces = [stage.forces.get(k, {}) for k in pivots]
        loads = [{-1 - s: _double(total(parts)[1]) for s, parts in by_source.items()} for by_source in forces]
        scale = [{mask: _double(v) for mask, v in stage.scale.get(k, {}).items()} for k in pivots]
        columns = {-1 - s: s for s in range(len(knowns))}
        combined = Combination.of(loads, columns, grid.shape)
        margin = _margin(stage, pivots, done)
        return cls(pivots, matrix, scale, margin, combined, [_double(v) for v in knowns], negligible)

    @property
    def columns(self) -> Mapping[int, int]:
        """Where the unknowns, and after them the known numbers, stand in the solution."""
        unknown = {k: place for place, k in enumerate(self.pivots)}
        return unknown | {-1 - s: len(self.pivots) + s for s in range(len(self.knowns))}

    def cut(self, change: Callable[[Value], Value], axis: int, indices: slice) -> Remainder:
        """A chunk of it; `change` cuts a number."""
        return replace(
            self,
            matrix=[{j: {m: change(v) for m, v in parts.items()} for j, parts in row.items()} for row in self.matrix],
            scale=[{m: change(v) for m, v in parts.items()} for parts in self.scale],
            loads=self.loads.cut(axis, indices),
            knowns=[change(value) for value in self.knowns],
        )


def _double(value: Value) -> Value:
    return value.astype(np.float64, copy=False) if isinstance(value, np.ndarray) else float(value)


def _upper(stage: Stage, pivots: list[int]) -> list[dict[int, Parts]]:
    """Rows of the matrix from the diagonal on, without the couplings that are nothing."""
    place = {k: a for a, k in enumerate(pivots)}
    least = {k: sum(float(np.min(v)) for v in stage.matrix.get(k, {}).get(k, {}).values()) for k in pivots}
    out: list[dict[int, Parts]] = []
    for k in pivots:
        row: dict[int, Parts] = {place[k]: {}}
        for j, parts in stage.matrix.get(k, {}).items():
            if place[j] < place[k] or (j != k and _negligible(parts, least[k], least[j])):
                continue
            row[place[j]] = {mask: _double(value) for mask, value in parts.items()}
        out.append(row)
    return out


def _negligible(parts: Parts, first: float, second: float) -> bool:
    most = sum(float(np.max(np.abs(value))) for value in parts.values())
    return min(first, second) > 0.0 and most <= _NOTHING * np.sqrt(first) * np.sqrt(second)


def _margin(stage: Stage, pivots: list[int], done: set[int]) -> float:
    """Least ratio of a pivot d to its scale s, from below; 0.0 where it may be less than `_SOUND`.

    On the diagonal stand springs D, coupled with nothing, and the rest A, which is positive semidefinite as a whole. So
    ``d_i >= D_i``, the pivots before take ``sum l_ik^2 d_k <= A_ii`` from it, and with ``s_i = w_i + sum l_ik^2 s_k``
    every ``s_i / d_i <= (w_i + A_ii max_k<i s_k / d_k) / D_i``.
    """
    worst = 1.0
    for k in pivots:
        row = stage.matrix.get(k, {})
        diagonal, others = row.get(k, {}), {mask for j, parts in row.items() if j != k for mask in parts} | done
        # A part of the diagonal that varies as no coupling, no step and no other part does.
        alone = {m for m in diagonal if not any(m & other == m for other in others | diagonal.keys() - {m})}
        springs = sum(float(np.min(diagonal[mask])) for mask in alone)
        rest = sum(float(np.max(np.abs(value))) for mask, value in diagonal.items() if mask not in alone)
        weight = sum(float(np.max(value)) for value in stage.scale.get(k, {}).values())
        if not (springs > 0.0 and (weight + rest * worst) * _SOUND < springs):
            return 0.0
        worst = max(worst, (weight + rest * worst) / springs)
    return 1.0 / worst


def _fill(matrix: list[dict[int, Parts]]) -> None:
    """Make room for what the elimination adds."""
    for k, row in enumerate(matrix):
        after = sorted(row.keys() - {k})
        for a, i in enumerate(after):
            for j in after[a:]:
                matrix[i].setdefault(j, {})


class Tail:
    """Factorisation and solution of a chunk.

    Parameters
    ----------
    rest
        What is left, cut to the chunk.
    shape
        Batch shape of the chunk.
    """

    def __init__(self, rest: Remainder, shape: Shape) -> None:
        self._most: Value = 0.0
        self._least: Value = np.inf
        size = len(rest.pivots)
        self._all = np.empty((*shape[:-1], size + len(rest.knowns), shape[-1]))
        for s, value in enumerate(rest.knowns):
            self._all[..., size + s, :] = value
        rest.loads.times(self._all[..., size:, :], self._all[..., :size, :])
        # One place for products, which stays in the cache.
        self._product = np.empty(shape)
        self._x = [self._all[..., k, :] for k in range(size)]
        self._loaded = {k for k, row in enumerate(rest.loads.rows) if row}
        self._rows = [{j: _summed(parts) for j, parts in row.items()} for row in rest.matrix]
        self._watched = not rest.margin
        self._scale = [_summed(parts) for parts in rest.scale] if self._watched else []
        for k in range(size):
            self._step(k)
        for k in reversed(range(size)):
            for j, low in self._rows[k].items():
                self._reduce(self._x[k], low, self._x[j])
        # Least ratio of a pivot to its scale; a negative one is less than any other.
        watched = np.where(self._least < 0.0, self._least, self._most)
        self.margin: Value = reciprocal(watched) if self._watched else rest.margin
        del self._product, self._x, self._rows, self._scale, self._most, self._least

    def values(self, rows: Combination, out: Array) -> None:
        """Put each of `rows` over the unknowns and the known numbers into `out` (..., rows, length)."""
        rows.times(self._all, out)

    def _step(self, k: int) -> None:
        """Eliminate k: its row becomes the column of L below it, its load that of ``D^-1 L^-1 f``."""
        row = self._rows[k]
        inverse = reciprocal(row.pop(k))
        share: Value = 0.0
        if self._watched:
            share = self._scale[k] * inverse
            self._most, self._least = np.maximum(self._most, share), np.minimum(self._least, share)
        lower = {j: value * inverse for j, value in row.items()}
        for i, low in lower.items():
            target = self._rows[i]
            for j in target.keys() & row.keys():
                term = self._times(low, row[j])
                target[j] = _into(np.subtract, target[j], term)
                if i == j and self._watched:
                    self._scale[i] = _into(np.add, self._scale[i], term * share)
            if k in self._loaded:
                self._reduce(self._x[i], low, self._x[k])
                self._loaded.add(i)
        np.multiply(self._x[k], inverse, out=self._x[k])
        self._rows[k] = lower

    def _times(self, low: Value, value: Value) -> Value:
        """Their product, which the next one may overwrite."""
        if isinstance(low, np.ndarray) and low.shape == self._product.shape:
            return np.multiply(low, value, out=self._product)
        return low * value

    def _reduce(self, target: Array, low: Value, value: Array) -> None:
        """Subtract `low` `value` from `target`."""
        np.subtract(target, np.multiply(low, value, out=self._product), out=target)


def _into(operation: np.ufunc, target: Value, term: Value) -> Value:
    """Sum or difference of `target` and `term`, in the memory of `target` where it is of that shape."""
    if isinstance(target, np.ndarray) and target.shape == np.shape(term):
        found: Value = operation(target, term, out=target)
        return found
    return operation(target, term)  # type: ignore[no-any-return]


def _summed(parts: Parts) -> Value:
    """The sum of `parts` in memory that may be written to."""
    value = total(parts)[1]
    return value.copy() if isinstance(value, np.ndarray) and any(value is part for part in parts.values()) else value
