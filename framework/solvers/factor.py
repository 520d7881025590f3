"""What every way of solving a large positive definite matrix shares: scaling, and the test for singularity."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
import scipy

from ..batch import Array
from ..lazily import cached_property
from .patterns import diagonal_of, filled, kept, rows_of
from .rounding import SUSPECT, zero_eigenvalue

# Inverse iterations that estimate the least eigenvalue; for a singular matrix the first tells.
ITERATIONS = 4
# The same where it is to be found whatever it is, from random vectors.
_TO_THE_LEAST = 8
# No more motions without resistance are sought, and eigenvalues near minus this.
MOTIONS = 6
_NEAR = 1e-9
# Unknowns up to which Lanczos' method has no room, and all eigenvalues are found at once.
_FEW = 4 * MOTIONS


class Factor(ABC):
    """A symmetric positive semidefinite matrix, scaled to unit diagonal, ready to be solved with.

    Attributes
    ----------
    scaled
        The scaled matrix (n, n).
    root
        The scale (n,): ``scaled = diag(root) matrix diag(root)``.
    precise
        Whether solutions are exact to rounding as they come, so that nothing refines them.
    """

    precise = False

    def __init__(self, matrix: scipy.sparse.csr_matrix) -> None:
        diagonal = diagonal_of(matrix)
        self.root: Array = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        data = self.root[rows_of(matrix)] * matrix.data * self.root[matrix.indices]
        self.scaled = filled(matrix, data)

    @abstractmethod
    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""

    def soft(self, *, nearly: bool = False) -> tuple[Array, int]:
        """Vectors (n, 2) that lead to the least eigenvalue of the scaled matrix, by so many inverse iterations.

        Where it is to be known `nearly`, to a part of itself, they may be others that are found more quickly.
        """
        return np.random.default_rng(0).standard_normal((len(self.root), 2)), _TO_THE_LEAST

    def roughly(self, load: Array) -> Array | None:
        """As `unscaled`, to a few digits where that is quicker: enough to find the least eigenvalue."""
        return self.unscaled(load)

    @property
    @abstractmethod
    def definite(self) -> bool:
        """Whether all pivots are positive."""

    @property
    def surely_definite(self) -> bool:
        """Whether pivots alone tell that it is not singular; what is left of a solution may be little all the same."""
        return False

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, k), NaN where a pivot is zero."""
        found = self.unscaled(self.root[:, None] * load)
        return np.full_like(load, np.nan) if found is None else self.root[:, None] * found

    def solve_to(self, load: Array, share: Array) -> Array:
        """As `solve`; where that saves time only until a `share` (k,) of each load, scaled, is left unbalanced."""
        return self.solve(load)

    @cached_property
    def singular(self) -> bool:
        """Whether the least eigenvalue of the scaled matrix is zero to rounding, by inverse iteration."""
        zero = zero_eigenvalue(len(self.root))
        vector = probe(len(self.root))[:, None]
        growth = 1.0
        for _ in range(ITERATIONS):
            found = self.unscaled(vector / growth)
            if found is None or not np.isfinite(found).all():
                return True
            vector, growth = found, float(np.linalg.norm(found))
            if growth < SUSPECT / zero:
                return False
        return bool(1.0 / growth <= zero)

    def motions(self, direct: Callable[[scipy.sparse.csr_matrix], Factor]) -> Array:
        """Vectors (n, motions) that the matrix sends to zero: Lanczos' method on the inverse of a shifted matrix.

        Parameters
        ----------
        direct
            Makes a factor of the shifted matrix.
        """
        from scipy.sparse.linalg import LinearOperator, eigsh

        size = len(self.root)
        if size <= _FEW:
            values, vectors = np.linalg.eigh(self.scaled.toarray())
        else:
            shifted = direct(scipy.sparse.csr_matrix(self.scaled + _NEAR * scipy.sparse.eye(size)))
            inverse = LinearOperator((size, size), matvec=lambda x: shifted.solve(x.reshape(-1, 1))[:, 0], dtype=float)
            start = np.random.default_rng(0).standard_normal(size)
            values, vectors = eigsh(self.scaled, k=MOTIONS, sigma=-_NEAR, OPinv=inverse, v0=start)
        found: Array = self.root[:, None] * vectors[:, values <= zero_eigenvalue(size)]
        return found


def probe(size: int) -> Array:
    """A random vector of length one, (size,); nobody may change it."""

    def vector() -> Array:
        found = np.random.default_rng(0).standard_normal(size)
        return found / np.linalg.norm(found) if size else found

    return kept("probe", (np.array(size),), vector, weight=size)


class NoFactor(Factor):
    """Of a matrix without unknowns, in which nothing can move."""

    def unscaled(self, load: Array) -> Array | None:
        """The load (0, k) itself."""
        return load

    @property
    def definite(self) -> bool:
        """Always."""
        return True

    @property
    def singular(self) -> bool:
        """Never."""
        return False
