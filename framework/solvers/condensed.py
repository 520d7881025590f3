"""The equations of some nodes of a frame, the others condensed out.

No two of the nodes that are condensed out are coupled, so that each is on its own. In a lattice without diagonals it is
every second one; conjugate gradients on the rest then take half as many steps (Reid, SIAM J. Numer. Anal. 9, 1972,
325-332), each of which costs no more than one on the whole.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..structure.topology import Index

# If more than this share of the entries in blocks is not zero, a product by blocks is faster.
_FILLED = 0.65


@dataclass(frozen=True)
class Places:
    """The nodes of n unknowns.

    Attributes
    ----------
    node, component
        Number of the node and index of the displacement component, (n,); unknowns are sorted by both.
    points
        Positions of the nodes, (n, 3).
    free
        Whether the unknown is a displacement of the node in global axes, rather than one of a joint, (n,).
    """

    node: Index
    component: Index
    points: Array
    free: NDArray[np.bool_]

    def of(self, where: NDArray[np.bool_]) -> Places:
        """The unknowns in a mask (n,)."""
        return Places(self.node[where], self.component[where], self.points[where], self.free[where])


class Condensed:
    """A symmetric positive definite matrix (n, n) whose nodes are condensed out as far as no two are coupled.

    With the Cholesky factors L of the nodes' own blocks, the unknowns ``L^T x`` have the matrix ``[[I, C], [C^T, E]]``,
    that of the nodes kept is ``E - C^T C``, by which ``self @ x`` multiplies. Nodes with fewer than six unknowns get
    others that are coupled with nothing.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    places
        The nodes of its unknowns.

    Attributes
    ----------
    order
        Indices of the nodes: first those that are condensed out, then those that are kept.
    out
        Number of nodes that are condensed out.

    Raises
    ------
    numpy.linalg.LinAlgError
        If the block of a node is not positive definite.
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix, places: Places) -> None:
        node = np.unique(places.node, return_inverse=True)[1].astype(np.int64)
        count, place = int(node.max()) + 1, 6 * node + places.component
        blocks = _by_nodes(matrix, place, count)
        inverse: Array = np.linalg.inv(np.linalg.cholesky(_own_blocks(blocks, place)))
        beside = _pattern(blocks)
        chosen = independent(beside)
        self.order: Index = np.argsort(~chosen, kind="stable")
        self.out = int(chosen.sum())
        number = np.argsort(self.order)
        self._place = 6 * number[node] + places.component
        self._inverse: Array = inverse[self.order]
        first, last = self.order[: self.out], self.order[self.out :]
        coupling = _cut(blocks, beside, inverse, first, last)
        self.coupling, self._back = compact(coupling), compact(coupling.T)
        others = _cut(blocks, beside, inverse, last, last)
        self.others = compact(others) if others.nnz else None

    def __matmul__(self, kept: Any) -> Any:
        found = kept - self._back @ (self.coupling @ kept)
        return found if self.others is None else found + self.others @ kept

    def condensed(self, load: Array) -> tuple[Array, Array]:
        """The part of a load (n,) or (n, k) on the nodes that are condensed out, and the load on the others."""
        whole = np.zeros((len(self._inverse) * 6, *load.shape[1:]))
        whole[self._place] = load
        whole = _multiplied(self._inverse, whole)
        own, rest = whole[: 6 * self.out], whole[6 * self.out :]
        return own, rest - self._back @ own

    def expanded(self, own: Array, kept: Array) -> Array:
        """All unknowns, (n,) or (n, k), from those kept and the part `own` of the load, see `condensed`."""
        whole = np.concatenate([own - self.coupling @ kept, kept])
        found: Array = _multiplied(self._inverse.swapaxes(1, 2), whole)[self._place]
        return found

    def motions(self, blocks: Array) -> Array:
        """Motions of all nodes, (nodes, 6, m), as motions of the nodes kept in their unknowns here, (kept, 6, m)."""
        factors = self._inverse[self.out :].swapaxes(1, 2)
        return np.asarray(np.linalg.solve(factors, blocks[self.order[self.out :]]), np.float64)


def compact(blocks: scipy.sparse.bsr_matrix) -> Any:
    """A matrix of blocks of six by six as it is, if few of their entries are zero: its products take half the time.

    Where members lie along the axes, most of a block is zero; the matrix is then stored by entries.
    """
    if np.count_nonzero(blocks.data) > _FILLED * blocks.data.size:
        return blocks
    found = scipy.sparse.csr_matrix(blocks.tocsr())
    found.eliminate_zeros()
    return found


def independent(beside: scipy.sparse.csr_matrix) -> NDArray[np.bool_]:
    """Mask of as many vertices as easily found of which no two are joined: every second one of a bipartite graph.

    Parameters
    ----------
    beside
        A symmetric matrix with an entry for each two vertices that are joined.
    """
    from scipy.sparse import csgraph

    size = beside.shape[0]
    label = csgraph.connected_components(beside, directed=False)[1]
    starts = np.unique(label, return_index=True)[1]
    depth = csgraph.dijkstra(beside, unweighted=True, indices=starts, min_only=True)
    # vertices at an even number of steps from the first come first, and among them chance decides: rounds are few
    rank = np.random.default_rng(0).permutation(size) + size * (depth.astype(np.int64) % 2)
    chosen, first, second = np.zeros(size, dtype=bool), _rows(beside), beside.indices
    undecided = np.ones(size, dtype=bool)
    while undecided.any():
        both = undecided[first] & undecided[second]
        first, second = first[both], second[both]
        least = np.full(size, 2 * size)
        np.minimum.at(least, first, rank[second])
        new = undecided & (rank < least)
        chosen |= new
        undecided &= ~new
        undecided[second[new[first]]] = False
    return chosen


def _by_nodes(matrix: scipy.sparse.csr_matrix, place: Index, count: int) -> scipy.sparse.bsr_matrix:
    """A matrix (n, n) in blocks of `count` nodes, unknowns being at the rows `place` (n,); others are zero."""
    if len(place) < 6 * count:
        sizes = np.zeros(6 * count + 1, dtype=matrix.indptr.dtype)
        sizes[place + 1] = np.diff(matrix.indptr)
        parts = matrix.data, place[matrix.indices], np.cumsum(sizes)
        matrix = scipy.sparse.csr_matrix(parts, shape=(6 * count, 6 * count))
    return matrix.tobsr((6, 6))


def _own_blocks(blocks: scipy.sparse.bsr_matrix, place: Index) -> Array:
    """The diagonal blocks (nodes, 6, 6), with ones for the unknowns that a node does not have."""
    own = _rows(blocks) == blocks.indices
    found = np.zeros((len(blocks.indptr) - 1, 6, 6))
    found[blocks.indices[own]] = blocks.data[own]
    absent = np.ones(6 * len(found))
    absent[place] = 0.0
    found[:, range(6), range(6)] += absent.reshape(-1, 6)
    return found


def _pattern(blocks: scipy.sparse.bsr_matrix) -> scipy.sparse.csr_matrix:
    """The numbers of the blocks beside the diagonal, from 1 on, as entries of a matrix."""
    rows, columns = _rows(blocks), blocks.indices
    beside = rows != columns
    shape = len(blocks.indptr) - 1, len(blocks.indptr) - 1
    entries = np.flatnonzero(beside) + 1, (rows[beside], columns[beside])
    return scipy.sparse.coo_matrix(entries, shape=shape).tocsr()


def _cut(
    blocks: scipy.sparse.bsr_matrix, numbers: scipy.sparse.csr_matrix, inverse: Array, rows: Index, columns: Index
) -> scipy.sparse.bsr_matrix:
    """``L^-1 A L^-T`` of the nodes `rows` and `columns`, `inverse` (nodes, 6, 6) being ``L^-1``."""
    found = numbers[rows][:, columns]
    shape = 6 * len(rows), 6 * len(columns)
    parts = blocks.data[found.data - 1], found.indices, found.indptr
    left = _diagonal(inverse[rows]) @ scipy.sparse.bsr_matrix(parts, shape=shape)
    del parts
    return scipy.sparse.bsr_matrix(left @ _diagonal(inverse[columns].swapaxes(1, 2)))


def _diagonal(blocks: Array) -> scipy.sparse.bsr_matrix:
    """A matrix with such blocks (nodes, 6, 6) on its diagonal."""
    count = len(blocks)
    parts = blocks, np.arange(count), np.arange(count + 1)
    return scipy.sparse.bsr_matrix(parts, shape=(6 * count, 6 * count))


def _rows(matrix: Any) -> Index:
    """Row of each entry, or block, of a matrix."""
    return np.repeat(np.arange(len(matrix.indptr) - 1), np.diff(matrix.indptr))


def _multiplied(blocks: Array, vectors: Array) -> Array:
    """Products of a block (6, 6) of each node with its part of vectors (6 nodes,) or (6 nodes, k)."""
    found: Array = (blocks @ vectors.reshape(len(blocks), 6, -1)).reshape(vectors.shape)
    return found
