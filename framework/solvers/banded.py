"""LAPACK's banded Cholesky factor, for frames that are long and thin: few operations more, each of them fast."""

from __future__ import annotations

import numpy as np
import scipy

from ..batch import Array
from ..structure.topology import Index
from .factor import Factor
from .lu import LUFactor


class BandedFactor(Factor):
    """L L^T within a band.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    order
        Which unknown is eliminated first, second, ..., (n,); neighbours near each other.
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix, order: Index) -> None:
        super().__init__(matrix)
        self.order = order
        place = np.empty_like(order)
        place[order] = np.arange(len(order))
        rows = place[np.repeat(np.arange(len(order)), np.diff(self.scaled.indptr))]
        columns = place[self.scaled.indices]
        lower = rows >= columns
        below = rows[lower] - columns[lower]
        # Column by column, as the band lies in memory.
        band = np.zeros((int(below.max(initial=0)) + 1, len(order)), order="F")
        band[below, columns[lower]] = self.scaled.data[lower]
        self.factor: Array
        self.factor, info = scipy.linalg.lapack.dpbtrf(band, lower=1, overwrite_ab=1)
        # a pivot that is not positive: whether rounding or a mechanism, LU tells
        self.instead: Factor | None = LUFactor(matrix) if info else None

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive."""
        return self.instead is None

    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        if self.instead is not None:
            return self.instead.unscaled(load)
        out = np.empty_like(load)
        out[self.order], _ = scipy.linalg.lapack.dpbtrs(self.factor, load[self.order], lower=1)
        return out
