"""SciPy's SuperLU in symmetric mode: the direct solver of an installation without extras."""

from __future__ import annotations

from typing import Any

import scipy

from ..batch import Array
from .factor import Factor


def symmetric_lu(matrix: scipy.sparse.csc_matrix) -> Any:
    """SuperLU's factor of a symmetric matrix, with its pivots from the diagonal; None where one is exactly zero."""
    try:
        return scipy.sparse.linalg.splu(
            matrix, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options={"SymmetricMode": True}
        )
    except RuntimeError:  # SuperLU raises it for a zero pivot
        return None


class LUFactor(Factor):
    """LU factor with pivots from the diagonal, in an order for little fill of a symmetric pattern.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix) -> None:
        super().__init__(matrix)
        self.factor = symmetric_lu(self.scaled.tocsc())

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive."""
        return self.factor is not None and bool((self.factor.U.diagonal() > 0.0).all())

    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        return None if self.factor is None else self.factor.solve(load)
