"""Bounds on the error of displacements by energy alone, without an adjoint for each.

The exact solution differs from the computed one by a motion w, and a result with the unit load g by ``g . w``, which is
no more than the energy norm of w times that of what g brings about (Cauchy-Schwarz). The first is one number for all
results, the second comes of a few iterations. What rounding of the members' stiffnesses may do is in the first, where
an adjoint tells how much of it is where the result depends on it: such a bound is wider, which hardly counts beside
what iterations leave in a solution.
"""

from __future__ import annotations

from functools import cached_property
from typing import Any

import numpy as np

from ..structure.parts import Extended
from .compliance import Compliance
from .equilibrium import EquilibriumResidual
from .force_sizes import reduced_sizes
from .kinematic_edge import Real
from .requested import RequestedResults

# Roundings of a load on an unknown: those of turning it into its axes, a safe count, and of each rigid link on the way.
CAREFUL, CARRIED = 64.0, 4.0
_LEAST = float(np.finfo(Extended).eps)
# By how much a bound may be above the greatest error of a solution of which it is the bound at one node.
_WIDE = 8.0


def energy_of_error(state: EquilibriumResidual, compliance: Compliance) -> Real:
    """Energy norm of what the exact solution differs from the computed one, at most, (...).

    Forces p on the deformations B u bring about a motion w with the energy ``p . B w``, which is at most ``|k^-1/2 p|``
    times the norm of w by the sizes |k| of the stiffnesses; its square is some times the energy, see
    `Compliance.amplification`.
    """
    forces = np.sqrt(compliance.amplification) * state.force_uncertainty
    out: Real = compliance.energy(state.balance, state.unbalanced) + forces
    return out


def greatest_change(before: EquilibriumResidual, state: EquilibriumResidual) -> Real:
    """The most by which a correction moved and turned any node, (..., 6), the translations alike, and the rotations."""
    change = np.abs(state.displacements - before.displacements).max(axis=-2)
    halves = change.reshape(*change.shape[:-1], 2, 3).max(axis=-1)
    out: Real = np.repeat(halves, 3, axis=-1)
    return out


class EnergyBound:
    """Displacements of a solution as they are, and what they may be off.

    Parameters
    ----------
    state
        The solution, corrected as far as that is worth it.
    compliance
        Inverse of its stiffness.
    result
        What is asked for, m results with unit loads on nodes alone.
    energy
        Of the solution's error, at most, (...).
    """

    def __init__(
        self, state: EquilibriumResidual, compliance: Compliance, result: RequestedResults, energy: Real
    ) -> None:
        self.state, self.compliance, self.result, self.energy = state, compliance, result, energy

    @property
    def refined(self) -> Real:
        """The results, (..., m)."""
        return self.result.value

    def is_sharp(self, greatest: Real) -> bool:
        """Whether the bounds are no more than some times the error of the solution elsewhere, (..., m)."""
        return bool(np.all(self._bound <= _WIDE * greatest))

    def error_bound(self) -> Real:
        """What `refined` may be off, (..., m)."""
        return self._bound

    @cached_property
    def _bound(self) -> Real:
        state, double, forces = self.state, self.state.double, self.result.forces
        assert forces is not None
        links: list[Any] = [None] * len(double.links)
        unit = double.reduced(state.unknowns, double.generalised(forces, links))
        careful = (CAREFUL + CARRIED * len(links)) * state.rounding
        sizes = careful * reduced_sizes(double, state.unknowns, np.abs(forces), links)
        own = self.compliance.energy(unit, sizes)
        work = np.where((own == 0.0) | (self.energy == 0.0), 0.0, own * self.energy)
        out: Real = np.moveaxis(work, 0, -1) + self.result.error_bound
        return out + 4.0 * _LEAST * np.abs(self.refined)
