"""LDLᵀ of many symmetric matrices of one pattern at once: entries lead, the batch follows.

Which entries a pivot changes is told by its `PivotStep`, found once for a pattern: for full matrices row by row
(`full_steps`), each row a slice, and for sparse ones all entries of the lower half at a time (`sparse_steps`). The
numbers may be of any kind that NumPy multiplies, in double or extended precision, or terms of a program that is being
recorded.

The recurrence stands once more in `batched.stage`, for sums of terms that vary over different axes of the batch; for
numbers of one shape that takes 1.9 to 6.9 times as long as this.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .batch import Array
from .cache import KERNELS
from .elementwise import contracted

Numbers = NDArray[Any]
Places = slice | NDArray[np.int64]
# Columns of L, and one over the pivot, of each step.
Columns = list[tuple[Numbers, Numbers]]


class PivotStep(NamedTuple):
    """What the elimination of one unknown takes and changes.

    Attributes
    ----------
    unknown
        Its number.
    pivot
        Place of its diagonal entry.
    below
        Unknowns that it is coupled with, and that are not eliminated yet.
    column
        Places of the entries with these.
    updates
        Places of entries that change, and whose of the unknowns below, by product, change them.
    """

    unknown: int
    pivot: int
    below: Places
    column: Places
    updates: tuple[tuple[Places, int | NDArray[np.int64], Places], ...]


def full_steps(size: int) -> tuple[PivotStep, ...]:
    """Steps for full matrices whose rows stand one after the other; what is below the diagonal is not looked at."""

    def make() -> tuple[PivotStep, ...]:
        return tuple(
            PivotStep(
                k,
                k * size + k,
                slice(k + 1, size),
                slice(k * size + k + 1, (k + 1) * size),
                tuple(
                    (slice(i * size + i, (i + 1) * size), i - k - 1, slice(i - k - 1, None)) for i in range(k + 1, size)
                ),
            )
            for k in range(size)
        )

    found: tuple[PivotStep, ...] = KERNELS.found(("full steps", size), make, size)
    return found


def sparse_steps(
    pivots: Iterable[tuple[int, Sequence[int]]], place: dict[tuple[int, int], int]
) -> tuple[PivotStep, ...]:
    """Steps for sparse matrices.

    Parameters
    ----------
    pivots
        Unknowns in the order of elimination, and with each those below it, fill included.
    place
        Places of the entries (i, j), i >= j; those of the fill are added.

    Returns
    -------
    tuple
        The steps.
    """
    out = []
    for k, below in pivots:
        for i in below:
            place.setdefault((max(i, k), min(i, k)), len(place))
        first, second = np.tril_indices(len(below))
        pairs = [(below[a], below[b]) for a, b in zip(first.tolist(), second.tolist(), strict=True)]
        for i, j in pairs:
            place.setdefault((max(i, j), min(i, j)), len(place))
        target = np.array([place[max(p), min(p)] for p in pairs], dtype=np.int64)
        column = np.array([place[max(i, k), min(i, k)] for i in below], dtype=np.int64)
        updates = ((target, first, second),) if below else ()
        out.append(PivotStep(k, place[k, k], np.array(below, dtype=np.int64), column, updates))
    return tuple(out)


def eliminated(
    work: Numbers, steps: Sequence[PivotStep], inverse: Callable[[int, Numbers], Numbers] | None = None
) -> Columns:
    """Factorise.

    Parameters
    ----------
    work
        Entries (entries, ...), overwritten: the diagonal by the pivots.
    steps
        Those of the pattern.
    inverse
        One over the pivot of an unknown, where that is to be other than it is.

    Returns
    -------
    list
        By step the column of L, (below, ...), and one over the pivot, (...).
    """
    done = []
    for step in steps:
        pivot = work[step.pivot]
        over = np.divide(1.0, pivot) if inverse is None else inverse(step.unknown, pivot)
        entries = work[step.column]
        lower = entries * over
        for target, first, second in step.updates:
            work[target] -= lower[first] * entries[second]
        done.append((lower, over))
    return done


def substitute(steps: Sequence[PivotStep], columns: Columns, load: Numbers) -> None:
    """Put solutions in the place of loads (n, ..., N) by what `eliminated` has made of matrices (entries, N)."""
    between = slice(None) if load.ndim == 2 else (slice(None), None)
    both = list(zip(steps, columns, strict=True))
    for step, (lower, _) in both:
        if step.updates:
            load[step.below] -= lower[between] * load[step.unknown]
    for step, (lower, over) in reversed(both):
        load[step.unknown] *= over
        if step.updates:
            load[step.unknown] -= _added(lower, load[step.below])


def _added(lower: Numbers, solved: Numbers) -> Numbers:
    """Sum over the unknowns below, of products of columns of L (n, N) and solutions (n, N) or (n, m, N)."""
    if len(lower) == 1:
        product: Numbers = lower[0] * solved[0]
        return product
    return contracted("im,im->m" if solved.ndim == 2 else "im,ijm->jm", lower, solved)


def factorised(matrix: Array, share: float, *, raised: bool = True) -> Columns:
    """Factors of full matrices that are not negative, for `substituted`.

    Parameters
    ----------
    matrix
        The matrices, (n, n, ...), overwritten.
    share
        Of its diagonal entry; a pivot that is not above that is rounding.
    raised
        Whether such a pivot is raised to that share, or left out with its column of L.

    Returns
    -------
    list
        See `eliminated`.
    """
    n = len(matrix)
    work = matrix.reshape(n * n, *matrix.shape[2:])
    least = share * np.abs(work[:: n + 1]) + np.finfo(float).tiny

    def inverse(k: int, pivot: Array) -> Array:
        out: Array = 1.0 / np.maximum(pivot, least[k])
        return out if raised else np.where(pivot > least[k], out, 0.0)

    return eliminated(work, full_steps(n), inverse)


def substituted(columns: Columns, load: Array) -> Array:
    """Solutions for loads (n, N) or (n, m, N) by the factors of full matrices (n, n, N)."""
    out = load.copy()
    substitute(full_steps(len(out)), columns, out)
    return out
