"""Banded Cholesky factors of many matrices of one pattern: LAPACK, entry by entry, on numbers assembled together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..structure.topology import Index
from .coupling import Coupling
from .evaluation import Picked, Sums
from .factor import ITERATIONS, SUSPECT
from .lu import LUFactor
from .rounding import zero_eigenvalue

Mask = NDArray[np.bool_]


class Bands:
    """The matrix of some unknowns in a band, for any entries of a batch.

    Parameters
    ----------
    coupling
        The equations.
    where
        Which of the unknowns, (n,).
    order
        Which of these is eliminated first, second, ..., (size,).

    Attributes
    ----------
    place
        Place of each unknown in the order, (n,); -1 where it is none of these.
    width
        Number of diagonals on and below the main one.
    """

    def __init__(self, coupling: Coupling, where: Mask, order: Index) -> None:
        terms = coupling.terms
        self.where, self.size = where, len(order)
        self.place = np.full(coupling.size, -1, dtype=np.int64)
        self.place[np.flatnonzero(where)[order]] = np.arange(self.size)
        stiff = terms.high < coupling.size
        stiff[stiff] = where[terms.low[stiff]]
        own = terms.at(stiff)
        one, other = self.place[own.low], self.place[own.high]
        row, column = np.maximum(one, other), np.minimum(one, other)
        self.width = int((row - column).max(initial=0)) + 1
        keys, target = np.unique(column * self.width + row - column, return_inverse=True)
        self.position: Index = keys
        self.column, below = np.divmod(keys, self.width)
        self.row = self.column + below
        self._diagonal = np.flatnonzero(below == 0)
        self.sums = Sums(coupling, own, target, len(keys))

    def factorised(self, picked: Picked) -> StackedFactor:
        """The factors at some entries."""
        values = self.sums.at(picked)
        diagonal = np.zeros((self.size, values.shape[1]))
        diagonal[self.column[self._diagonal]] = values[self._diagonal]
        root = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        values *= root[self.row]
        values *= root[self.column]
        return StackedFactor(self, values, np.ascontiguousarray(root.T))


@dataclass
class Singularity:
    """What a random load of length one tells of matrices.

    Attributes
    ----------
    growth
        Length of the displacement, one over the least eigenvalue where that is suspect, (m,).
    singular
        Whether that is zero to rounding, (m,).
    """

    growth: Array
    singular: Mask


class StackedFactor:
    """L L^T of m matrices within a band, scaled to unit diagonal.

    Parameters
    ----------
    bands
        Their pattern.
    values
        Their scaled entries (entries, m).
    root
        The scale (m, size).
    """

    def __init__(self, bands: Bands, values: Array, root: Array) -> None:
        self.bands, self.root, count = bands, root, len(root)
        self.band = np.zeros((count, bands.size * bands.width))
        self.band[:, bands.position] = values.T
        self.instead: dict[int, LUFactor] = {}
        self.indefinite: dict[int, scipy.sparse.csr_matrix] = {}
        for entry in range(count):
            _, info = scipy.linalg.lapack.dpbtrf(self._of(entry), lower=1, overwrite_ab=1)
            if info:  # a pivot that is not positive: whether rounding or a mechanism, LU tells
                self.indefinite[entry] = self._sparse(values[:, entry])
                self.instead[entry] = LUFactor(self.indefinite[entry])

    def _of(self, entry: int) -> Array:
        band: Array = self.band[entry].reshape(self.bands.size, self.bands.width).T
        return band

    def _sparse(self, values: Array) -> scipy.sparse.csr_matrix:
        row, column = self.bands.row, self.bands.column
        lower = scipy.sparse.coo_matrix((values, (row, column)), shape=(self.bands.size,) * 2).tocsr()
        return scipy.sparse.csr_matrix(lower + lower.T - scipy.sparse.diags(lower.diagonal()))

    def solve(self, loads: Array) -> None:
        """Solve in place with the scaled matrices for loads (m, k, size); NaN where a pivot is zero."""
        for entry, load in enumerate(loads):
            self.solve_one(entry, load)

    def solve_one(self, entry: int, load: Array) -> None:
        """For loads (k, size) at one entry, in place."""
        if entry not in self.instead:
            scipy.linalg.lapack.dpbtrs(self._of(entry), load.T, lower=1, overwrite_b=1)
            return
        factor = self.instead[entry]
        found = factor.unscaled(factor.root[:, None] * load.T)
        load[:] = np.nan if found is None else (factor.root[:, None] * found).T

    def singularity(self, found: Array) -> Singularity:
        """Whether the least eigenvalues are zero to rounding, as `Factor.singular` tells of one matrix.

        Parameters
        ----------
        found
            Solutions (m, size) of the scaled matrices for the load `probe(size)`.
        """
        count, size = found.shape
        if not size:
            return Singularity(np.ones(count), np.zeros(count, dtype=bool))
        zero = zero_eigenvalue(size)
        growth = np.linalg.norm(found, axis=1)
        singular = np.zeros(count, dtype=bool)
        for entry in np.flatnonzero(~(growth < SUSPECT / zero)).tolist():
            growth[entry] = self._least(entry, found[entry])
        for entry, matrix in self.indefinite.items():
            # LU without pivots of its own choice may hide that nothing but rounding is left
            growth[entry] = 1.0 / max(np.abs(np.linalg.eigvalsh(matrix.toarray())).min(), np.finfo(float).tiny)
        singular |= ~(1.0 / growth > zero)
        return Singularity(growth, singular)

    def _least(self, entry: int, vector: Array) -> float:
        """One over the least eigenvalue, by inverse iteration."""
        growth = float(np.linalg.norm(vector))
        for _ in range(ITERATIONS - 1):
            vector = vector / growth
            self.solve_one(entry, vector[None])
            growth = float(np.linalg.norm(vector))
            if not np.isfinite(growth):
                break
        return growth


def probe(size: int) -> Array:
    """A random vector of length one."""
    vector = np.random.default_rng(0).standard_normal(size)
    return vector / np.linalg.norm(vector) if size else vector
