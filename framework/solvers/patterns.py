"""What follows from which unknowns are coupled alone, kept by its content: frames of one topology share it.

Of small and middle-sized frames to find this again takes longer than the numbers; of large ones it is found each time.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, TypeVar

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import all_of
from ..cache import PATTERNS

Index = NDArray[np.int64]
Found = TypeVar("Found")

# Numbers from which on what follows from them is not kept.
MANY = 2**17
# Things that follow from the pattern of a matrix, and some numbers each, that are found again by it.
_FEW = 16
# What a product of two entries of a matrix weighs.
_PRODUCT = 3


def kept(what: str, numbers: Sequence[NDArray[Any]], make: Callable[[], Found], weight: int = 0) -> Found:
    """What follows from some numbers, made where it is not known yet; nobody may change it.

    Parameters
    ----------
    what
        Name of what it is.
    numbers
        All that it depends on.
    make
        Makes it.
    weight
        What it weighs beyond these.
    """
    weight += sum(each.size for each in numbers)
    if weight > MANY:
        return make()
    key = (what, *((each.dtype.char, each.shape, each.tobytes()) for each in numbers))
    found: Found = PATTERNS.found(key, make, weight)
    return found


def kept_of(
    what: str, matrix: scipy.sparse.csr_matrix, numbers: Sequence[NDArray[Any]], make: Callable[[], Found]
) -> Found:
    """What follows from the pattern of a matrix and some numbers: `kept`, and found again by the pattern itself."""
    known: dict[tuple[object, ...], Found] | None = getattr(matrix, "known", None)
    if known is None:
        return kept(what, (matrix.indptr, matrix.indices, *numbers), make)
    key = (what, *(each.tobytes() for each in numbers))
    found = known.get(key)
    if found is None:  # two threads may both make it, which does no harm
        found = kept(what, (matrix.indptr, matrix.indices, *numbers), make)
        if len(known) >= _FEW:
            known.clear()
        known[key] = found
    return found


def rows_of(matrix: scipy.sparse.csr_matrix) -> Index:
    """Row of each entry of a matrix."""
    return kept_of("rows", matrix, (), lambda: np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)))


def diagonal_of(matrix: scipy.sparse.csr_matrix) -> NDArray[Any]:
    """The diagonal (n,) of a matrix (n, n) in which no entry stands twice."""
    places = kept_of("diagonal", matrix, (), lambda: np.flatnonzero(rows_of(matrix) == matrix.indices))
    if len(places) == matrix.shape[0]:
        return matrix.data[places]
    out = np.zeros(matrix.shape[0], matrix.dtype)
    out[matrix.indices[places]] = matrix.data[places]
    return out


def connected(first: Index, second: Index, count: int) -> Index:
    """Connected component of each of `count` places, of which pairs are joined, (count,)."""

    def label() -> Index:
        return _label(adjacency(first, second, count))

    return kept("connected", (first, second, np.array(count)), label)


def connected_by(matrix: scipy.sparse.csr_matrix) -> Index:
    """Connected component of each row of a symmetric matrix without zeros, (n,)."""
    return kept_of("connected by", matrix, (), lambda: _label(matrix))


def labelled(label: Index, wanted: Index) -> NDArray[np.bool_]:
    """Whether each place has one of the `wanted` labels, (n,)."""
    asked = np.zeros(int(label.max(initial=-1)) + 1, dtype=bool)
    asked[wanted] = True
    return asked[label]


def narrow(first: Index, second: Index, count: int) -> Index:
    """Order of `count` places, of which pairs are joined, that keeps neighbours near each other, (count,)."""

    def order() -> Index:
        if not count:  # SciPy asks for the greatest of none
            return np.zeros(0, dtype=np.int64)
        joined = adjacency(np.concatenate([first, second]), np.concatenate([second, first]), count)
        return scipy.sparse.csgraph.reverse_cuthill_mckee(joined, symmetric_mode=True).astype(np.int64)

    return kept("narrow", (first, second, np.array(count)), order)


def adjacency(first: Index, second: Index, count: int) -> scipy.sparse.csr_matrix:
    """A matrix (count, count) with entries at the pairs of places, each of which may stand there several times."""
    order = np.argsort(second, kind="stable")
    return _by_rows(np.ones(len(order)), first[order], second[order], (count, count))


def pattern_by_rows(row: Index, column: Index, shape: tuple[int, int]) -> tuple[Index, scipy.sparse.csr_matrix]:
    """Order of entries row by row, each row's as they come, and a matrix of their pattern."""
    order = np.argsort(row, kind="stable")
    return order, _sorted(np.ones(len(order)), row[order], column[order], shape)


def part(matrix: scipy.sparse.csr_matrix, where: NDArray[np.bool_]) -> scipy.sparse.csr_matrix:
    """The rows and columns of a matrix (n, n) `where` (n,) that is true."""

    def pattern() -> tuple[Index, scipy.sparse.csr_matrix]:
        row = rows_of(matrix)
        places = np.flatnonzero(where[row] & where[matrix.indices])
        number, size = np.cumsum(where) - 1, int(where.sum())
        row, column = number[row[places]], number[matrix.indices[places]]
        return places, _sorted(np.ones(len(places)), row, column, (size, size))

    places, found = kept_of("part", matrix, (where,), pattern)
    return filled(found, matrix.data[places])


class ProductPattern:
    """Which products of the numbers of two matrices add up to which number of ``A D B``, D diagonal; sums follow the
    rows of A.

    Parameters
    ----------
    first, second
        Matrices of the patterns of A and B.
    """

    def __init__(self, first: scipy.sparse.csr_matrix, second: scipy.sparse.csr_matrix) -> None:
        shape, each = (first.shape[0], second.shape[1]), np.diff(second.indptr).astype(np.int64)
        row = np.repeat(np.arange(shape[0]), np.diff(first.indptr))
        times = each[first.indices]
        one = np.repeat(np.arange(len(times)), times)
        other = second.indptr[first.indices[one]] + np.arange(len(one)) - np.repeat(np.cumsum(times) - times, times)
        places, target = np.unique(row[one] * shape[1] + second.indices[other], return_inverse=True)
        order, self._sums = pattern_by_rows(target, first.indices[one].astype(np.int64), (len(places), first.shape[1]))
        self._one, self._other = one[order], other[order]
        self._whole = _sorted(np.ones(len(places)), *np.divmod(places, shape[1]), shape)

    def shares(self, first: NDArray[Any], second: NDArray[Any]) -> scipy.sparse.csr_matrix:
        """What each number of D adds to each of the product, by the numbers of A and B."""
        return filled(self._sums, first[self._one] * second[self._other])

    def of(self, shares: scipy.sparse.csr_matrix, diagonal: NDArray[Any]) -> scipy.sparse.csr_matrix:
        """The product by its `shares` and the numbers of D, without what is exactly zero."""
        data = times(shares, diagonal)
        return filled(self._whole, data) if all_of(data) else without_zeros(self._whole, data)


def product_pattern(first: scipy.sparse.csr_matrix, second: scipy.sparse.csr_matrix) -> ProductPattern | None:
    """The pattern of ``A B``; None where it takes more room than a product takes time."""
    weight = _PRODUCT * int(np.diff(second.indptr)[first.indices].sum())
    if weight > MANY:
        return None
    tables = (first.indptr, first.indices, second.indptr, second.indices)
    return kept("product", tables, lambda: ProductPattern(first, second), weight)


def without_zeros(pattern: scipy.sparse.csr_matrix, data: NDArray[Any]) -> scipy.sparse.csr_matrix:
    """A matrix of the pattern of another one, of which what is exactly zero is left out."""
    used = data != 0.0

    def fewer() -> tuple[Index, scipy.sparse.csr_matrix]:
        places = np.flatnonzero(used)
        row = rows_of(pattern)[places]
        return places, _sorted(np.ones(len(places)), row, pattern.indices[places].astype(np.int64), pattern.shape)

    places, found = kept_of("without zeros", pattern, (used,), fewer)
    return filled(found, data[places])


def filled(pattern: scipy.sparse.csr_matrix, data: NDArray[Any]) -> scipy.sparse.csr_matrix:
    """A matrix of the pattern of another one, whose numbers of places it shares."""
    out = scipy.sparse.csr_matrix.__new__(scipy.sparse.csr_matrix)
    vars(out).update(vars(pattern), data=data)
    return out


def times(matrix: scipy.sparse.csr_matrix, values: NDArray[Any]) -> NDArray[Any]:
    """``matrix @ values`` of numbers (n,) or (n, m) of the matrix's own kind.

    SciPy takes longer to tell what it is given than to multiply small matrices; what it calls then is no public name.
    """
    kernels = getattr(scipy.sparse, "_sparsetools", None)
    if kernels is None:
        return np.asarray(matrix @ values)
    (rows, columns), pattern = matrix.shape, (matrix.indptr, matrix.indices, matrix.data)
    if len(values) != columns:  # the kernels would read beyond
        raise ValueError(f"values have the shape {values.shape}: give ({columns},) or ({columns}, m)")
    out = np.zeros((rows, *values.shape[1:]), values.dtype)
    if values.size == columns:
        kernels.csr_matvec(rows, columns, *pattern, values.ravel(), out.ravel())
    else:
        kernels.csr_matvecs(rows, columns, values.shape[1], *pattern, values.ravel(), out.ravel())
    return out


def _label(matrix: scipy.sparse.csr_matrix) -> Index:
    return scipy.sparse.csgraph.connected_components(matrix, directed=False)[1].astype(np.int64)


def _by_rows(data: NDArray[Any], row: Index, column: Index, shape: tuple[int, int]) -> scipy.sparse.csr_matrix:
    order = np.argsort(row, kind="stable")
    return _sorted(data[order], row[order], column[order], shape)


def _sorted(data: NDArray[Any], row: Index, column: Index, shape: tuple[int, int]) -> scipy.sparse.csr_matrix:
    """A matrix by its entries, row by row."""
    start = np.zeros(shape[0] + 1, dtype=np.int32)
    np.cumsum(np.bincount(row, minlength=shape[0]), out=start[1:])
    out = scipy.sparse.csr_matrix((data, column.astype(np.int32), start), shape=shape)
    # those that are `filled` from it share what is found of its pattern, see `kept_of`
    vars(out).update(known={})
    return out
