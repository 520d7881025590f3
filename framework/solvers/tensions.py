"""Simultaneous solution for displacements and spring tensions, for a stiffness that is singular in double precision.

The stiffness is ``S = A^T A``, with A the weighted deformations, so that its condition number is the square of that of
A. The augmented matrix ``[[-a, A], [A^T, b]]``, for ``s = A z`` and ``A^T s = f``, has about the condition number of A
(Björck, *Numerical Methods for Least Squares Problems*, 1996, sec. 2.5.3). Its factor in double precision, refined in
extended precision, therefore distinguishes a soft frame from a mechanism: if loads do work on a free motion, no
tensions s are in equilibrium with them.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import scipy

from ..batch import Array
from ..lazily import cached_property
from ..structure.parts import Extended
from ..structure.topology import Index
from .factor import MOTIONS, Factor
from .patterns import connected_by, filled, rows_of

# Singular values of A, its columns of length one, below this are those of a mechanism: rounding of coordinates in
# double precision may cause as much.
_LEAST = 1e-12
# The numbers a, and a times b, which is added to the eigenvalues of the stiffness: both are below what matters.
_SOFT, _SHIFT = 1e-11, 1e-25
# Largest number of steps of refinement, and the relative error to reach; number of steps in the test for singularity.
_STEPS, _FINE, _TELLING = 24, 1e-16, 8
# If more than this share of a random load, over the square root of the number of unknowns, stays out of equilibrium,
# the load does work on a free motion.
_UNBALANCED = 1e-3
# Number of random loads, of which both being almost orthogonal to a free motion is practically impossible; number of
# iterations to the softest motions.
_LOADS, _ROUNDS = 2, 4
# Up to this product of unknowns and squared band width, the factor, which needs pivoting, takes less than a second.
_MOST = 1e8
# Up to this band width LAPACK's banded factor is faster than SuperLU.
_NARROW = 100


def affordable(unknowns: int, width: int) -> bool:
    """Whether a factor by tensions is affordable for so many unknowns and such a band width."""
    return unknowns * float(width) ** 2 <= _MOST


class TensionFactor(Factor):
    """Factor of a stiffness by its deformations and spring stiffnesses.

    Parameters
    ----------
    matrix
        The stiffness (n, n).
    deformations
        Deformations of the springs per unknown, (springs, n), in extended precision.
    springs
        Stiffness of the springs, (springs,), not negative.
    order
        Order of the unknowns in which coupled ones are near each other, (n,); None to keep them in place.
    """

    precise = True

    def __init__(
        self,
        matrix: scipy.sparse.csr_matrix,
        deformations: scipy.sparse.csr_matrix,
        springs: Array,
        order: Index | None = None,
    ) -> None:
        super().__init__(matrix)
        if not deformations.has_canonical_format:
            # a joint's own unknown may move a member both through its node and by itself
            deformations = deformations.copy()
            deformations.sum_duplicates()
        each = np.repeat(np.sqrt(springs.astype(Extended)), np.diff(deformations.indptr))
        self._deformed = filled(deformations, deformations.data * each * self.root[deformations.indices])
        self._back = self._deformed.T
        self._factor = _factor(self._deformed, np.arange(len(self.root)) if order is None else order)

    def _step(self, compatibility: Array, load: Array) -> tuple[Array, Array]:
        """Corrections of tensions and displacements for the residuals of the two equations."""
        right = np.concatenate([_SOFT * compatibility, load]).astype(np.float64)
        found = self._factor.solve(right)
        return found[: len(compatibility)], found[len(compatibility) :] / _SOFT

    def _solved(self, load: Array, steps: int) -> tuple[Array, Array]:
        """Displacements and tensions, (n, k) and (springs, k), in extended precision."""
        tensions, found = self._step(np.zeros((self._deformed.shape[0], load.shape[1])), load)
        tensions, found = tensions.astype(Extended), found.astype(Extended)
        before = np.abs(found).max(axis=0, initial=0.0)
        for _ in range(steps):
            more, change = self._step(tensions - self._deformed @ found, load - self._back @ tensions)
            tensions, found = tensions + more, found + change
            moved = np.abs(change).max(axis=0, initial=0.0)
            # the error shrinks in each step by the ratio of this change to the one before
            if not (moved**2 > _FINE * np.abs(found).max(axis=0, initial=0.0) * before).any():
                break
            before = moved
        return found, tensions

    def solve_scaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), to the last bits where it is not singular."""
        return self._solved(load, _STEPS)[0].astype(np.float64)

    def roughly(self, load: Array) -> Array | None:
        """As `solve_scaled`, but to a few digits."""
        return self._step(np.zeros((self._deformed.shape[0], load.shape[1])), load)[1]

    @property
    def definite(self) -> bool:
        """Whether it is not singular, which suffices as no spring stiffness is negative."""
        return not self.singular

    @cached_property
    def singular(self) -> bool:
        """Whether some load cannot be balanced by tensions, to rounding; tested for each connected component."""
        label = connected_by(self.scaled)
        load = _of_length_one(np.random.default_rng(0).standard_normal((len(self.root), _LOADS)), label)
        share = (_UNBALANCED / np.sqrt(np.bincount(label)))[label, None]
        for _ in range(_LOADS):  # random loads, and then those in the shape of the motion that they lead to
            found, tensions = self._solved(load, _TELLING)
            left = load - self._back @ tensions
            if not (_lengths(left, label) <= share).all():
                return True
            softness = _lengths(found, label) / _lengths(load, label)
            load = _of_length_one(found.astype(np.float64), label)
        return bool((softness * _LEAST**2 >= 1.0).any())

    def motions(self, direct: Callable[[scipy.sparse.csr_matrix], Factor]) -> Array:
        """Null vectors of the matrix, (n, motions), by inverse iteration on several vectors at once."""
        size = len(self.root)
        vectors = np.random.default_rng(0).standard_normal((size, min(size, MOTIONS)))
        for _ in range(_ROUNDS):
            found = self.roughly(np.linalg.qr(vectors)[0])
            assert found is not None
            vectors = found
        basis = np.linalg.qr(vectors)[0]
        deformed = np.linalg.qr((self._deformed @ basis).astype(np.float64), mode="r")
        _, values, rows = np.linalg.svd(deformed)
        rank = int(np.count_nonzero(values > _LEAST))
        motions: Array = self.root[:, None] * (basis @ rows[rank:].T)
        return motions


def _factor(deformations: scipy.sparse.csr_matrix, order: Index) -> _InBand | scipy.sparse.linalg.SuperLU:
    """Factor of ``[[-a, A], [A^T, b]]``, A being the weighted deformations (springs, n), unknowns in `order`."""
    count, size = deformations.shape
    place = _amid(deformations, order)
    spring, unknown = rows_of(deformations), count + deformations.indices
    rough, width = deformations.data.astype(np.float64), int(np.abs(place[spring] - place[unknown]).max(initial=0))
    each = np.arange(count + size)
    data = np.concatenate([np.where(each < count, -_SOFT, _SHIFT / _SOFT), rough, rough])
    row, column = np.concatenate([each, spring, unknown]), np.concatenate([each, unknown, spring])
    if width <= _NARROW:
        return _InBand(data, row, column, place, width)
    whole = scipy.sparse.csc_matrix((data, (row, column)), shape=(len(each),) * 2)
    return scipy.sparse.linalg.splu(whole, permc_spec="COLAMD")


def _amid(deformations: scipy.sparse.csr_matrix, order: Index) -> Index:
    """Places of springs and unknowns in an order in which each spring is amid the unknowns that deform it."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    joined, starts = place[deformations.indices], deformations.indptr[:-1]
    middle = 0.5 * (np.minimum.reduceat(joined, starts) + np.maximum.reduceat(joined, starts))
    return np.argsort(np.argsort(np.concatenate([middle, place]), kind="stable"))


class _InBand:
    """LAPACK's LU factor, with pivoting, of a banded matrix.

    Parameters
    ----------
    data, row, column
        Entries of the matrix, without duplicates.
    place
        Place of each row and column in the band, (n,).
    width
        Number of diagonals on either side of the main one.
    """

    def __init__(self, data: Array, row: Index, column: Index, place: Index, width: int) -> None:
        self._place, self._order, self._width = place, np.argsort(place), width
        height = 3 * width + 1  # pivoting fills `width` more diagonals above
        numbers = np.zeros(len(place) * height)
        numbers[height * place[column] + 2 * width + place[row] - place[column]] = data
        band = numbers.reshape(len(place), height).T
        self._band, self._pivots, _ = scipy.linalg.lapack.dgbtrf(band, width, width, overwrite_ab=1)

    def solve(self, right: Array) -> Array:
        """Solutions (n, k) for right-hand sides (n, k)."""
        found, _ = scipy.linalg.lapack.dgbtrs(self._band, self._width, self._width, right[self._order], self._pivots)
        out: Array = found[self._place]
        return out


def _lengths(vectors: Array, label: Index) -> Array:
    """For each row, the length of the part of each vector (n, k) in that row's connected component, (n, k)."""
    squares = np.stack([np.bincount(label, np.asarray(column**2, np.float64)) for column in vectors.T], axis=1)
    lengths: Array = np.sqrt(squares)[label]
    return lengths


def _of_length_one(vectors: Array, label: Index) -> Array:
    """Vectors (n, k), normalised within each connected component."""
    lengths = _lengths(vectors, label)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
