"""Symmetric eigenproblems of the whole batch, or of one large frame."""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_matrix

from ..batch import Array
from . import dense

# Above this many unknowns a single frame goes the sparse way.
DENSE = 400

# Roundings, for the square root of its size, below which an eigenvalue of a matrix with unit diagonal is zero.
_ROUNDINGS = 8.0


def zero_eigenvalue(size: int) -> float:
    """What counts as zero among the eigenvalues of a matrix with unit diagonal."""
    return _ROUNDINGS * float(np.sqrt(size) * np.finfo(float).eps)


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


def sparse_pencil(stiffness: csr_matrix, mass: csr_matrix, count: int, shift: float) -> tuple[Array, Array]:
    """The `count` least eigenvalues of ``K x = lambda M x``, by shift and inversion about -`shift`, and vectors."""
    from skfem.utils import solver_eigen_scipy_sym

    start = np.ones(stiffness.shape[0])
    values, vectors = solver_eigen_scipy_sym(k=count, sigma=-shift, v0=start)(stiffness.tocsc(), mass.tocsc())
    order = np.argsort(values)
    return values[order], vectors[:, order]


def extremes(matrix: csr_matrix) -> tuple[Array, Array]:
    """Least and greatest eigenvalue of a symmetric positive semidefinite matrix, by Lanczos."""
    from scipy.sparse.linalg import eigsh

    start = np.ones(matrix.shape[0])
    greatest = eigsh(matrix, k=1, v0=start, return_eigenvectors=False)
    least = eigsh(matrix.tocsc(), k=1, sigma=0.0, v0=start, return_eigenvectors=False)
    return np.asarray(least[0]), np.asarray(greatest[0])
