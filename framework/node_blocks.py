"""Sums of element matrices by pairs of nodes: the pattern comes from node numbers, values are added six by six."""

from __future__ import annotations

import numpy as np
from scipy.sparse import bsr_matrix, csc_matrix, csr_matrix

from .batch import Array
from .topology import Index


def summed(stacks: list[tuple[Index, Array]], size: int) -> csr_matrix:
    """Sum over all DOFs of element matrices, without what is exactly zero.

    Parameters
    ----------
    stacks
        DOF numbers (n, 6 k) of k whole nodes an element, and matrices (n, ..., 6 k, 6 k) of one batch entry each.
    size
        Number of all DOFs.

    Returns
    -------
    csr_matrix
        (size, size), column numbers in order.
    """
    count = size // 6
    pairs, blocks = [np.zeros(0, dtype=np.int64)], [np.zeros((0, 36))]
    for dofs, stack in stacks:
        nodes = dofs[:, ::6] // 6
        k = nodes.shape[1]
        pairs.append((count * nodes[:, :, None] + nodes[:, None, :]).reshape(-1))
        blocks.append(stack.reshape(-1, k, 6, k, 6).swapaxes(2, 3).reshape(-1, 36))
    found, place = np.unique(np.concatenate(pairs), return_inverse=True)
    # A sparse matrix of ones adds the blocks in one pass over them.
    starts = np.arange(len(place) + 1)
    gather = csc_matrix((np.ones(len(place)), place, starts), shape=(len(found), len(place)))
    data = (gather @ np.concatenate(blocks)).reshape(-1, 6, 6)
    rows = np.searchsorted(found, count * np.arange(count + 1))
    out = csr_matrix(bsr_matrix((data, found % max(count, 1), rows), shape=(size, size)).tocsr())
    out.eliminate_zeros()
    return out
