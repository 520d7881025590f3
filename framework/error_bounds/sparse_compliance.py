"""An inverse of one large stiffness by its factor, with a proof of how good it is by inverse iteration."""

from __future__ import annotations

import math

import numpy as np

from ..batch import Array
from ..solvers.factor import Factor
from ..solvers.iterative import Iterative
from .compliance import Compliance, rounding_of
from .equilibrium import EquilibriumResidual
from .kinematic_edge import Real, extended
from .pushing import amplification
from .resistance import resisted

# The factor by which the least eigenvalue of a large matrix may still be below what inverse iteration finds, and the
# share of `backward_error` below which that finds nothing but rounding.
_SAFETY = 4.0
_FOUND = 1.0 / 16.0
# Share of a load that solutions to a few digits leave unbalanced.
_NEARLY = 1e-4


class Factored:
    """A sparse factor, for loads with the batch before.

    Parameters
    ----------
    factor
        The factor.
    """

    def __init__(self, factor: Factor) -> None:
        self.factor, self.root = factor, factor.root

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        flat = _flat(load.astype(np.float64)).T
        return self.factor.solve(flat).T.reshape(load.shape)


class EstimatedCompliance(Compliance):
    """A compliance of which the least eigenvalue is estimated, with a margin for what that misses."""

    def _estimated(self, found: Array, state: EquilibriumResidual) -> None:
        """Set `least` and `amplification` from the least eigenvalue (...) that inverse iteration finds.

        Where no more than rounding is found, there is none.
        """
        self.least = np.where(found > _FOUND * self.backward_error, found / _SAFETY, 0.0)
        self.amplification = amplification(state, self.root, self._solve_nearly, _SAFETY)

    def _solve_nearly(self, load: Array) -> Array:
        """Displacements (m, ..., n) for loads (m, ..., n), to a few digits where that saves time."""
        return self.solve_to(load, np.full(load.shape[:-1], _NEARLY))


class SparseCompliance(Factored, EstimatedCompliance):
    """One large matrix with its factor; the least eigenvalue by inverse iteration, with a margin for what that misses.

    Parameters
    ----------
    factor
        The factor.
    coupled
        Unknowns that share members or joints with one unknown, at most: no scaled entry is above one.
    rest
        The frame without displacement, to which the motion that inverse iteration finds is put.

    Attributes
    ----------
    softest
        The motion that the scaled matrix resists least (n,), of length one.
    """

    def __init__(self, factor: Factor, coupled: int, rest: EquilibriumResidual) -> None:
        super().__init__(factor)
        self.greatest = float(coupled)
        self.softest, growth = softest(factor, nearly=True)
        self._growth = growth
        self.backward_error = np.asarray(rounding_of(coupled))
        least = min(1.0 / growth, self._resistance(rest)) if len(self.root) else 1.0
        self._estimated(np.asarray(least), rest)

    def _resistance(self, rest: EquilibriumResidual) -> float:
        """Work against the softest motion; where the matrix is near singular, itself may not tell for its rounding."""
        motion = extended(self.root * self.softest)
        return float(np.max(np.abs(resisted(rest, rest.unknowns, motion) @ motion)))

    def energy(self, load: Real, sizes: Real) -> Real:
        """Energy norm of the displacements under loads (..., n) that may be off by `sizes` (..., n), at most, (...).

        Where iterations solve, a few of them tell far better than the least eigenvalue, which serves for the rest.
        """
        if not (isinstance(self.factor, Iterative) and self.iterative):
            return super().energy(load, sizes)
        flat = _flat(load.astype(np.float64)).T
        found = self.factor.energies(flat, _SAFETY).reshape(load.shape[:-1])
        # of the exact matrix, from which that of the iterations differs by its rounding
        certain = 1.0 - self.backward_error / self.least
        out: Real = extended(found) / np.sqrt(certain) if certain > 0.0 else extended(np.full(found.shape, np.inf))
        return out + super().energy(np.zeros(load.shape[-1]), sizes)

    @property
    def iterative(self) -> bool:
        """Whether time depends on how well it solves."""
        return isinstance(self.factor, Iterative) and self.factor.instead is None

    def solve_to(self, load: Array, share: Array) -> Array:
        """Displacements for loads (m, ..., n) that leave no more than a `share` (m, ...) of each, scaled."""
        flat = _flat(load.astype(np.float64)).T
        shares = np.broadcast_to(share, load.shape[:-1]).astype(np.float64).reshape(-1)
        return self.factor.solve_to(flat, shares).T.reshape(load.shape)

    def distance(self) -> Array:
        """Least singular value of the deformations by the unknowns, scaled to columns of length one, estimated, ()."""
        growth = softest(self.factor)[1] if self.iterative else self._growth
        return np.asarray(1.0 / np.sqrt(growth))

    def apply(self, displacement: Array) -> Array:
        """Loads (..., n) for displacements (..., n)."""
        flat = _flat(displacement.astype(np.float64) / self.root).T
        out: Array = (self.factor.scaled @ flat).T.reshape(displacement.shape) / self.root
        return out


def softest(factor: Factor, steps: int | None = None, *, nearly: bool = False) -> tuple[Array, float]:
    """Motion (n,) of length one that the scaled matrix resists least, and one over what it resists it by, estimated.

    No more `steps` of inverse iteration are done, where they are given; fewer where it is to be known `nearly`.
    """
    vector, enough = factor.soft(nearly=nearly)
    growth = 0.0 if len(vector) else 1.0
    for _ in range(enough if steps is None else min(steps, enough)):
        found = factor.roughly(vector / np.sqrt(np.sum(vector**2, axis=0)))
        if found is None or not np.isfinite(found).all():
            growth = np.inf
            break
        vector = found
        growth = float(np.sqrt(np.sum(found**2, axis=0)).max()) if len(vector) else 1.0
    out: Array = vector[:, 0] / np.sqrt(np.sum(vector[:, 0] ** 2))
    return out, growth


class Roughly:
    """A compliance that leaves a share of what it solves for, which is enough for a correction.

    Parameters
    ----------
    compliance
        The compliance.
    share
        The share.
    """

    def __init__(self, compliance: Compliance, share: float) -> None:
        self.root, self._compliance, self._share = compliance.root, compliance, share

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        return self._compliance.solve_to(load, np.full(load.shape[:-1], self._share))


def _flat(array: Array) -> Array:
    """An array (..., n) with its batch as one axis, (m, n); n may be 0."""
    return array.reshape(math.prod(array.shape[:-1]), array.shape[-1])
