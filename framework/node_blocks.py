"""Sums of element matrices by pairs of nodes: the pattern comes from node numbers, values are added six by six."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix

from .batch import Array
from .topology import Index

# DOF numbers (n, 6 k) of k whole nodes an element, and what gives the matrices (..., 6 k, 6 k) of a slice of them.
Stack = tuple[Index, Callable[[slice], Array]]

# Elements at once: their matrices stay in the cache.
_CHUNK = 2048


def summed(stacks: Sequence[Stack], size: int) -> csr_matrix:
    """Sum over all DOFs of element matrices, without what is exactly zero.

    Parameters
    ----------
    stacks
        DOF numbers and matrices of one batch entry each; ``stack.__getitem__`` gives those of an array.
    size
        Number of all DOFs.

    Returns
    -------
    csr_matrix
        (size, size), column numbers in order.
    """
    count = max(size // 6, 1)
    nodes = [dofs[:, ::6] // 6 for dofs, _ in stacks]
    pairs = [(count * one[:, :, None] + one[:, None, :]).reshape(len(one), -1) for one in nodes]
    found, place = np.unique(np.concatenate([np.zeros(0, np.int64), *map(np.ravel, pairs)]), return_inverse=True)
    data = np.zeros((len(found), 36))
    first = 0
    for one, (_, matrices) in zip(nodes, stacks, strict=True):
        k = one.shape[1]
        for start in range(0, len(one), _CHUNK):
            part = slice(start, min(start + _CHUNK, len(one)))
            blocks = matrices(part).reshape(-1, k, 6, k, 6).swapaxes(2, 3).reshape(-1, 36)
            _add(data, place[first : first + len(blocks)], blocks)
            first += len(blocks)
    rows = np.searchsorted(found, count * np.arange(size // 6 + 1))
    out = csr_matrix(bsr_matrix((data.reshape(-1, 6, 6), found % count, rows), shape=(size, size)).tocsr())
    out.eliminate_zeros()
    return out


def _add(data: Array, place: Index, blocks: Array) -> None:
    """Add `blocks` to the rows `place` of `data`, where a row may come more than once: as a product with ones."""
    rows, which = np.unique(place, return_inverse=True)
    ones = csc_matrix((np.ones(len(which)), which, np.arange(len(which) + 1)), shape=(len(rows), len(which)))
    data[rows] += np.asarray(ones @ blocks)
