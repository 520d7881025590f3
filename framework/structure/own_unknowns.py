"""Unknowns that an entry of a batch would have if it were solved alone, in terms of those of the batch."""

from __future__ import annotations

import numpy as np

from ..batch import Array, Shape
from .constraints import Elimination
from .gauss_jordan import Reduced
from .parts import Row, unknowns
from .topology import Index
from .turned import alone


def own_unknowns(elimination: Elimination, numbers: list[int]) -> tuple[Array | None, Index]:
    """Unknowns of the batch in terms of those that each entry has where it is solved alone, (..., n, n); their numbers.

    They differ in which unknowns of a loop of ideal components are dependent. None where all entries have those of the
    batch. The numbers are (..., n), -1 for what stands for nothing at an entry.

    Parameters
    ----------
    elimination
        Of the batch.
    numbers
        Its unknowns, (n,).
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
    """Enter the unknowns of a loop, and their numbers, at entries that choose alike where they are solved alone.

    Of the loop there are its keys, the columns of those that are unknowns of the batch, and these unknowns.
    """
    (whole, named), (keys, columns, left) = entered, loop
    shape = whole.shape[:-2]
    idle = np.stack([_at(elimination.idle.get(key, 0.0), shape, index) > 0.0 for key in left], axis=-1)
    for pattern in np.unique(idle, axis=0):
        some = tuple(each[(idle == pattern).all(axis=-1)] for each in index)
        # what stands for nothing stays as it is
        rows: list[Row] = [{key: 1.0} for key, nothing in zip(left, pattern.tolist(), strict=True) if nothing]
        numbers = [-1] * len(rows) + [key for key in keys if key not in found.rows]
        rows += [elimination.rows.get(key, {key: 1.0}) for key in numbers[len(rows) :]]
        if len(rows) != len(left):
            continue  # to rounding the loop is singular in the one way and not in the other
        matrix = np.zeros((len(some[0]), len(rows), len(left)))
        for k, row in enumerate(rows):
            for j, key in enumerate(left):
                matrix[:, k, j] = _at(row.get(key, 0.0), shape, some)
        part = whole[some]
        part[:, columns[:, None], columns] = np.linalg.pinv(matrix)
        whole[some] = part
        named[*(each[:, None] for each in some), columns] = numbers


def _at(value: object, shape: Shape, index: tuple[Index, ...]) -> Array:
    """A number of the batch at some entries, (m,)."""
    return np.broadcast_to(np.asarray(value, dtype=np.float64), shape)[index]
