"""An inverse of the stiffness with a proof of how good it is, for a stack of matrices or for one large one."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from .batch import Array
from .deformations import Springs
from .kinematics import Kinematics, Real

if TYPE_CHECKING:
    from .factor import Factor

ROUNDING = float(np.finfo(np.float64).eps) / 2.0
# Roundings in a deformation, for the size of what it is made of.
_DEFORMATION = 32.0
# Least eigenvalue below which products of two errors begin to count.
NEAR = 1e-8
# Inverse iterations for a large matrix, and the factor by which the least eigenvalue may still be below what they find.
_ITERATIONS = 8
_SAFETY = 16.0


class Compliance(ABC):
    """Solves approximately with the stiffness K on the unknowns.

    Attributes
    ----------
    root
        (..., n): one over the square root of the diagonal of K.
    least
        (...): what the least eigenvalue of K, scaled to unit diagonal, is not below; 0 where none is proved.
    fuzz
        (...): 2-norm of the rounding in the scaled matrix as it is applied.
    """

    root: Array
    least: Array
    fuzz: Array

    @property
    def near(self) -> bool:
        """Whether something is so close to singular that one more step of refinement is worth it."""
        return bool(np.any((self.least > 0.0) & (self.least < NEAR)))

    @abstractmethod
    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""

    @abstractmethod
    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""


class DenseCompliance(Compliance):
    """Stack of small matrices, inverted.

    From B, the deformations by the unknowns, ``S = D B^T k B D`` is assembled; its least eigenvalue is the square of
    the least singular value of ``sqrt(k) B D``. With G an approximate inverse and ``a = |I - G S| < 1``, S has none
    below ``(1 - a) / |G|`` (Rump, *Verification methods*, Acta Numerica 19 (2010) 287-449, sec. 10); the rounding of B
    lowers the singular value by no more than its norm.

    Parameters
    ----------
    kinematics, springs
        The frame, in double precision.
    stiffness
        By link: its springs (..., 6).
    unknowns
        Numbers of the unknowns (n,).
    """

    def __init__(
        self, kinematics: Kinematics, springs: list[Springs], stiffness: list[Array], unknowns: Sequence[int]
    ) -> None:
        size = len(unknowns)
        if not size:
            self.root = np.ones(0)
            self.matrix: Array = np.zeros((0, 0))
            self.inverse: Array = np.zeros((0, 0))
            self.least, self.fuzz = np.ones(()), np.zeros(())
            return
        rows, sizes = _rows(kinematics, springs, unknowns)
        k = _together([*(each.stiffness.reshape(*each.stiffness.shape[:-2], -1) for each in springs), *stiffness])
        columns = np.moveaxis(rows, 0, -1)
        matrix = np.swapaxes(columns * k[..., None], -1, -2) @ columns
        diagonal = np.diagonal(matrix, axis1=-2, axis2=-1)
        root: Array = 1.0 / np.sqrt(np.where(diagonal > 0.0, diagonal, 1.0))
        self.root = root
        self.matrix = matrix * self.root[..., :, None] * self.root[..., None, :]
        entries = ROUNDING * (k.shape[-1] + 4.0)
        lost = (
            _DEFORMATION
            * ROUNDING
            * np.sqrt(
                np.einsum("n...e,...e,n...e->...", sizes, k, sizes * np.moveaxis(self.root, -1, 0)[..., None] ** 2)
            )
        )
        self.fuzz = size * entries + 2.0 * np.sqrt(size) * lost + lost**2
        # The shift keeps what is singular to rounding from stopping the others.
        eye = np.eye(size)
        finite = np.asarray(np.isfinite(self.matrix).all(axis=(-1, -2)))
        safe = np.where(finite[..., None, None], self.matrix, eye)
        inverse: Array = np.linalg.inv(safe + 4.0 * size * ROUNDING * eye)
        self.inverse = inverse
        norm = np.sqrt(np.sum(self.inverse**2, axis=(-1, -2)))
        off = np.sqrt(np.sum((eye - self.inverse @ safe) ** 2, axis=(-1, -2))) + 2.0 * size**1.5 * ROUNDING * norm
        proved = np.where(off < 1.0, (1.0 - off) / norm, 0.0) - size * entries
        singular = np.sqrt(np.maximum(proved, 0.0)) * (1.0 - 64.0 * ROUNDING) - lost
        least: Array = np.where(finite, np.maximum(singular, 0.0) ** 2, 0.0)
        self.least = least

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        scaled = self.root * load
        out: Array = self.root * np.einsum("...ij,...j->...i", self.inverse, scaled)
        return out

    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""
        out: Array = np.einsum("...ij,...j->...i", self.matrix, displacement / self.root) / self.root
        return out


class SparseCompliance(Compliance):
    """One large matrix with its factor; the least eigenvalue by inverse iteration, with a margin for what that misses.

    Parameters
    ----------
    factor
        The factor.
    """

    def __init__(self, factor: Factor) -> None:
        self.factor, self.root = factor, factor.root
        size = len(self.root)
        vector = np.random.default_rng(0).standard_normal((size, 2))
        growth = 0.0
        for _ in range(_ITERATIONS):
            found = factor.unscaled(vector / np.sqrt(np.sum(vector**2, axis=0)))
            if found is None or not np.isfinite(found).all():
                growth = np.inf
                break
            vector, growth = found, float(np.sqrt(np.sum(found**2, axis=0)).max())
        width = np.max(np.diff(factor.scaled.indptr))
        self.fuzz = np.asarray(_DEFORMATION * ROUNDING * float(width))
        self.least = np.asarray(max(1.0 / (_SAFETY * growth) - self.fuzz, 0.0))

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        flat = load.reshape(-1, load.shape[-1]).T
        return self.factor.solve(flat).T.reshape(load.shape)

    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""
        flat = (displacement / self.root).reshape(-1, displacement.shape[-1]).T
        out: Array = (self.factor.scaled @ flat).T.reshape(displacement.shape) / self.root
        return out


def _rows(kinematics: Kinematics, springs: list[Springs], unknowns: Sequence[int]) -> tuple[Array, Array]:
    """Deformations of members and openings of links by each unknown, (n, ..., springs), and sizes of their parts."""
    size = len(unknowns)
    ndim = max([len(kinematics.shape), *(each.rows.ndim - 3 for each in springs)])
    unit = np.eye(size).reshape(size, *(1,) * ndim, size)
    coordinates = kinematics.coordinates(unknowns, unit, [None] * len(kinematics.links))
    moved, spread = kinematics.displacements(coordinates), kinematics.sizes(coordinates)
    of = [_flat(each.of(moved)) for each in springs] + kinematics.openings(coordinates, moved)
    parts = [_flat(each.sizes(spread)) for each in springs] + kinematics.opening_sizes(coordinates, spread)
    return _together(of), _together(parts)


def _flat(array: Real) -> Real:
    return array.reshape(*array.shape[:-2], -1)


def _together(parts: Sequence[NDArray[Any]]) -> NDArray[Any]:
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    return np.concatenate([np.broadcast_to(part, (*shape, part.shape[-1])) for part in parts], axis=-1)
