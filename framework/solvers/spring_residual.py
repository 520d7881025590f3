"""Residuals of the equations, computed from deformations of members and joints that are constant over the batch.

The deformations are one sparse matrix in extended precision, so that a rigid motion costs no energy. The forces of the
springs can then be summed in double precision with little loss; close to singular, `SpringResidual.finely` sums them in
extended precision.
"""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..error_bounds.kinematic_edge import Real, extended
from ..program.pair_code import DoubleDouble, unbalanced
from .deformation_table import Deformations
from .patterns import times
from .transformation import Transformation


def are_described(plan: Plan | Unloaded, rows: Transformation) -> bool:
    """Whether deformations per unknown are free of rounding: no bodies, rigid links, screws or varying factors."""
    frame = plan.frame
    plain = not frame.bodies and not any(tie.rigid for tie in frame.ties) and not rows.factors
    return plain and not any(np.any(link.element.pitch) for link in frame.joints.values())


def by_springs(plan: Plan, deformations: Deformations, load: Array) -> SpringResidual | None:
    """The residual of a single matrix under loads; None if gravity, member loads or free strains act.

    Parameters
    ----------
    plan
        The plan of the frame.
    deformations
        Deformations per unknown, for the n unknowns that are solved for.
    load
        Loads on these unknowns, (n, load cases).
    """
    frame = plan.frame
    along = frame.weight is not None or any(frame.member_loads.values())
    if along or any(group.strained for group in plan.topology.groups):
        return None
    return SpringResidual(deformations, deformations.springs[:, None], load)


class SpringResidual:
    """Residuals of m matrices with k load cases each, by deformations that are the same for all.

    Parameters
    ----------
    deformations
        The deformations.
    stiffness
        Stiffness of the springs, (springs, m).
    forces
        Loads on the unknowns, without those by prescribed displacements, (size, m k).
    rhs_parameters
        Values of the right-hand-side parameters, (parameters, m k), by which prescribed displacements deform springs;
        None where there are none, or unit loads are solved for.
    """

    def __init__(
        self, deformations: Deformations, stiffness: Array, forces: Array, rhs_parameters: Array | None = None
    ) -> None:
        self.deformations, self.stiffness, self.forces = deformations, stiffness, forces
        self.given: Real | float = 0.0
        self.summed_finely = False
        if rhs_parameters is not None and deformations.by_parameters.nnz:
            self.given = deformations.by_parameters @ extended(rhs_parameters)

    def of(self, cases: slice) -> SpringResidual:
        """The residual of some load cases of a single matrix, without prescribed displacements."""
        return self.under(self.forces[:, cases])

    def under(self, forces: Array) -> SpringResidual:
        """The residual of a single matrix under other forces (size, k), without prescribed displacements."""
        out = SpringResidual(self.deformations, self.stiffness, forces)
        out.summed_finely = self.summed_finely
        return out

    def finely(self) -> SpringResidual:
        """A copy that sums spring forces in extended precision."""
        out = self.under(self.forces)
        out.given, out.summed_finely = self.given, True
        return out

    def left_by_pairs(self, values: DoubleDouble, root: Array) -> Array:
        """Residual of values in double-double precision, times a scale `root`, (size, m k), by machine code."""
        given = None if isinstance(self.given, float) else DoubleDouble.of(self.given)
        cases = self.forces.shape[1] // max(1, self.stiffness.shape[1])
        stiffness = self.stiffness if cases == 1 else np.repeat(self.stiffness, cases, axis=1)
        return unbalanced(self.deformations.split, given, stiffness, self.forces, values, root)

    def left(self, values: Real) -> Array:
        """Residual, the unbalanced loads (size, m k), of values (size, m k) of the unknowns."""
        (springs, count), cases = self.stiffness.shape, values.shape[1]
        deformed = times(self.deformations.by_unknowns, values)
        tensions: Real = deformed if isinstance(self.given, float) else deformed + self.given
        if not self.summed_finely:
            tensions = tensions.astype(np.float64)
        by_entry = tensions.reshape(springs, count, cases // max(1, count))
        by_entry *= self.stiffness[:, :, None]
        if self.summed_finely:
            fine: Array = (self.forces - self.deformations.by_unknowns.T @ tensions).astype(np.float64)
            return fine
        left: Array = self.forces - times(self.deformations.back, tensions)
        return left
