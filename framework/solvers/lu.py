"""SuperLU in symmetric mode, which scipy brings: the direct way of a plain install."""

from __future__ import annotations

from typing import Any

import scipy

from ..batch import Array
from .factor import Factor


class LUFactor(Factor):
    """Pivots from the diagonal, ordered for least fill of a symmetric pattern.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix) -> None:
        super().__init__(matrix)
        options = {"SymmetricMode": True}
        csc = self.scaled.tocsc()
        try:
            self.factor: Any = scipy.sparse.linalg.splu(
                csc, permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options
            )
        except RuntimeError:  # SuperLU's word for an exactly zero pivot
            self.factor = None

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive."""
        return self.factor is not None and bool((self.factor.U.diagonal() > 0.0).all())

    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        return None if self.factor is None else self.factor.solve(load)
