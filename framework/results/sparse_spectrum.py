"""Eigenvalues of one large frame: by Lanczos' method, then as exact as the deformations of their shapes.

In double precision K forgets what is softer than rounding of its stiffest part: of n members in line their softest
bending loses n^4 roundings. So shapes from the factor are improved by one inverse iteration whose solution is refined
with residuals in extended precision, and their eigenvalues are Rayleigh-Ritz values with energies from deformations,
which err by the square of the error of the shapes (Parlett, *The Symmetric Eigenvalue Problem*, 1998, ch. 11).
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_matrix, diags
from scipy.sparse.linalg import LinearOperator, eigsh

from ..batch import Array
from ..error_bounds.equilibrium import Statics
from ..error_bounds.kinematics import extended
from .resistance import energies, resisted

if TYPE_CHECKING:
    from ..solvers.sparse import SparseSolver

# Eigenvalues sought beyond those asked for: the last ones of a group of equal ones come late.
_MORE = 4
_STEPS = 2
# Relative error of the eigenvalues from which the shapes are improved.
_LOOSE = 1e-11


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
        matrix = solver.stiffness if self.mass is None else csr_matrix(solver.stiffness + shift * self.mass)
        self.factor = solver.direct(matrix)

    def greatest(self, other: csr_matrix, count: int) -> tuple[Array, Array]:
        """The `count` greatest eigenvalues mu, (count,), the greatest first, and vectors (n, count).

        Parameters
        ----------
        other
            Symmetric (n, n).
        count
            How many.
        """
        scaled = csr_matrix(diags(self.factor.root) @ other @ diags(self.factor.root))
        vectors = self.factor.root[:, None] * self._lanczos(scaled, min(count + _MORE, len(self.unknowns) - 1))
        values, better = self._improved(other, vectors)
        return values[:count], better[:, :count]

    def _lanczos(self, other: csr_matrix, count: int) -> Array:
        """Vectors of the greatest eigenvalues of the scaled pencil, (n, count)."""
        size = len(self.unknowns)
        inverse = LinearOperator((size, size), matvec=lambda x: self._solved(x), dtype=float)
        start = np.random.default_rng(0).standard_normal(size)
        matrix = self.factor.scaled
        rough = eigsh(other, k=1, M=matrix, Minv=inverse, which="LM", v0=start, tol=1e-3, return_eigenvectors=False)
        # All eigenvalues made positive: where none of them is, the greatest crowd at zero.
        positive = other + 1.01 * float(np.abs(rough[0])) * matrix
        values, vectors = eigsh(positive, k=count, M=matrix, Minv=inverse, which="LA", v0=start, tol=_LOOSE)
        out: Array = vectors[:, np.argsort(-values)]
        return out

    def _solved(self, load: Array) -> Array:
        found = self.factor.unscaled(load.reshape(-1, 1))
        return np.full_like(load, np.nan) if found is None else found[:, 0]

    def _improved(self, other: csr_matrix, vectors: Array) -> tuple[Array, Array]:
        """Ritz values and vectors (n, count) of `vectors` after one refined inverse iteration."""
        load = other @ vectors
        better = extended(self.factor.solve(load))
        for _ in range(_STEPS):
            left = load - self._resisted(better)
            better = better + self.factor.solve(left.astype(np.float64))
        better = better / np.sqrt(np.abs(np.diagonal(self._energies(better))))
        stiff, rough = self._energies(better), better.astype(np.float64)
        values, turn = eigh(rough.T @ (other @ rough), stiff)
        order = np.argsort(-values)
        return values[order], rough @ turn[:, order]

    def _resisted(self, motions: Array) -> Array:
        found = resisted(self.statics, self.unknowns, self._spread(motions)).reshape(motions.shape[::-1]).T
        return found if self.mass is None else found + self.shift * (self.mass @ motions.astype(np.float64))

    def _energies(self, motions: Array) -> Array:
        found = energies(self.statics, self.unknowns, self._spread(motions)).astype(np.float64)
        rough = motions.astype(np.float64)
        return found if self.mass is None else found + self.shift * (rough.T @ (self.mass @ rough))

    def _spread(self, motions: Array) -> Array:
        """Columns (n, count) as motions (count, ..., n)."""
        ndim = len(self.statics.plan.frame.shape)
        return np.ascontiguousarray(motions.T).reshape(motions.shape[1], *(1,) * ndim, len(motions))
