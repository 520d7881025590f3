"""The base class of factors of a large positive definite matrix: scaling, solving, and the test for singularity."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable

import numpy as np
import scipy

from ..batch import Array
from ..lazily import cached_property
from .patterns import diagonal_of, filled, kept, rows_of
from .rounding import SUSPECT, zero_eigenvalue

# Number of inverse iterations that estimate the least eigenvalue; the first already exposes a singular matrix.
ITERATIONS = 4
# Number of inverse iterations that find the least eigenvalue from random vectors, whatever its size.
_TO_THE_LEAST = 8
# Number of free motions that are looked for, and the negative of the shift near which their eigenvalues are sought.
MOTIONS = 6
_NEAR = 1e-9
# Up to this many unknowns, too few for Lanczos' method, all eigenvalues are computed.
_FEW = 4 * MOTIONS


class Factor(ABC):
    """A symmetric positive semidefinite matrix, scaled to unit diagonal, with a method to solve equations.

    Attributes
    ----------
    scaled
        The scaled matrix (n, n).
    root
        The scale (n,): ``scaled = diag(root) matrix diag(root)``.
    precise
        Whether solutions are exact to rounding and need no refinement.
    """

    precise = False

    def __init__(self, matrix: scipy.sparse.csr_matrix) -> None:
        diagonal = diagonal_of(matrix)
        self.root: Array = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        data = self.root[rows_of(matrix)] * matrix.data * self.root[matrix.indices]
        self.scaled = filled(matrix, data)

    @abstractmethod
    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""

    def soft(self, *, nearly: bool = False) -> tuple[Array, int]:
        """Start vectors (n, 2) for inverse iteration to the scaled matrix's least eigenvalue, and iterations needed.

        If it is to be known only `nearly`, to some percent, they may be others that are found more quickly.
        """
        return np.random.default_rng(0).standard_normal((len(self.root), 2)), _TO_THE_LEAST

    def roughly(self, load: Array) -> Array | None:
        """As `solve_scaled`, but to a few digits if that is faster: enough to find the least eigenvalue."""
        return self.solve_scaled(load)

    @property
    @abstractmethod
    def definite(self) -> bool:
        """Whether all pivots are positive."""

    @property
    def surely_definite(self) -> bool:
        """Whether pivots alone show that it is not singular; a solution may still have lost most of its digits."""
        return False

    def solve(self, load: Array) -> Array:
        """Solution for loads (n, k), NaN where a pivot is zero."""
        found = self.solve_scaled(self.root[:, None] * load)
        return np.full_like(load, np.nan) if found is None else self.root[:, None] * found

    def solve_to(self, load: Array, share: Array) -> Array:
        """As `solve`, but if that saves time only until a `share` (k,) of each scaled load is left unbalanced."""
        return self.solve(load)

    @cached_property
    def singular(self) -> bool:
        """Whether the least eigenvalue of the scaled matrix is zero to rounding, by inverse iteration."""
        zero = zero_eigenvalue(len(self.root))
        vector = probe(len(self.root))[:, None]
        growth = 1.0
        for _ in range(ITERATIONS):
            found = self.solve_scaled(vector / growth)
            if found is None or not np.isfinite(found).all():
                return True
            vector, growth = found, float(np.linalg.norm(found))
            if growth < SUSPECT / zero:
                return False
        return bool(1.0 / growth <= zero)

    def motions(self, direct: Callable[[scipy.sparse.csr_matrix], Factor]) -> Array:
        """Null vectors of the matrix, (n, motions), by Lanczos' method on the inverse of a shifted matrix.

        Parameters
        ----------
        direct
            Function that factorises the shifted matrix.
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
    """A random vector of length one, (size,); it is shared and must not be changed."""

    def vector() -> Array:
        found = np.random.default_rng(0).standard_normal(size)
        return found / np.linalg.norm(found) if size else found

    return kept("probe", (np.array(size),), vector, weight=size)


class NoFactor(Factor):
    """Factor of a matrix without unknowns."""

    def solve_scaled(self, load: Array) -> Array | None:
        """The load (0, k) itself."""
        return load

    @property
    def definite(self) -> bool:
        """True."""
        return True

    @property
    def singular(self) -> bool:
        """False."""
        return False
