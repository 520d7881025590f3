"""Eigenvalues of one large frame by block Krylov spaces, with the precision of the deformations of their shapes.

In double precision K loses stiffnesses below the rounding of its stiffest part: the softest bending mode of n members
in a row loses n^4 roundings. So a factor of K is used only to build the space in which shapes are sought, and the
eigenvalues are computed from the deformations of the shapes: Rayleigh-Ritz values have an error of the square of that
of the shapes (Parlett, *The Symmetric Eigenvalue Problem*, 1998, ch. 11).
"""

from __future__ import annotations

import numpy as np
import scipy

from ..batch import Array
from ..error_bounds.equilibrium import Statics
from ..error_bounds.resistance import weighted
from ..errors import FrameError
from ..solvers.sparse import SparseSolver

# Number of shapes computed beyond those asked for; of blocks in a Krylov space; of restarts with the best shapes found;
# and the change of the wanted eigenvalues, relative to the largest one, at which they have converged.
_MORE = 4
_DEPTH = 8
_RESTARTS = 40
_SETTLED = 1e-11
# Largest inner product of two columns of a basis that counts as orthonormal.
_ORTHONORMAL = 1e-8


class SparsePencil:
    """The eigenvalue problem ``other x = mu (K + shift M) x`` of one large frame.

    Parameters
    ----------
    solver
        The solver of the frame.
    shift
        Shift by which the stiffness of a mechanism becomes regular; 0.0 for a regular frame.
    """

    def __init__(self, solver: SparseSolver, shift: float = 0.0) -> None:
        self.shift, self.unknowns = shift, solver.unknown.tolist()
        self.statics = Statics(solver.plan)
        self.mass = solver.mass if shift else None
        matrix = (
            solver.stiffness if self.mass is None else scipy.sparse.csr_matrix(solver.stiffness + shift * self.mass)
        )
        self.matrix, self.factor = matrix, solver.direct(matrix)

    def greatest(self, other: scipy.sparse.csr_matrix, count: int, restarts: int = _RESTARTS) -> tuple[Array, Array]:
        """The `count` greatest eigenvalues mu, (count,), the greatest first, and vectors (n, count).

        Parameters
        ----------
        other
            Symmetric matrix, (n, n).
        count
            Number of eigenvalues.
        restarts
            Largest number of restarts of the search.
        """
        root, size = self.factor.root[:, None], len(self.unknowns)
        width = min(count + _MORE, size)
        vectors = root * np.random.default_rng(0).standard_normal((size, width))
        values = np.full(count, np.inf)
        for _ in range(restarts if other.nnz else 0):
            before = values
            values, vectors = self._ritz(other, root * self._krylov(other, vectors / root), width)
            if np.max(np.abs(values[:count] - before[:count])) <= _SETTLED * np.max(np.abs(values)):
                break
        return values[:count], vectors[:, :count]

    def _krylov(self, other: scipy.sparse.csr_matrix, block: Array) -> Array:
        """Orthonormal basis (n, m), in scaled unknowns, of a block (n, k) and its images under inverse iteration."""
        root, size = self.factor.root[:, None], len(self.unknowns)
        basis = np.linalg.qr(block)[0]
        newest = basis
        while basis.shape[1] < min(_DEPTH * block.shape[1], size - block.shape[1] + 1):
            step = self.factor.solve(other @ (root * newest)) / root
            larger = _orthonormal(basis, step)
            newest, basis = larger[:, basis.shape[1] :], larger
        return basis

    def _ritz(self, other: scipy.sparse.csr_matrix, basis: Array, count: int) -> tuple[Array, Array]:
        """The greatest eigenvalues (count,) in the space of a basis (n, m), and vectors (n, count)."""
        flat = [
            each.reshape(basis.shape[1], -1).T for each in weighted(self.statics, self.unknowns, self._spread(basis))
        ]
        stretched = np.concatenate(flat).astype(np.float64)
        if self.mass is not None:
            inertia = np.linalg.cholesky(basis.T @ (self.mass @ basis)).T
            stretched = np.concatenate([stretched, np.sqrt(self.shift) * inertia])
        back = basis @ np.linalg.inv(self._upper(stretched, basis))
        values, turn = np.linalg.eigh(back.T @ (other @ back))
        return values[::-1][:count], back @ turn[:, ::-1][:, :count]

    def _upper(self, stretched: Array, basis: Array) -> Array:
        """R of ``basis^T K basis = R^T R``, from the deformations, or from K if springs have a negative stiffness.

        Raises
        ------
        FrameError
            If the matrix is not positive definite: a mechanism, or an unstable preload.
        """
        try:
            if np.isfinite(stretched).all():
                upper: Array = np.asarray(np.linalg.qr(stretched, mode="r"))
            else:
                upper = np.linalg.cholesky(basis.T @ (self.matrix @ basis)).T
            np.linalg.inv(upper)
        except np.linalg.LinAlgError:
            raise FrameError(
                "the frame is unstable by the preload of its springs, or a free motion of it moves no mass: "
                "support it, or give its nodes mass"
            ) from None
        return upper

    def _spread(self, motions: Array) -> Array:
        """Columns (n, count) reshaped to motions (count, ..., n)."""
        ndim = len(self.statics.plan.frame.shape)
        return np.ascontiguousarray(motions.T).reshape(motions.shape[1], *(1,) * ndim, len(motions))


def _orthonormal(basis: Array, more: Array) -> Array:
    """An orthonormal basis (n, m) extended by columns (n, k), which are orthogonalised twice for precision."""
    for _ in range(2):
        size = np.linalg.norm(more, axis=0)
        more = more / np.where(size > 0.0, size, 1.0)
        more = np.linalg.qr(more - basis @ (basis.T @ more))[0]
    both = np.hstack([basis, more])
    # columns without a new direction, as if few nodes have mass, come out along the basis
    return both if np.abs(basis.T @ more).max() <= _ORTHONORMAL else np.linalg.qr(both)[0]
