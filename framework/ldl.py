"""LDLᵀ of symmetric matrices of one pattern, in two forms of storage.

One step is `_eliminate`, and one of back substitution `_solved`; they leave open how entries are stored.

Arrays (entries, ...), the batch axes last: a `PivotStep` lists the entries that the elimination of one unknown changes.
The steps are found once for each pattern: for full matrices row by row (`full_steps`), each row a slice, and for sparse
ones for all entries of the lower half at once (`sparse_steps`). The numbers may be of any type that NumPy multiplies,
in double or extended precision, or terms of a program that is being recorded.

Sums of parts that vary over different axes of a batch (`eliminated_parts` and the like), see `structure.parts`: entries
have batch shapes of their own, most columns are short, and many numbers are the same for all entries.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import combinations_with_replacement
from operator import mul
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .batch import Array
from .cache import KERNELS
from .elementwise import contracted, maximum
from .structure.parts import Loads, Matrix, Parts, Value, collapsed_each, pivot_column

Numbers = NDArray[Any]
Places = slice | NDArray[np.int64]
# The column of L and the inverse pivot of each step.
Columns = list[tuple[Numbers, Numbers]]


def _eliminate(column: Any, over: Any, first: Iterable[Any], second: Iterable[Any]) -> tuple[Any, Iterator[Any]]:
    """Eliminate one unknown: ``l = a / d``, and ``l_i a_j`` for pairs of the unknowns below.

    Parameters
    ----------
    column
        Entries a that couple it with those below: an array (below, ...), or a list of numbers of any shapes.
    over
        The inverse pivot 1 / d.
    first, second
        Positions i and j of the pairs in the column, or of many pairs at once.

    Returns
    -------
    tuple
        The column l of L, an array or a list; and the products, which are to be subtracted from the pairs' entries.
    """
    lower = column * over if isinstance(column, np.ndarray) else [entry * over for entry in column]
    return lower, map(mul, map(lower.__getitem__, first), map(column.__getitem__, second))


def _solved(load: Any, over: Any, below: Iterable[tuple[Any, Any]]) -> Any:
    """An unknown by back substitution: its load times the inverse pivot, less ``l x`` for the pairs (l, x) below it."""
    value = load * over
    for lower, other in below:
        value = value - lower * other
    return value


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
        targets, first, second = zip(*step.updates, strict=True) if step.updates else ((), (), ())
        lower, products = _eliminate(work[step.column], over, first, second)
        for target, product in zip(targets, products, strict=True):
            work[target] -= product
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
        load[k] = _solved(load[k], over, zip(lower, load[k + 1 :], strict=True))


def _added(lower: Numbers, solved: Numbers) -> Numbers:
    """Sum over the n unknowns below of entries of L, (n, N), times their solutions, (n, N) or (n, m, N)."""
    if len(lower) == 1:
        product: Numbers = lower[0] * solved[0]
        return product
    return contracted("im,im->m" if solved.ndim == 2 else "im,ijm->jm", lower, solved)


@dataclass(frozen=True)
class Pivot:
    """One step for sums of parts: its mask, the inverse pivot, and the column of L by unknown."""

    mask: int
    inverse: Value
    lower: dict[int, Value]


def eliminated_parts(
    matrix: Matrix, scale: dict[int, Parts], ratio: Parts, steps: Iterable[tuple[int, list[int], int]]
) -> dict[int, Pivot]:
    """Factorise a matrix of sums of parts, as far as some steps go.

    Parameters
    ----------
    matrix
        Its rows, from which the steps take away what they eliminate.
    scale
        Parts of the scale of each diagonal entry, which grows with the elimination.
    ratio
        Least pivot ratio by mask, which is lowered. With the earlier unknowns relaxed, a unit motion of an unknown has
        a shape z; the pivot is its energy ``z.A z``, whose rounding is that of ``z.diag(A) z``. The scale is an upper
        bound on the latter.
    steps
        Triples (unknown, below, mask): the unknowns in its column, and the axes over which the column varies.

    Returns
    -------
    dict
        The steps by unknown.
    """
    done = {}
    for k, below, mask in steps:
        (varying, pivot), (over, weight), entries = pivot_column(matrix.pop(k, {}), k, below, scale.pop(k, {}))
        inverse = reciprocal(pivot)
        carried = weight * inverse
        least = reciprocal(carried)
        axes = varying | over
        ratio[axes] = np.minimum(ratio[axes], least) if axes in ratio else least

        for i in below:
            del matrix[i][k]
        rows = [matrix.setdefault(i, {}) for i in below]
        first, second = _pairs(len(below))
        lower, products = _eliminate([value for _, _, value in entries], inverse, first, second)
        for a, b, product in zip(first, second, products, strict=True):
            (i, own, _), (j, other, _), filled = entries[a], entries[b], rows[a]
            axes = own | other | varying
            if a == b:
                parts, wider, term = scale.setdefault(i, {}), axes | over, product * carried
                parts[wider] = parts[wider] + term if wider in parts else term
            if j not in filled:
                filled[j] = rows[b][i] = {}
            parts = filled[j]
            parts[axes] = parts[axes] - product if axes in parts else -product
        done[k] = Pivot(mask, inverse, dict(zip(below, lower, strict=True)))
    return done


@cache
def _pairs(count: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Positions of all pairs of so many, each with itself and with those after it."""
    pairs = list(combinations_with_replacement(range(count), 2))
    return tuple(i for i, _ in pairs), tuple(j for _, j in pairs)


def forward_parts(steps: Iterable[tuple[int, Pivot]], forces: Loads, wanted: Sequence[bool]) -> bool:
    """Forward substitution of the loads of eliminated unknowns, by unknown and source, as far as masks are `wanted`.

    Returns whether all were.
    """
    complete = True
    for k, step in steps:
        for source, parts in forces.get(k, {}).items():
            for mask, value in parts.items():
                axes = mask | step.mask
                if not wanted[axes]:
                    complete = False
                    continue
                for j, low in step.lower.items():
                    subtract(forces.setdefault(j, {}).setdefault(source, {}), axes, low * value)
    return complete


def backward_parts(
    pivots: Sequence[int],
    steps: Mapping[int, Pivot],
    forces: Loads,
    sources: Sequence[Value],
    known: dict[int, Value],
) -> None:
    """Back substitution with sums of parts.

    Parameters
    ----------
    pivots
        Unknowns in order of elimination, with all those on which they depend.
    steps
        The steps by unknown.
    forces
        Loads by unknown and source, as `forward_parts` left them.
    sources
        Values of the sources.
    known
        Values by unknown, to which those of `pivots` are added.
    """
    last = pivots[::-1]
    loads = collapsed_each([forces.get(k, {}) for k in last], sources)
    for k, load in zip(last, loads, strict=True):
        below = [(low, known[j]) for j, low in steps[k].lower.items()]
        below = [(low, other) for low, other in below if isinstance(other, np.ndarray) or other != 0.0]
        known[k] = _solved(load, steps[k].inverse, below)


def subtract(parts: Parts, mask: int, value: Value) -> None:
    """Subtract `value`, which varies over `mask`, from a sum of parts."""
    parts[mask] = parts[mask] - value if mask in parts else -value


def reciprocal(value: Value) -> Value:
    """1 / value; inf for an exact zero, which makes the pivot ratio zero."""
    return np.inf if not isinstance(value, np.ndarray) and value == 0.0 else 1.0 / value


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
