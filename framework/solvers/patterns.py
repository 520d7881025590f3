"""Operations on sparse matrices whose patterns are cached by content, so that frames of one topology share them.

For small and middle-sized frames finding a pattern takes longer than the arithmetic; for large ones it is not cached.
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

# Largest weight of a result that is cached.
MANY = 2**17
# Number of results that are kept with a matrix itself.
_FEW = 16
# Weight of a product of two matrix entries.
_PRODUCT = 3


def kept(what: str, numbers: Sequence[NDArray[Any]], make: Callable[[], Found], weight: int = 0) -> Found:
    """A result that depends on some arrays alone, from the cache or computed; it is shared and must not be changed.

    Parameters
    ----------
    what
        Name of the kind of result.
    numbers
        All arrays on which it depends.
    make
        Function that computes it.
    weight
        Weight of the result in the cache, besides that of the arrays.
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
    """A result that depends on the pattern of a matrix and some arrays: as by `kept`, and stored with the matrix."""
    known: dict[tuple[object, ...], Found] | None = getattr(matrix, "known", None)
    if known is None:
        return kept(what, (matrix.indptr, matrix.indices, *numbers), make)
    key = (what, *(each.tobytes() for each in numbers))
    found = known.get(key)
    if found is None:  # two threads may both compute it, which does no harm
        found = kept(what, (matrix.indptr, matrix.indices, *numbers), make)
        if len(known) >= _FEW:
            known.clear()
        known[key] = found
    return found


def rows_of(matrix: scipy.sparse.csr_matrix) -> Index:
    """Row of each stored entry of a matrix."""
    return kept_of("rows", matrix, (), lambda: np.repeat(np.arange(matrix.shape[0]), np.diff(matrix.indptr)))


def diagonal_of(matrix: scipy.sparse.csr_matrix) -> NDArray[Any]:
    """The diagonal (n,) of a matrix (n, n) without duplicate entries."""
    places = kept_of("diagonal", matrix, (), lambda: np.flatnonzero(rows_of(matrix) == matrix.indices))
    if len(places) == matrix.shape[0]:
        return matrix.data[places]
    out = np.zeros(matrix.shape[0], matrix.dtype)
    out[matrix.indices[places]] = matrix.data[places]
    return out


def connected(first: Index, second: Index, count: int) -> Index:
    """Connected component of each of `count` vertices, given edges from `first` to `second`, (count,)."""

    def label() -> Index:
        return _label(adjacency(first, second, count))

    return kept("connected", (first, second, np.array(count)), label)


def connected_by(matrix: scipy.sparse.csr_matrix) -> Index:
    """Connected component of each row of a symmetric matrix without stored zeros, (n,)."""
    return kept_of("connected by", matrix, (), lambda: _label(matrix))


def labelled(label: Index, wanted: Index) -> NDArray[np.bool_]:
    """Whether each vertex has one of the `wanted` labels, (n,)."""
    asked = np.zeros(int(label.max(initial=-1)) + 1, dtype=bool)
    asked[wanted] = True
    return asked[label]


def narrow(first: Index, second: Index, count: int) -> Index:
    """Order of `count` vertices with edges from `first` to `second` that keeps neighbours near each other, (count,).

    It is the reverse Cuthill-McKee order.
    """

    def order() -> Index:
        if not count:  # SciPy asks for the greatest of none
            return np.zeros(0, dtype=np.int64)
        joined = adjacency(np.concatenate([first, second]), np.concatenate([second, first]), count)
        return scipy.sparse.csgraph.reverse_cuthill_mckee(joined, symmetric_mode=True).astype(np.int64)

    return kept("narrow", (first, second, np.array(count)), order)


def adjacency(first: Index, second: Index, count: int) -> scipy.sparse.csr_matrix:
    """A matrix (count, count) with ones at the pairs (first, second), which may occur several times."""
    order = np.argsort(second, kind="stable")
    return _by_rows(np.ones(len(order)), first[order], second[order], (count, count))


def pattern_by_rows(row: Index, column: Index, shape: tuple[int, int]) -> tuple[Index, scipy.sparse.csr_matrix]:
    """Order that sorts entries by row, stable within rows, and a matrix of their pattern."""
    order = np.argsort(row, kind="stable")
    return order, _sorted(np.ones(len(order)), row[order], column[order], shape)


def part(matrix: scipy.sparse.csr_matrix, where: NDArray[np.bool_]) -> scipy.sparse.csr_matrix:
    """The rows and columns of a matrix (n, n) in the mask `where` (n,)."""

    def pattern() -> tuple[Index, scipy.sparse.csr_matrix]:
        row = rows_of(matrix)
        places = np.flatnonzero(where[row] & where[matrix.indices])
        number, size = np.cumsum(where) - 1, int(where.sum())
        row, column = number[row[places]], number[matrix.indices[places]]
        return places, _sorted(np.ones(len(places)), row, column, (size, size))

    places, found = kept_of("part", matrix, (where,), pattern)
    return filled(found, matrix.data[places])


class ProductPattern:
    """The pattern of ``A D B``, with D diagonal, and which products of entries add up to each of its entries.

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
        """Matrix from the diagonal of D to the entries of the product, given the entries of A and B."""
        return filled(self._sums, first[self._one] * second[self._other])

    def of(self, shares: scipy.sparse.csr_matrix, diagonal: NDArray[Any]) -> scipy.sparse.csr_matrix:
        """The product, given its `shares` and the diagonal of D, without entries that are exactly zero."""
        data = times(shares, diagonal)
        return filled(self._whole, data) if all_of(data) else without_zeros(self._whole, data)


def product_pattern(first: scipy.sparse.csr_matrix, second: scipy.sparse.csr_matrix) -> ProductPattern | None:
    """The pattern of ``A D B``; None where storing it would not pay."""
    weight = _PRODUCT * int(np.diff(second.indptr)[first.indices].sum())
    if weight > MANY:
        return None
    tables = (first.indptr, first.indices, second.indptr, second.indices)
    return kept("product", tables, lambda: ProductPattern(first, second), weight)


def without_zeros(pattern: scipy.sparse.csr_matrix, data: NDArray[Any]) -> scipy.sparse.csr_matrix:
    """A matrix with the pattern of another one and new entries, without those that are exactly zero."""
    used = data != 0.0

    def fewer() -> tuple[Index, scipy.sparse.csr_matrix]:
        places = np.flatnonzero(used)
        row = rows_of(pattern)[places]
        return places, _sorted(np.ones(len(places)), row, pattern.indices[places].astype(np.int64), pattern.shape)

    places, found = kept_of("without zeros", pattern, (used,), fewer)
    return filled(found, data[places])


def filled(pattern: scipy.sparse.csr_matrix, data: NDArray[Any]) -> scipy.sparse.csr_matrix:
    """A matrix with the pattern of another one, whose index arrays it shares, and new entries."""
    out = scipy.sparse.csr_matrix.__new__(scipy.sparse.csr_matrix)
    vars(out).update(vars(pattern), data=data)
    return out


def times(matrix: scipy.sparse.csr_matrix, values: NDArray[Any]) -> NDArray[Any]:
    """``matrix @ values`` for values (n,) or (n, m) of the matrix's own dtype.

    SciPy's checks take longer than the product of small matrices, so its private kernels are called where they exist.
    """
    kernels = getattr(scipy.sparse, "_sparsetools", None)
    if kernels is None:
        return np.asarray(matrix @ values)
    (rows, columns), pattern = matrix.shape, (matrix.indptr, matrix.indices, matrix.data)
    if len(values) != columns:  # the kernels would read beyond the array
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
    """A matrix from entries that are sorted by row."""
    start = np.zeros(shape[0] + 1, dtype=np.int32)
    np.cumsum(np.bincount(row, minlength=shape[0]), out=start[1:])
    out = scipy.sparse.csr_matrix((data, column.astype(np.int32), start), shape=shape)
    # matrices that are `filled` from it share these results, see `kept_of`
    vars(out).update(known={})
    return out
