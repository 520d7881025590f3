"""SuperLU in symmetric mode, which scipy brings: the direct way of a plain install."""

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
    except RuntimeError:  # SuperLU's word for it
        return None


class LUFactor(Factor):
    """Pivots from the diagonal, ordered for least fill of a symmetric pattern.

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

    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        return None if self.factor is None else self.factor.solve(load)
