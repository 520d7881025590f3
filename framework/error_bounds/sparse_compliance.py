"""An inverse of one large stiffness by its factor, with the least eigenvalue estimated by inverse iteration."""

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

# Factor by which the least eigenvalue of a large matrix may be below the estimate of inverse iteration; fraction of
# `backward_error` below which that estimate is nothing but rounding.
_SAFETY = 4.0
_FOUND = 1.0 / 16.0
# Relative residual of solutions to a few digits.
_NEARLY = 1e-4


class Factored:
    """A sparse factor that solves for loads with leading batch axes.

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
    """A compliance whose least eigenvalue is estimated, with a safety margin."""

    def _estimated(self, found: Array, state: EquilibriumResidual) -> None:
        """Set `least` and `amplification` from the estimate (...) of the least eigenvalue by inverse iteration.

        If the estimate is nothing but rounding, `least` is zero.
        """
        self.least = np.where(found > _FOUND * self.backward_error, found / _SAFETY, 0.0)
        self.amplification = amplification(state, self.root, self._solve_nearly, _SAFETY)

    def _solve_nearly(self, load: Array) -> Array:
        """Displacements (m, ..., n) for loads (m, ..., n), to a few digits where that saves time."""
        return self.solve_to(load, np.full(load.shape[:-1], _NEARLY))


class SparseCompliance(Factored, EstimatedCompliance):
    """One large matrix with its factor; the least eigenvalue is estimated by inverse iteration, with a margin.

    Parameters
    ----------
    factor
        The factor.
    coupled
        Greatest number of unknowns that share members or joints with one unknown.
    rest
        The undisplaced state; the energy of the motion found by inverse iteration is evaluated with its frame.

    Attributes
    ----------
    softest
        Eigenvector of length one of the scaled matrix's least eigenvalue, (n,).
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
        """Twice the energy of the softest motion from deformations, accurate even if the matrix is near singular."""
        motion = extended(self.root * self.softest)
        return float(np.max(np.abs(resisted(rest, rest.unknowns, motion) @ motion)))

    def energy(self, load: Real, sizes: Real) -> Real:
        """Bound on the energy norm of the displacements under loads (..., n) with uncertainties `sizes`, (...).

        With an iterative solver, a few iterations give a far sharper bound than the least eigenvalue, which is used
        otherwise.
        """
        if not (isinstance(self.factor, Iterative) and self.iterative):
            return super().energy(load, sizes)
        flat = _flat(load.astype(np.float64)).T
        found = self.factor.energies(flat, _SAFETY).reshape(load.shape[:-1])
        # for the exact matrix, which differs from that of the iterations by rounding
        certain = 1.0 - self.backward_error / self.least
        out: Real = extended(found) / np.sqrt(certain) if certain > 0.0 else extended(np.full(found.shape, np.inf))
        return out + super().energy(np.zeros(load.shape[-1]), sizes)

    @property
    def iterative(self) -> bool:
        """Whether time depends on how well it solves."""
        return isinstance(self.factor, Iterative) and self.factor.instead is None

    def solve_to(self, load: Array, share: Array) -> Array:
        """Displacements for loads (m, ..., n) with scaled residuals of at most a `share` (m, ...) of each load."""
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
    """Estimates of the scaled matrix's softest motion (n,), of length one, and of the inverse of its least eigenvalue.

    At most `steps` of inverse iteration are done, if given; fewer if a rough estimate (`nearly`) suffices.
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
    """A compliance that solves to a given relative residual, which is enough for a correction.

    Parameters
    ----------
    compliance
        The compliance.
    share
        The relative residual.
    """

    def __init__(self, compliance: Compliance, share: float) -> None:
        self.root, self._compliance, self._share = compliance.root, compliance, share

    def solve(self, load: Array) -> Array:
        """Displacements (..., n) for loads (..., n)."""
        return self._compliance.solve_to(load, np.full(load.shape[:-1], self._share))


def _flat(array: Array) -> Array:
    """An array (..., n) with its batch as one axis, (m, n); n may be 0."""
    return array.reshape(math.prod(array.shape[:-1]), array.shape[-1])
