"""The unknowns that a batch entry would have if it were solved alone, expressed by those of the batch."""

from __future__ import annotations

import numpy as np

from ..batch import Array, Shape
from .constraints import Elimination
from .gauss_jordan import Reduced
from .parts import Row, unknowns
from .topology import Index
from .varying_pivots import alone


def own_unknowns(elimination: Elimination, numbers: list[int]) -> tuple[Array | None, Index]:
    """Matrix from the unknowns of each entry alone to those of the batch, (..., n, n), and numbers of the former.

    The two differ in which unknowns of a loop of ideal components are dependent. The matrix is None where all entries
    have the unknowns of the batch. The numbers are (..., n), or (n,) if they do not vary; -1 marks an unknown that
    represents no displacement at an entry.

    Parameters
    ----------
    elimination
        Dependent unknowns of the batch.
    numbers
        Numbers of the unknowns of the batch, (n,).
    """
    out, column = None, {key: k for k, key in enumerate(numbers)}
    named = np.array(numbers, dtype=np.int64)
    for loop, shape, parts in alone(dict(enumerate(elimination.given))):
        keys = list(dict.fromkeys(key for each in loop.values() for key in unknowns(each.row)))
        columns = np.array([column[key] for key in keys if key in column], dtype=np.int64)
        if not columns.size:
            continue
        whole = np.zeros((*shape, len(numbers), len(numbers))) + np.eye(len(numbers))
        own = np.array(np.broadcast_to(numbers, (*shape, len(numbers))))
        for index, found in parts:
            _enter((whole, own), elimination, (keys, columns, [numbers[k] for k in columns]), index, found)
        out = whole if out is None else out @ whole
        named = np.where(np.isin(np.arange(len(numbers)), columns), own, named)
    return out, named


def _enter(
    entered: tuple[Array, Index],
    elimination: Elimination,
    loop: tuple[list[int], Index, list[int]],
    index: tuple[Index, ...],
    found: Reduced,
) -> None:
    """Enter the unknowns of a loop into matrix and numbers, at the entries `index` that make the same choice alone.

    `loop` holds all unknowns in the loop, the columns of those that are unknowns of the batch, and their numbers.
    """
    (whole, named), (keys, columns, left) = entered, loop
    shape = whole.shape[:-2]
    idle = np.stack([_at(elimination.idle.get(key, 0.0), shape, index) > 0.0 for key in left], axis=-1)
    for pattern in np.unique(idle, axis=0):
        some = tuple(each[(idle == pattern).all(axis=-1)] for each in index)
        # unknowns that represent no displacement stay as they are
        rows: list[Row] = [{key: 1.0} for key, nothing in zip(left, pattern.tolist(), strict=True) if nothing]
        numbers = [-1] * len(rows) + [key for key in keys if key not in found.rows]
        rows += [elimination.rows.get(key, {key: 1.0}) for key in numbers[len(rows) :]]
        if len(rows) != len(left):
            continue  # within rounding the loop is singular for one choice and not for the other
        matrix = np.zeros((len(some[0]), len(rows), len(left)))
        for k, row in enumerate(rows):
            for j, key in enumerate(left):
                matrix[:, k, j] = _at(row.get(key, 0.0), shape, some)
        part = whole[some]
        part[:, columns[:, None], columns] = np.linalg.pinv(matrix)
        whole[some] = part
        named[*(each[:, None] for each in some), columns] = numbers


def _at(value: object, shape: Shape, index: tuple[Index, ...]) -> Array:
    """The values of a number at m entries, (m,)."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), shape)[index]
