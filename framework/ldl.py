"""LDLᵀ of many small symmetric matrices at once: rows and columns lead, the batch follows.

The recurrence stands in four more texts, each a few lines about how numbers are kept there. `batched.stage` eliminates
terms that vary over different axes of the batch, and is what programs are recorded from; `large.elimination` the
entries of one sparse pattern; `batched.condensation` nodes of many chains at once, and `error_bounds.compliance` whole
inverses, both in extended precision. None serves for another without loss of time. As many times as long take: full
matrices of 3 to 12 unknowns by `large.elimination` 0.6 (12 unknowns, few matrices) to 2.1 (many), sparse ones by
`batched.stage` 1.9, chains by it 2.2 to 6.9, and inverses by this file 1.0 (300 matrices) to 1.8 (30), 3.7 to 7 (one).
A common text over an arithmetic of its own would be called once for each entry, in the innermost loop of all.
"""

from __future__ import annotations

import numpy as np

from .batch import Array


def factorised(matrix: Array, share: float, *, raised: bool = True) -> Array:
    """Overwrite symmetric matrices by their factors.

    Parameters
    ----------
    matrix
        The matrices, (n, n, ...).
    share
        Of its diagonal entry; a pivot that is not above that is rounding.
    raised
        Whether such a pivot is raised to that share, or left out with its row of Lᵀ.

    Returns
    -------
    ndarray
        DLᵀ above the diagonal, L below it, and on it the inverse of D, zero for what is left out.
    """
    n = len(matrix)
    least = [share * np.abs(matrix[k, k]) + np.finfo(float).tiny for k in range(n)]
    for k in range(n):
        pivot = matrix[k, k]
        inverse = 1.0 / np.maximum(pivot, least[k])
        matrix[k, k] = inverse if raised else np.where(pivot > least[k], inverse, 0.0)
        for i in range(k + 1, n):
            matrix[i, k] = matrix[k, i] * matrix[k, k]
            matrix[i, i:] -= matrix[i, k] * matrix[k, i:]
    return matrix


def substituted(factor: Array, load: Array) -> Array:
    """Solutions for loads (n, ..., N) by a factor (n, n, N)."""
    n, out = len(factor), load.copy()
    for k in range(n):
        for i in range(k + 1, n):
            out[i] -= factor[i, k] * out[k]
    for k in reversed(range(n)):
        for i in range(k + 1, n):
            out[k] -= factor[k, i] * out[i]
        out[k] *= factor[k, k]
    return out
