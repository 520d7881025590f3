"""Symmetric eigenproblems of the whole batch, or of one large frame."""

from __future__ import annotations

import numpy as np

from . import dense
from .batch import Array

# Above this many unknowns a single frame goes the sparse way.
DENSE = 400


def inverse_pencil(stiffness: Array, other: Array, count: int) -> tuple[Array, Array]:
    """Eigenvalues mu of largest magnitude of ``other x = mu stiffness x``, (..., count), and vectors (..., n, count).

    With ``stiffness = D^-1 S D^-1`` scaled to unit diagonal and ``S = L L^T`` the problem is that of
    ``L^-1 D other D L^-T``, which is symmetric; eigenvalues of large magnitude come out to rounding.
    """
    matrix, root = dense.scaled(stiffness)
    half = np.linalg.cholesky(matrix)
    middle = other * root[..., :, None] * root[..., None, :]
    left = np.linalg.solve(half, middle)
    middle = np.linalg.solve(half, np.swapaxes(left, -1, -2))
    values, vectors = np.linalg.eigh((middle + np.swapaxes(middle, -1, -2)) / 2.0)
    chosen = np.argsort(-np.abs(values), axis=-1, kind="stable")[..., :count]
    values = np.take_along_axis(values, chosen, axis=-1)
    vectors = np.take_along_axis(vectors, chosen[..., None, :], axis=-1)
    return values, root[..., :, None] * np.linalg.solve(np.swapaxes(half, -1, -2), vectors)
