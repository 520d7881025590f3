"""Eigenvalues of one large frame: by block Krylov spaces, then as exact as the deformations of their shapes.

In double precision K forgets what is softer than rounding of its stiffest part: of n members in line their softest
bending loses n^4 roundings. So the space in which shapes are sought grows with a factor of K, but what it holds is told
by their deformations: Rayleigh-Ritz values err by the square of the error of the shapes (Parlett, *The Symmetric
Eigenvalue Problem*, 1998, ch. 11).
"""

from __future__ import annotations

import numpy as np
import scipy

from ..batch import Array
from ..error_bounds.equilibrium import Statics
from ..error_bounds.resistance import weighted
from ..errors import FrameError
from ..solvers.sparse import SparseSolver

# Shapes sought beyond those asked for; blocks of a Krylov space; restarts with the best shapes that it holds, and the
# share of the largest eigenvalue by which the wanted ones change no more.
_MORE = 4
_DEPTH = 8
_RESTARTS = 40
_SETTLED = 1e-11
# Products of columns of a basis up to which it counts as orthonormal.
_ORTHONORMAL = 1e-8


class SparsePencil:
    """``other x = mu (K + shift M) x`` for one large frame.

    Parameters
    ----------
    solver
        Its matrix.
    shift
        Of a frame that can move; 0.0 where it is regular.
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
            Symmetric (n, n).
        count
            How many.
        restarts
            Of the search, at most.
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
        """Orthonormal basis (n, m), scaled, of a block (n, k) and of what repeated inverse iteration makes of it."""
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
        """R of ``basis^T K basis = R^T R``, from the deformations, or from K where springs push at rest.

        Raises
        ------
        FrameError
            Where nothing resists some motion with mass, or something pushes it on.
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
        """Columns (n, count) as motions (count, ..., n)."""
        ndim = len(self.statics.plan.frame.shape)
        return np.ascontiguousarray(motions.T).reshape(motions.shape[1], *(1,) * ndim, len(motions))


def _orthonormal(basis: Array, more: Array) -> Array:
    """An orthonormal basis (n, m) with more columns (n, k) made orthonormal to it and each other, twice to be sure."""
    for _ in range(2):
        size = np.linalg.norm(more, axis=0)
        more = more / np.where(size > 0.0, size, 1.0)
        more = np.linalg.qr(more - basis @ (basis.T @ more))[0]
    both = np.hstack([basis, more])
    # what has no new direction, as where few nodes have mass, comes out of that along the basis
    return both if np.abs(basis.T @ more).max() <= _ORTHONORMAL else np.linalg.qr(both)[0]
