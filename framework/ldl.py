"""LDLᵀ of many symmetric matrices of one pattern at once: arrays (entries, ...), the batch axes last.

A `PivotStep` lists the entries that the elimination of one unknown changes. The steps are found once for each pattern:
for full matrices row by row (`full_steps`), each row a slice, and for sparse ones for all entries of the lower half at
once (`sparse_steps`). The numbers may be of any type that NumPy multiplies, in double or extended precision, or terms
of a program that is being recorded.

The recurrence stands once more in `batched.stage`, for sums of parts that vary over different axes of a batch, as one
text takes longer for either: that one 1.9 to 6.9 times as long for numbers of one shape, and this one, given sums as
elements of arrays or lists, up to three times as long for sums.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .batch import Array
from .cache import KERNELS
from .elementwise import contracted, maximum

Numbers = NDArray[Any]
Places = slice | NDArray[np.int64]
# The column of L and the inverse pivot of each step.
Columns = list[tuple[Numbers, Numbers]]


class PivotStep(NamedTuple):
    """One step of the elimination: the entries that it reads and those that it changes.

    Places are positions along the first axis of the array of entries.

    Attributes
    ----------
    unknown
        Number of the unknown that is eliminated.
    pivot
        Place of its diagonal entry.
    below
        Unknowns that are coupled with it and not yet eliminated.
    column
        Places of the entries that couple it with `below`.
    updates
        Triples (places, i, j): from the entries at these places the product of the column entries of ``below[i]`` and
        ``below[j]`` over the pivot is subtracted.
    """

    unknown: int
    pivot: int
    below: Places
    column: Places
    updates: tuple[tuple[Places, int | NDArray[np.int64], Places], ...]


def full_steps(size: int) -> tuple[PivotStep, ...]:
    """Steps for full matrices whose rows are stored one after the other; entries below the diagonal are not read."""

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
        Pairs (unknown, below) in the order of elimination; `below` are the unknowns that are coupled with it and not
        yet eliminated, fill included.
    place
        Places of the entries (i, j), i >= j; those of the fill are added.

    Returns
    -------
    tuple
        The steps.
    """

    def at(i: int, j: int) -> int:
        return place.setdefault((i, j) if i >= j else (j, i), len(place))

    pivots, out = list(pivots), []
    pairs = {size: np.tril_indices(size) for size in {len(below) for _, below in pivots}}
    for k, below in pivots:
        column = np.array([at(i, k) for i in below], dtype=np.int64)
        target = np.array([at(i, j) for a, i in enumerate(below) for j in below[: a + 1]], dtype=np.int64)
        updates = ((target, *pairs[len(below)]),) if below else ()
        out.append(PivotStep(k, place[k, k], np.array(below, dtype=np.int64), column, updates))
    return tuple(out)


def eliminated(
    work: Numbers, steps: Sequence[PivotStep], inverse: Callable[[int, Numbers], Numbers] | None = None
) -> Columns:
    """Factorise matrices.

    Parameters
    ----------
    work
        Their entries, (entries, ...), overwritten; the diagonal holds the pivots afterwards.
    steps
        Steps of the elimination for their pattern.
    inverse
        ``inverse(unknown, pivot)`` gives the inverse of a pivot; 1 / pivot where None.

    Returns
    -------
    list
        For each step the column of L, (below, ...), and the inverse pivot, (...).
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
    """Solve by forward and back substitution, overwriting loads (n, N) or (n, m, N) with the solutions.

    `columns` are the factors that `eliminated` found for N matrices (entries, N).
    """
    forward(steps, columns, load)
    for step, (lower, over) in reversed(list(zip(steps, columns, strict=True))):
        load[step.unknown] *= over
        if step.updates:
            load[step.unknown] -= _added(lower, load[step.below])


def forward(steps: Sequence[PivotStep], columns: Columns, load: Numbers) -> None:
    """Forward substitution, the first half of `substitute`: L⁻¹ times the loads, which are overwritten."""
    between = slice(None) if load.ndim == 2 else (slice(None), None)
    for step, (lower, _) in zip(steps, columns, strict=True):
        if step.updates:
            load[step.below] -= lower[between] * load[step.unknown]


def backward(columns: Columns, load: Numbers) -> None:
    """Backward substitution with full matrices for loads (n, N) that `forward` has changed, which are overwritten.

    In contrast to `substitute` it sums term by term, and so gives the same bits for numbers and for terms.
    """
    for k in range(len(load) - 1, -1, -1):
        lower, over = columns[k]
        load[k] = load[k] * over
        for i, each in enumerate(lower, k + 1):
            load[k] = load[k] - each * load[i]


def _added(lower: Numbers, solved: Numbers) -> Numbers:
    """Sum over the n unknowns below of entries of L, (n, N), times their solutions, (n, N) or (n, m, N)."""
    if len(lower) == 1:
        product: Numbers = lower[0] * solved[0]
        return product
    return contracted("im,im->m" if solved.ndim == 2 else "im,ijm->jm", lower, solved)


def factorised(matrix: Array, share: float, *, raised: bool = True) -> Columns:
    """Factors of full positive semidefinite matrices, for `substituted`.

    Parameters
    ----------
    matrix
        The matrices, (n, n, ...), overwritten.
    share
        A pivot that is no more than this share of its diagonal entry counts as zero.
    raised
        Whether such a pivot is raised to that share; if False, its inverse and its column of L are set to zero.

    Returns
    -------
    list
        See `eliminated`.
    """
    n = len(matrix)
    work = matrix.reshape(n * n, *matrix.shape[2:])
    least = share * np.abs(work[:: n + 1]) + np.finfo(float).tiny

    def inverse(k: int, pivot: Array) -> Array:
        out: Array = 1.0 / maximum(pivot, least[k])
        return out if raised else np.where(pivot > least[k], out, 0.0)

    return eliminated(work, full_steps(n), inverse)


def substituted(columns: Columns, load: Array) -> Array:
    """Solutions for loads (n, N) or (n, m, N), of the same shape, by the factors of full matrices (n, n, N)."""
    out = load.copy()
    substitute(full_steps(len(out)), columns, out)
    return out
