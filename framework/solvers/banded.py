"""LAPACK's banded Cholesky factor, for long and thin frames: a few more operations than a sparse one, but fast ones."""

from __future__ import annotations

import numpy as np
import scipy

from ..batch import Array, all_of
from ..structure.topology import Index
from .factor import Factor
from .lu import LUFactor
from .patterns import kept_of, rows_of
from .rounding import surely_positive


class BandedFactor(Factor):
    """L L^T within a band.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    order
        Order of elimination of the unknowns, (n,), with neighbours near each other.
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix, order: Index) -> None:
        super().__init__(matrix)
        self.order = order
        lower, where, width = kept_of("band", self.scaled, (order,), self._places)
        # Column by column, as the band lies in memory.
        numbers = np.zeros(width * len(order))
        numbers[where] = self.scaled.data[lower]
        band = numbers.reshape(len(order), width).T
        self.factor: Array
        self.factor, info = scipy.linalg.lapack.dpbtrf(band, lower=1, overwrite_ab=1)
        # a pivot is not positive: LU tells whether by rounding or because the frame is a mechanism
        self.instead: Factor | None = LUFactor(matrix) if info else None

    def _places(self) -> tuple[Index, Index, int]:
        """Indices of the entries on and below the diagonal, their positions in the band, and the width of the band."""
        place = np.empty_like(self.order)
        place[self.order] = np.arange(len(self.order))
        rows = place[rows_of(self.scaled)]
        columns = place[self.scaled.indices]
        lower = np.flatnonzero(rows >= columns)
        below, columns = rows[lower] - columns[lower], columns[lower]
        width = int(below.max(initial=0)) + 1
        return lower, columns * width + below, width

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive."""
        return self.instead is None

    @property
    def surely_definite(self) -> bool:
        """Whether pivots alone show that it is not singular; a solution may still have lost most of its digits."""
        if self.instead is not None:
            return False
        least = self.factor[0].min(keepdims=True, initial=1.0) ** 2
        return all_of(surely_positive(least, len(self.order)))

    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        if self.instead is not None:
            return self.instead.solve_scaled(load)
        out = np.empty_like(load)
        out[self.order], _ = scipy.linalg.lapack.dpbtrs(self.factor, load[self.order], lower=1)
        return out
