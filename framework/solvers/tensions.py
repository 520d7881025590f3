"""Displacements solved for together with the tensions of springs, for what is singular to double precision alone.

The stiffness ``S = A^T A``, with A the weighted deformations, squares what these know: its condition number is that of
A squared. ``[[-a, A], [A^T, b]]`` has about that of A itself, for ``s = A z`` and ``A^T s = f`` (Björck, Numerical
Methods for Least Squares Problems, 1996, sec. 2.5.3), so that its factor in double precision, refined in extended
precision, tells a frame that is soft from a mechanism: no tensions are in equilibrium with loads that do work on a free
motion, whatever they are.
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

# Singular values of A, with columns of length one, that are those of a mechanism: coordinates in double precision may
# make as much of one.
_LEAST = 1e-12
# a above, and a b, which is added to the eigenvalues of the stiffness: both below what is to be told.
_SOFT, _SHIFT = 1e-11, 1e-25
# Steps of refinement at most, and the relative error that they leave; steps to tell what is singular.
_STEPS, _FINE, _TELLING = 24, 1e-16, 8
# Share of a random load out of equilibrium that is surely work on a free motion, by the root of the unknowns.
_UNBALANCED = 1e-3
# Random loads: that both are all but orthogonal to a free motion does not happen. Rounds to the softest motions.
_LOADS, _ROUNDS = 2, 4
# Unknowns times the square of their band up to which the factor, which needs pivots, takes less than a second or so.
_MOST = 1e8
# Width of a band up to which LAPACK takes less time than a factor in an order of its own.
_NARROW = 100


def affordable(unknowns: int, width: int) -> bool:
    """Whether a frame of so many unknowns within a band is narrow enough."""
    return unknowns * float(width) ** 2 <= _MOST


class TensionFactor(Factor):
    """Factor of a stiffness by the deformations that it is made of.

    Parameters
    ----------
    matrix
        The stiffness (n, n).
    deformations
        Deformations of the springs by its unknowns (springs, n), in extended precision.
    springs
        Their stiffness, (springs,), not negative.
    order
        The unknowns in an order in which those that are coupled are near each other, (n,); as they are where None.
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
        each = np.repeat(np.sqrt(springs.astype(Extended)), np.diff(deformations.indptr))
        self._deformed = filled(deformations, deformations.data * each * self.root[deformations.indices])
        self._back = self._deformed.T
        self._factor = _factor(self._deformed, np.arange(len(self.root)) if order is None else order)

    def _step(self, compatibility: Array, load: Array) -> tuple[Array, Array]:
        """Tensions and displacements for what these two equations lack."""
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
            # each step multiplies the error by what the last one was of that before
            if not (moved**2 > _FINE * np.abs(found).max(axis=0, initial=0.0) * before).any():
                break
            before = moved
        return found, tensions

    def unscaled(self, load: Array) -> Array | None:
        """Solution (n, k) of the scaled matrix for loads (n, k), to the last bits where it is not singular."""
        return self._solved(load, _STEPS)[0].astype(np.float64)

    def roughly(self, load: Array) -> Array | None:
        """As `unscaled`, to a few digits."""
        return self._step(np.zeros((self._deformed.shape[0], load.shape[1])), load)[1]

    @property
    def definite(self) -> bool:
        """Whether it is not singular: no spring is negative."""
        return not self.singular

    @cached_property
    def singular(self) -> bool:
        """Whether some load is in equilibrium with no tensions, or with such as only rounding tells from none.

        Asked of each connected component, so that none hides another.
        """
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
        """Vectors (n, motions) that the matrix sends to zero, by inverse iteration on some at once."""
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
    """Factor of ``[[-a, A], [A^T, b]]`` with A the deformations (springs, n), and unknowns in that order, (n,)."""
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
    """Where springs, and behind them unknowns, stand where each spring is amid the unknowns that it joins."""
    place = np.empty(len(order), dtype=np.int64)
    place[order] = np.arange(len(order))
    joined, starts = place[deformations.indices], deformations.indptr[:-1]
    middle = 0.5 * (np.minimum.reduceat(joined, starts) + np.maximum.reduceat(joined, starts))
    return np.argsort(np.argsort(np.concatenate([middle, place]), kind="stable"))


class _InBand:
    """LAPACK's factor, with pivots, of a matrix within a band.

    Parameters
    ----------
    data, row, column
        Its entries, of each place one.
    place
        Where each row and column goes in the band, (n,).
    width
        Diagonals of this on either side of the main one.
    """

    def __init__(self, data: Array, row: Index, column: Index, place: Index, width: int) -> None:
        self._place, self._order, self._width = place, np.argsort(place), width
        height = 3 * width + 1  # pivots fill as many more above
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
    """Length of the part of each of some vectors (n, k) that is in the component of each place, (n, k)."""
    squares = np.stack([np.bincount(label, np.asarray(column**2, np.float64)) for column in vectors.T], axis=1)
    lengths: Array = np.sqrt(squares)[label]
    return lengths


def _of_length_one(vectors: Array, label: Index) -> Array:
    """Vectors (n, k) of which the part in each component is of length one."""
    lengths = _lengths(vectors, label)
    return vectors / np.where(lengths > 0.0, lengths, 1.0)
