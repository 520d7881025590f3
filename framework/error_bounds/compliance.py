"""Approximate inverses of the stiffness with a proved bound on its least eigenvalue, and those of small matrices."""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, merged
from .deformations import Springs
from .kinematic_edge import Real, extended, norm
from .kinematics import FrameKinematics

ROUNDING = float(np.finfo(np.float64).eps) / 2.0
# Roundings in a deformation, relative to its size.
_DEFORMATION = 32.0
# Least eigenvalue below which products of two errors matter.
NEAR = 1e-8
# Numbers in a matrix from which skipping its zeros saves time.
_LARGE = 4096
# Steps of refinement with an inverse in extended precision, used for the most ill-conditioned entries.
_STEPS = 3


class Compliance(ABC):
    """Solves approximately with the stiffness K on the unknowns.

    Attributes
    ----------
    root
        Inverse square root of the diagonal of K, (..., n).
    least
        Lower bound on the least eigenvalue of K scaled to unit diagonal, (...); 0 where none is proved.
    greatest
        Upper bound on the greatest eigenvalue of the scaled K when all its terms are taken with the same sign.
    backward_error
        2-norm of the rounding error of the scaled matrix, (...).
    amplification
        Upper bound on the greatest eigenvalue of ``S^-1 |S|``, (...), |S| being the stiffness S with negative spring
        stiffnesses replaced by their magnitudes; one without such springs.
    """

    root: Array
    least: Array
    greatest: float
    backward_error: Array
    amplification: Array | float = 1.0

    @abstractmethod
    def distance(self) -> Array:
        """Least singular value of the deformations by the unknowns, scaled to columns of length one, (...)."""

    @property
    def near(self) -> bool:
        """Whether an entry is so close to singular that one more step of refinement pays."""
        return bool(np.any((self.least > 0.0) & (self.least < NEAR)))

    @property
    def steps(self) -> int:
        """Number of refinement steps that pay."""
        if self.root.dtype != np.float64:
            return _STEPS
        return int(self.near)

    @abstractmethod
    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""

    def solve_to(self, load: Array, share: Array) -> Array:
        """Displacements for loads (m, ..., n); an iterative solver stops when the scaled residual of each is below a
        `share` (m, ...) of the load."""
        return self.solve(load)

    def energy(self, load: Real, sizes: Real) -> Real:
        """Bound on the energy norm of the displacements under loads, (...).

        Parameters
        ----------
        load
            The loads (..., n).
        sizes
            Uncertainty of each load, of either sign, (..., n).
        """
        root = extended(self.root)
        out: Real = (norm(root * load) + norm(root * sizes)) / np.sqrt(self.least)
        return out

    @property
    def iterative(self) -> bool:
        """Whether it solves by iterations, whose number depends on the accuracy."""
        return False

    @abstractmethod
    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""


class DenseCompliance(Compliance):
    """Stack of small matrices, inverted in the precision in which the frame is given.

    From B, the deformations by the unknowns, ``S = D B^T k B D`` is assembled; its least eigenvalue is the square of
    the least singular value of ``sqrt(k) B D``. With G an approximate inverse and ``a = |I - G S| < 1``, S has no
    eigenvalue below ``(1 - a) / |G|`` (Rump, *Verification methods*, Acta Numerica 19 (2010) 287-449, sec. 10); the
    rounding of B lowers the singular value by no more than its norm.

    Parameters
    ----------
    kinematics, springs
        The frame.
    stiffness
        By link: its springs (..., 6).
    unknowns
        Numbers of the unknowns (n,).
    kind
        Double or extended precision, as the frame is given.
    """

    def __init__(
        self,
        kinematics: FrameKinematics,
        springs: list[Springs],
        stiffness: list[Array],
        unknowns: Sequence[int],
        kind: type[np.floating[Any]] = np.float64,
    ) -> None:
        self._invert(*by_unknowns(kinematics, springs, stiffness, unknowns, kind))

    @classmethod
    def of(cls, columns: Real, sizes: Real, k: Array) -> DenseCompliance:
        """The inverse from deformations by the unknowns (..., e, n), their sizes (n, ..., e) and stiffnesses (..., e),
        in the precision of the deformations."""
        out = cls.__new__(cls)
        out._invert(columns, sizes, k)
        return out

    def _invert(self, columns: Real, sizes: Real, k: Array) -> None:
        size, rounding = columns.shape[-1], float(np.finfo(columns.dtype).eps) / 2.0
        self.greatest = float(size)
        matrix = _product(np.swapaxes(columns * k[..., None], -1, -2), columns)
        diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
        root: Array = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        self.root, self._columns, self._k = root, columns, k
        self.matrix: Real = matrix * root[..., :, None] * root[..., None, :]
        entries = rounding * (k.shape[-1] + 4.0)
        weighted = (np.moveaxis(sizes**2, 0, -1) @ (root**2)[..., None])[..., 0]
        lost = _DEFORMATION * rounding * np.sqrt(np.sum(np.abs(k) * weighted, axis=-1))
        self.backward_error = size * entries + 2.0 * np.sqrt(size) * lost + lost**2
        # The shift keeps the inversion of a stack from failing at entries that are singular to rounding.
        eye = np.eye(size)
        finite = np.asarray(np.isfinite(self.matrix).all(axis=(-1, -2)))
        safe = np.where(finite[..., None, None], self.matrix, eye)
        inverse: Real = _inverse(safe + 4.0 * size * rounding * eye)
        self.inverse = inverse
        norm = np.sqrt(np.sum(inverse**2, axis=(-1, -2)))
        off = np.sqrt(np.sum((eye - _product(inverse, safe)) ** 2, axis=(-1, -2))) + 2.0 * size**1.5 * rounding * norm
        proved = np.where(off < 1.0, (1.0 - off) / np.where(norm > 0.0, norm, 1.0), 0.0) - size * entries
        singular = np.sqrt(np.maximum(proved, 0.0)) * (1.0 - 64.0 * rounding) - lost
        least: Array = np.where(finite, np.maximum(singular, 0.0) ** 2, 0.0)
        self.least = least if size else np.ones(())
        if bool((k < 0.0).any()):
            self._push(proved, lost)

    def _push(self, proved: Array, lost: Array) -> None:
        """Correct `least` for springs of negative stiffness, and set `amplification`.

        ``|S| = S + 2 S'`` with the part S' of these springs, so the amplification is at most ``1 + 2 |S'| / least``. S
        is then no product A^T A, and the rounding of B is relative to |S|, whose trace is known.
        """
        pushing = np.where(self._k < 0.0, -self._k, 0.0)
        columns = self._columns * self.root[..., None, :]
        part = np.sum(pushing[..., None] * columns**2, axis=(-1, -2))
        off = (2.0 * np.sqrt(self.root.shape[-1] + 2.0 * part) + lost) * lost
        least = np.where(np.isfinite(proved), np.maximum(proved - off, 0.0), 0.0)
        self.least = np.where(part > 0.0, least, self.least)
        self.amplification = 1.0 + 2.0 * part / np.where(self.least > 0.0, self.least, 1.0)

    def distance(self) -> Array:
        """Least singular value of the deformations by the unknowns, scaled to columns of length one, (...)."""
        scaled = self.scaled
        found = np.linalg.svd(np.where(np.isfinite(scaled), scaled, 0.0), compute_uv=False)
        least: Array = found.min(axis=-1, initial=1.0)
        if scaled.shape[-2] < scaled.shape[-1]:
            return 0.0 * least
        if not self.pushing.any():
            return least
        # With negative springs the square is the least eigenvalue, or zero where the frame is unstable.
        matrix = np.where(np.isfinite(self.matrix), self.matrix, 0.0).astype(np.float64)
        values = np.linalg.eigvalsh(matrix).min(axis=-1, initial=1.0)
        return np.where(self.pushing, np.sqrt(np.maximum(values, 0.0)), least)

    @property
    def pushing(self) -> NDArray[np.bool_]:
        """Mask of the entries with springs of negative stiffness (preloaded in compression), (...)."""
        return np.asarray((self._k < 0.0).any(axis=-1))

    @property
    def scaled(self) -> Array:
        """Deformations by the unknowns, times the root of the magnitude of their stiffness, (..., e, n); columns have
        length one if no stiffness is negative."""
        weighted: Array = (np.sqrt(np.abs(self._k))[..., None] * self._columns * self.root[..., None, :]).astype(
            np.float64
        )
        return weighted

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        scaled = self.root * load
        out: Array = self.root * np.einsum("...ij,...j->...i", self.inverse, scaled)
        return out

    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""
        out: Array = np.einsum("...ij,...j->...i", self.matrix, displacement / self.root) / self.root
        return out


def rounding_of(coupled: int) -> float:
    """2-norm of the rounding error of a scaled matrix with entries up to one, `coupled` of them in each row."""
    return _DEFORMATION * ROUNDING * coupled


def by_unknowns(
    kinematics: FrameKinematics,
    springs: list[Springs],
    stiffness: list[Array],
    unknowns: Sequence[int],
    kind: type[np.floating[Any]],
) -> tuple[Real, Real, Array]:
    """Deformations of members and relative displacements of links by the unknowns (..., e, n), their sizes (n, ..., e)
    and stiffnesses (..., e), without those of zero stiffness."""
    rows, sizes = by_units(kinematics, springs, unknowns, kind)
    k = resistances(kinematics, springs, stiffness, rows.ndim - 2).astype(kind)
    used = np.flatnonzero(_any(k) & _any(sizes))
    k, sizes, columns = k[..., used], sizes[..., used], np.moveaxis(rows[..., used], 0, -1)
    return columns, sizes, k


def resistances(kinematics: FrameKinematics, springs: list[Springs], stiffness: list[Array], ndim: int = 0) -> Array:
    """Stiffnesses of members and links, (..., e), with at least `ndim` batch axes."""
    idle = [where[..., None] for where in kinematics.idle.values()]
    none = np.zeros((*(1,) * ndim, 0))
    return together([none, *(merged(each.stiffness, -2, -1) for each in springs), *stiffness, *idle])


def by_units(
    kinematics: FrameKinematics, springs: list[Springs], unknowns: Sequence[int], kind: type[np.floating[Any]]
) -> tuple[Real, Real]:
    """Deformations of members and links by each unknown, (n, ..., springs), and their sizes."""
    size = len(unknowns)
    ndim = max([len(kinematics.shape), *(each.rows.ndim - 3 for each in springs)])
    if not size:
        count = sum(each.rows.shape[-3] * each.rows.shape[-2] for each in springs)
        count += 6 * len(kinematics.links) + len(kinematics.idle)
        none = np.zeros((0, *(1,) * ndim, count), kind)
        return none, none
    unit = np.eye(size, dtype=kind).reshape(size, *(1,) * ndim, size)
    coordinates = kinematics.coordinates(unknowns, unit, [None] * len(kinematics.links))
    moved, spread = kinematics.displacements(coordinates), kinematics.sizes(coordinates)
    none = np.zeros((size, *(1,) * ndim, 0), kind)
    of = [merged(each.of(moved, coordinates), -2, -1) for each in springs]
    parts = [merged(each.sizes(spread, coordinates), -2, -1) for each in springs]
    of += kinematics.relative_displacements(coordinates, moved)
    parts += kinematics.displacement_sizes(coordinates, spread)
    # an unknown that stands for no coordinate at an entry has a unit spring of its own there
    alone = [(np.array(unknowns) == key).astype(kind).reshape(size, *(1,) * (ndim + 1)) for key in kinematics.idle]
    of, parts = [*of, *alone], [*parts, *alone]
    return together([none, *of]), together([none, *parts])


def _product(one: Real, other: Real) -> Real:
    """Product of matrices (..., m, n) and (..., n, p), the second with many zeros; in extended precision, without BLAS,
    products with these zeros are skipped if the matrix is large."""
    out: Real
    if other.dtype == np.float64 or math.prod(other.shape[-2:]) < _LARGE:
        out = one @ other
        return out
    from scipy.sparse import csr_array

    shape = np.broadcast_shapes(one.shape[:-2], other.shape[:-2])
    first, second = (np.broadcast_to(each, (*shape, *each.shape[-2:])) for each in (one, other))
    out = np.empty((*shape, one.shape[-2], other.shape[-1]), dtype=other.dtype)
    for entry in np.ndindex(shape):
        out[entry] = (csr_array(second[entry].T) @ first[entry].T).T
    return out


def _inverse(matrix: Real) -> Real:
    """Inverse of positive definite matrices (..., n, n); in extended precision, without LAPACK, by Gauss-Jordan.

    It takes n steps on whole matrices. Solving for unit loads by `framework.ldl` takes as long for 30 matrices or more,
    and 2.4 to 3.3 times as long for one.
    """
    if matrix.dtype == np.float64:
        inverse: Real = np.linalg.inv(matrix)
        return inverse
    work = matrix.copy()
    for k in range(matrix.shape[-1]):
        pivot = 1.0 / work[..., k, k]
        row = work[..., k, :] * pivot[..., None]
        column = work[..., :, k].copy()
        work -= column[..., :, None] * row[..., None, :]
        work[..., k, :] = row
        work[..., :, k] = -column * pivot[..., None]
        work[..., k, k] = pivot
    return work


def _any(values: Real) -> NDArray[np.bool_]:
    """Along the last axis, whether any is not zero."""
    found: NDArray[np.bool_] = (values != 0.0).any(axis=tuple(range(values.ndim - 1)))
    return found


def together(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    """Arrays (..., n) concatenated along the last axis, their batch axes broadcast."""
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)
