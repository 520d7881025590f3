"""Assembly of element matrices into a sparse matrix of 6 x 6 blocks, by pairs of nodes.

The pattern comes from node numbers; values are added component by component over many elements at once.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..structure.topology import Index
from .patterns import kept, without_zeros

# Node numbers (n, k) of n elements between k nodes, and a function that returns the symmetric matrices
# (m, ..., 6 k, 6 k) of a slice of them.
Stack = tuple[Index, Callable[[slice], Array]]

# Number of elements, and of rows of blocks, that are handled at once, so that they stay in the processor's cache.
_CHUNK = 4096
# Up to this size arrays are added as a whole rather than component by component.
_TOGETHER = 2**14


def summed(stacks: Sequence[Stack], kept: NDArray[np.bool_]) -> scipy.sparse.csr_matrix:
    """Sum of element matrices over the DOFs of some nodes, without entries that are exactly zero.

    Parameters
    ----------
    stacks
        Node numbers and matrices of one batch entry each; ``stack.__getitem__`` gives those of an array.
    kept
        Mask of the nodes to keep, (nodes,); coupling with others is left out.

    Returns
    -------
    scipy.sparse.csr_matrix
        Sum, (6 nodes kept, 6 nodes kept), with sorted column indices.
    """
    number = np.where(kept, np.cumsum(kept) - 1, -1)
    couples = [number[nodes[:, [p, q]]] for nodes, _ in stacks for p, q in _sides(nodes) if p < q]
    blocks = _Blocks(int(kept.sum()), np.concatenate([np.zeros((0, 2), np.int64), *couples]))
    for nodes, matrices in stacks:
        for start in range(0, len(nodes), _CHUNK):
            part = slice(start, min(start + _CHUNK, len(nodes)))
            ends, stack = number[nodes[part]], np.moveaxis(matrices(part), (-2, -1), (0, 1))
            for p, q in _sides(nodes):
                values = stack[6 * p : 6 * p + 6, 6 * q : 6 * q + 6].reshape(6, 6, -1)
                blocks.add(ends[:, p], ends[:, q], values)
    return blocks.matrix()


def _sides(nodes: Index) -> list[tuple[int, int]]:
    """Pairs of an element's nodes, by their indices in it."""
    k = nodes.shape[1]
    return [(p, q) for p in range(k) for q in range(p, k)]


class _Blocks:
    """The 6 x 6 blocks of a symmetric matrix, (6, 6, blocks).

    The diagonal blocks of `count` nodes come first, then those of the node pairs in `ends` (n, 2), the lower node
    first; pairs with a negative number are ignored.
    """

    def __init__(self, count: int, ends: Index) -> None:
        low, high = ends.min(axis=1), ends.max(axis=1)
        self.count = count
        pairs: Index = np.sort((count * low + high)[low >= 0])
        self.pairs = pairs[np.diff(pairs, prepend=-1) > 0]
        self.total: NDArray[Any] = np.zeros((6, 6, count + len(self.pairs)))

    def add(self, first: Index, second: Index, values: Array) -> None:
        """Add blocks `values` (6, 6, n) between the nodes `first` and `second`, (n,) each."""
        wanted = (first >= 0) & (second >= 0)
        if not wanted.all():
            first, second, values = first[wanted], second[wanted], values[..., wanted]
        if not len(first):
            return
        low, high = np.minimum(first, second), np.maximum(first, second)
        if np.any(first > second):
            values = np.where(first > second, values.swapaxes(0, 1), values)
        place = np.where(low == high, low, self.count + np.searchsorted(self.pairs, self.count * low + high))
        start, stop = place.min(), place.max() + 1
        used, count = values.any(axis=-1), int(stop - start)
        if values.size <= _TOGETHER:
            some = values[used]
            each = (place - start) + count * np.arange(len(some))[:, None]
            summed = np.bincount(each.reshape(-1), some.reshape(-1), count * len(some))
            self.total[used, start:stop] += summed.reshape(len(some), count)
            return
        for r, c in np.argwhere(used):
            self.total[r, c, start:stop] += np.bincount(place - start, values[r, c], count)

    def matrix(self) -> scipy.sparse.csr_matrix:
        """The whole symmetric matrix, with both triangles."""
        if self.count <= _CHUNK:
            places, pattern = kept("blocks", (self.pairs, np.array(self.count)), self._places)
            return without_zeros(pattern, self.total.reshape(-1)[places])
        pattern = self._pattern()
        slices = [pattern.indptr[start : start + _CHUNK + 1] for start in range(0, self.count, _CHUNK)]
        parts = [self._rows(pattern, ends) for ends in slices]
        return scipy.sparse.csr_matrix(scipy.sparse.vstack(parts, format="csr"))

    def _places(self) -> tuple[Index, scipy.sparse.csr_matrix]:
        """Index into `total` of each entry, row by row, and a matrix of the pattern."""
        if not self.count:
            return np.zeros(0, dtype=np.int64), scipy.sparse.csr_matrix((0, 0))
        numbered = copy.copy(self)
        numbered.total = np.arange(1, self.total.size + 1, dtype=np.int64).reshape(self.total.shape)
        pattern = self._pattern()
        found = numbered._rows(pattern, pattern.indptr)
        return found.data - 1, found

    def _pattern(self) -> scipy.sparse.csr_matrix:
        """Matrix of the block numbers, from 1 on, row by row."""
        low, high = np.divmod(self.pairs, max(self.count, 1))
        own = np.arange(self.count)
        # In this order the columns of a row come sorted.
        rows, columns = np.concatenate([high, own, low]), np.concatenate([low, own, high])
        shape = self.count, self.count
        return scipy.sparse.csr_matrix((np.arange(1, len(rows) + 1), (rows, columns)), shape=shape)

    def _rows(self, pattern: scipy.sparse.csr_matrix, ends: NDArray[np.int32]) -> scipy.sparse.csr_matrix:
        """Some rows of blocks as a sparse matrix."""
        which = slice(ends[0], ends[-1])
        source = pattern.data[which] - 1 - len(self.pairs)
        below = source < 0
        data = np.moveaxis(self.total[..., np.where(below, source + len(self.pairs) + self.count, source)], -1, 0)
        data = np.where(below[:, None, None], np.swapaxes(data, 1, 2), data)
        shape = 6 * (len(ends) - 1), 6 * self.count
        out = scipy.sparse.csr_matrix(
            scipy.sparse.bsr_matrix((data, pattern.indices[which], ends - ends[0]), shape=shape).tocsr()
        )
        out.eliminate_zeros()
        return out
