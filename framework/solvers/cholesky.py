"""CHOLMOD's supernodal Cholesky factor, by cvxopt: the direct solver if the extra ``fast`` is installed."""

from __future__ import annotations

from typing import Any

import numpy as np
import scipy

from ..batch import Array
from ..structure.topology import Index
from .factor import Factor
from .lu import LUFactor


class CholeskyFactor(Factor):
    """L L^T in a given order.

    Parameters
    ----------
    matrix
        The matrix (n, n).
    order
        Order of elimination of the unknowns, (n,).
    """

    def __init__(self, matrix: scipy.sparse.csr_matrix, order: Index) -> None:
        from cvxopt import cholmod, spmatrix
        from cvxopt import matrix as dense

        super().__init__(matrix)
        lower = scipy.sparse.tril(self.scaled, format="csc")
        columns = np.repeat(np.arange(lower.shape[1]), np.diff(lower.indptr))
        places = dense(lower.indices.astype(np.int64)), dense(columns.astype(np.int64))
        entries = spmatrix(dense(lower.data), *places, lower.shape)
        before = dict(cholmod.options)
        try:
            cholmod.options["nmethods"] = 1  # the given order, and no other
            self.factor: Any = cholmod.symbolic(entries, p=dense(order.astype(np.int64)))
            cholmod.numeric(entries, self.factor)
        except ArithmeticError:  # a pivot that is not positive: whether rounding or a mechanism, LU tells
            self.factor = None
            self.instead = LUFactor(matrix)
        finally:
            cholmod.options.clear()
            cholmod.options.update(before)

    @property
    def definite(self) -> bool:
        """Whether all pivots are positive."""
        return self.factor is not None

    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), None where a pivot is zero."""
        from cvxopt import cholmod
        from cvxopt import matrix as dense

        if self.factor is None:
            return self.instead.solve_scaled(load)
        right = dense(np.asfortranarray(load))
        cholmod.solve(self.factor, right)
        return np.array(right)
