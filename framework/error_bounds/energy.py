"""Bounds on the error of displacements by energy alone, without an adjoint for each.

The exact solution differs from the computed one by a motion w, and a result with the unit load g by ``g . w``, which is
no more than the energy norm of w times that of the displacements under g (Cauchy-Schwarz). The first is one number for
all results, the second takes a few iterations. The first includes the rounding of all members' stiffnesses, whereas an
adjoint weights it by its influence on the result: this bound is wider, but little compared with the error that an
iterative solver leaves.
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

# Roundings of a load on an unknown: of rotating it into its axes (on the safe side), and of each rigid link on the way.
CAREFUL, CARRIED = 64.0, 4.0
_LEAST = float(np.finfo(Extended).eps)
# Greatest ratio of a bound at one node to the greatest error of the solution at which the bound counts as sharp.
_WIDE = 8.0


def energy_of_error(state: EquilibriumResidual, compliance: Compliance) -> Real:
    """Bound on the energy norm of the solution's error, (...).

    Forces p on the deformations B u cause a motion w with the energy ``p . B w``, which is at most ``|k^-1/2 p|`` times
    the norm of w in the magnitudes |k| of the stiffnesses; the square of that norm is at most
    `Compliance.amplification` times the energy.
    """
    forces = np.sqrt(compliance.amplification) * state.force_uncertainty
    out: Real = compliance.energy(state.balance, state.unbalanced) + forces
    return out


def greatest_change(before: EquilibriumResidual, state: EquilibriumResidual) -> Real:
    """Greatest correction of any node, (..., 6): of translations (the same three times), and of rotations likewise."""
    change = np.abs(state.displacements - before.displacements).max(axis=-2)
    halves = change.reshape(*change.shape[:-1], 2, 3).max(axis=-1)
    out: Real = np.repeat(halves, 3, axis=-1)
    return out


class EnergyBound:
    """Displacements of a solution, and bounds on their error by its energy.

    Parameters
    ----------
    state
        The corrected solution.
    compliance
        Inverse of its stiffness.
    result
        The m requested results, with unit loads on nodes only.
    energy
        Bound on the energy norm of the solution's error, (...).
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
        """Whether no bound exceeds a few times the greatest error of the solution, (..., m)."""
        return bool(np.all(self._bound <= _WIDE * greatest))

    def error_bound(self) -> Real:
        """Bound on the error of `refined`, (..., m)."""
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
