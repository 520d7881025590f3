"""Banded Cholesky factors of many matrices of one pattern, with tests for singular ones."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, all_of
from ..lazily import cached_property
from ..structure.topology import Index
from .band_factors import BandFactors, Room, Zeros, in_lanes, kind_of, side_by_side
from .coupling import Coupling
from .evaluation import Picked, Sums, numbers_of
from .factor import ITERATIONS, Factor, probe
from .lu import LUFactor
from .patterns import filled
from .rounding import SUSPECT, surely_positive, zero_eigenvalue
from .tensions import TensionFactor, affordable
from .terms import SumPattern, TermPattern

Mask = NDArray[np.bool_]
# After the first inverse iteration, a growth above this share of that for a zero eigenvalue needs another iteration.
_SURE = 1e-3
# Size of the arrays that are scaled at a time.
_AT_ONCE = 2**15
_EPS = float(np.finfo(np.float64).eps)
# A function of the places of the unknowns that returns the deformations per unknown, (springs, unknowns), and the
# numbers of the springs; None where they vary over the batch.
Deformed = Callable[[Index], "tuple[scipy.sparse.csr_matrix, Index] | None"]


class BandPattern:
    """Positions of matrix entries in a band, for some unknowns in some order, see `Bands`."""

    def __init__(self, terms: TermPattern, where: Mask, order: Index) -> None:
        self.place = np.full(terms.size, -1, dtype=np.int64)
        ordered = np.flatnonzero(where)[order]
        self.place[ordered[np.argsort(terms.label[ordered], kind="stable")]] = np.arange(len(order))
        own = np.flatnonzero(terms.stiff)
        own = own[where[terms.low[own]]]
        one, other = self.place[terms.low[own]], self.place[terms.high[own]]
        row, column = np.maximum(one, other), np.minimum(one, other)
        self.width = int((row - column).max(initial=0)) + 1
        self.position, target = np.unique(column * self.width + row - column, return_inverse=True)
        self.column, below = np.divmod(self.position, self.width)
        self.row = self.column + below
        self.diagonal = np.flatnonzero(below == 0)
        self.sums = SumPattern(terms, own, target, len(self.position))


class Bands:
    """Banded matrices of some unknowns, for any entries of a batch.

    Parameters
    ----------
    coupling
        The terms of the equations.
    where
        Mask of the unknowns, (n,).
    order
        Order of elimination, as indices among these, (size,). It is regrouped by connected components, so that the band
        is that of a single bending plane where planes are not coupled.
    deformed
        Function that returns the deformations by which matrices that are singular in double precision are examined;
        None to judge by the stiffness alone.

    Attributes
    ----------
    place
        Place of each unknown in the final order, (n,); -1 for unknowns not in `where`.
    width
        Number of diagonals on and below the main one.
    kind
        Class of the factors.
    side_by_side
        Whether machine code factorises several matrices at a time.
    """

    def __init__(self, coupling: Coupling, where: Mask, order: Index, deformed: Deformed | None = None) -> None:
        self._deformed = deformed
        self.where, self.size = where, len(order)
        key = "bands", where.tobytes(), order.tobytes()
        pattern = coupling.pattern.known(key, lambda: BandPattern(coupling.pattern, where, order))
        self.place, self.width = pattern.place, pattern.width
        self.position, self.column, self.row = pattern.position, pattern.column, pattern.row
        matrices = coupling.grid.sizes[coupling.mask]
        self.kind = kind_of(matrices, self.size, self.width)
        self.side_by_side = side_by_side(matrices, self.size, self.width)
        self._diagonal = pattern.diagonal
        self.sums = Sums(coupling, pattern.sums)

    @cached_property
    def deformations(self) -> tuple[scipy.sparse.csr_matrix, Index] | None:
        """Deformations per unknown, in their order, and the numbers of the springs; None if not available."""
        if self._deformed is None or not affordable(self.size, self.width):
            return None
        return self._deformed(self.place)

    def room(self, entries: int) -> Room:
        """Memory for the factors of so many entries, with scales and spring stiffnesses."""
        springs = sum(block.count for block in self.sums.coupling.blocks if block.rows is not None)
        return Room(in_lanes(entries) * ((self.size + self.width) * self.width + self.size + springs))

    def factorised(self, picked: Picked, room: Room | None = None) -> StackedFactor:
        """The factors at some entries, stored in `room` if there is one."""
        zeros = np.zeros if room is None else room.zeros
        values = self.sums.at(picked)
        if room is not None:
            picked.moved(zeros)
        diagonal = values[self._diagonal]
        if len(diagonal) < self.size:
            own, diagonal = diagonal, np.zeros((self.size, values.shape[1]))
            diagonal[self.column[self._diagonal]] = own
        root = np.divide(1.0, np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0)), out=zeros(diagonal.shape))
        step = max(1, _AT_ONCE // values.shape[1])  # few at a time, so that what they are multiplied by is in the cache
        for start in range(0, len(values), step):
            some = slice(start, start + step)
            values[some] *= root[self.row[some]]
            values[some] *= root[self.column[some]]
        return StackedFactor(self, picked, values, root, zeros)


class StackedFactor:
    """Banded factors ``L L^T`` of m matrices, scaled to unit diagonal.

    Parameters
    ----------
    bands
        The pattern of the matrices.
    picked
        The m entries of the batch.
    values
        Entries of the scaled matrices, (entries, m).
    root
        The scale, (size, m).
    zeros
        Function that allocates the array of the factors.

    Attributes
    ----------
    count
        Number of matrices, m.
    """

    def __init__(self, bands: Bands, picked: Picked, values: Array, root: Array, zeros: Zeros = np.zeros) -> None:
        self.bands, self.picked, self.root, self.count = bands, picked, root, root.shape[1]
        self._factors: BandFactors = bands.kind(values, bands.position, bands.size, bands.width, zeros)
        # a pivot is not positive: LU tells whether by rounding or because the frame is a mechanism
        self._pivot = self._factors.least
        failed = np.flatnonzero(~(self._pivot > 0.0)).tolist()
        self.instead: dict[int, Factor] = {entry: LUFactor(self._sparse(values[:, entry])) for entry in failed}

    def _sparse(self, values: Array) -> scipy.sparse.csr_matrix:
        row, column = self.bands.row, self.bands.column
        lower = scipy.sparse.coo_matrix((values, (row, column)), shape=(self.bands.size,) * 2).tocsr()
        return scipy.sparse.csr_matrix(lower + lower.T - scipy.sparse.diags(lower.diagonal()))

    def solve(self, entries: Index, loads: Array) -> None:
        """Solve in place with the scaled matrices of m `entries` for loads (size, m, k); NaN where a pivot is zero."""
        others = np.flatnonzero(np.isin(entries, list(self.instead))).tolist() if self.instead else []
        found = [(other, self.instead[int(entries[other])].solve(loads[:, other])) for other in others]
        self._factors.solve(entries, loads)
        for other, values in found:
            loads[:, other] = values

    @cached_property
    def growth(self) -> Array:
        """Estimated inverse of the least eigenvalue, (m,); by pivots alone where these exclude a zero eigenvalue."""
        size = self.bands.size
        least = self._pivot**2
        growth: Array = np.sqrt(size) / least
        sure = surely_positive(least, size)
        if self.instead:
            sure[list(self.instead)] = False
        if not all_of(sure):
            growth[~sure] = self.probed(np.flatnonzero(~sure))
        return growth

    @property
    def singular(self) -> Mask:
        """Whether the least eigenvalue is zero to rounding, (m,)."""
        return ~(1.0 / self.growth > zero_eigenvalue(self.bands.size))

    @property
    def rough(self) -> Array:
        """Estimated relative rounding error of a solution, (m,)."""
        return _EPS * self.growth

    def numbers(self, springs: Index, entries: Index) -> Array:
        """Stiffness of some springs at some entries, (springs, entries)."""
        found = stiffness_of(self.bands.sums.coupling, springs, self.picked)
        if found.shape[1] < self.count:
            return np.repeat(found, len(entries), axis=1)
        return found if len(entries) == self.count else found[:, entries]

    def probed(self, entries: Index) -> Array:
        """Inverse of the least eigenvalue at some entries, (entries,), by inverse iteration."""
        out = np.ones(len(entries))
        vector, zero = probe(self.bands.size), zero_eigenvalue(self.bands.size)
        for k, entry in enumerate(entries.tolist() if self.bands.size else ()):
            growth = np.inf if entry in self.instead else self._least(entry, vector)
            out[k] = growth if 1.0 / growth > zero else self._confirmed(entry, growth)
        return out

    def _confirmed(self, entry: int, growth: float) -> float:
        """Inverse of the least eigenvalue of a matrix that is singular in double precision; by tensions if possible."""
        if not self.precise[entry] and (better := self._by_tensions(entry)) is not None:
            self.instead[entry] = better
        if self.precise[entry]:
            return np.inf if self.instead[entry].singular else 1.0
        if entry not in self.instead:
            return growth
        # LU with pivots from the diagonal may hide that only rounding is left
        values = np.linalg.eigvalsh(self.instead[entry].scaled.toarray())
        return float(1.0 / max(np.abs(values).min(), np.finfo(float).tiny))

    @property
    def precise(self) -> Mask:
        """Whether solutions are exact to rounding without refinement, (m,)."""
        out = np.zeros(self.count, dtype=bool)
        for entry, factor in self.instead.items():
            out[entry] = factor.precise
        return out

    def _by_tensions(self, entry: int) -> Factor | None:
        """A factor by tensions, more precise than the scaled stiffness of an entry; None where it is not available."""
        if self.bands.deformations is None:
            return None
        deformations, acting = self.bands.deformations
        springs = self.numbers(acting, np.array([entry]))[:, 0]
        if (springs < 0.0).any():
            return None
        scaled = filled(deformations, deformations.data * self.root[deformations.indices, entry])
        rough = filled(deformations, scaled.data.astype(np.float64))
        return TensionFactor(scipy.sparse.csr_matrix(rough.T @ scipy.sparse.diags(springs) @ rough), scaled, springs)

    def _least(self, entry: int, vector: Array) -> float:
        """Estimated inverse of the least eigenvalue by inverse iteration.

        A random vector may have a part of only `SUSPECT` in the eigenvector; later iterates have more.
        """
        growth, zero = 1.0, zero_eigenvalue(len(vector))
        for enough in (SUSPECT, *(_SURE,) * (ITERATIONS - 1)):
            vector = vector / growth
            self.solve(np.array([entry]), vector[:, None, None])
            growth = float(np.linalg.norm(vector))
            if not growth >= enough / zero:
                break
        return growth


def stiffness_of(coupling: Coupling, springs: Index, picked: Picked) -> Array:
    """Stiffness of some springs at some entries of the batch, (springs, m), or (springs, 1) if it does not vary."""
    blocks = [block for block in coupling.blocks[:-1] if block.count]
    each = []
    for block in blocks:
        mine = springs[slice(*np.searchsorted(springs, [block.first, block.first + block.count]))] - block.first
        numbers = numbers_of(block, picked)
        each.append(numbers if len(mine) == len(numbers) else numbers[mine])
    if len(each) == 1:
        return each[0]
    most = max(numbers.shape[1] for numbers in each)
    return np.concatenate([np.broadcast_to(numbers, (len(numbers), most)) for numbers in each])
