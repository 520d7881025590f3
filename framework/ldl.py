"""LDLᵀ of many small symmetric matrices at once: rows and columns lead, the batch follows."""

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
