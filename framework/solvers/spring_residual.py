"""What solutions leave of their equations by deformations of members and joints that do not vary over the batch.

They are one sparse matrix in extended precision, so that a rigid motion costs nothing; the forces that they call for
may then be summed in double precision, as hardly anything is lost in them: `SpringResidual.finely` is for what is near
to singular.
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
    """Whether deformations by the unknowns are described without rounding on the way, and factors do not vary."""
    frame = plan.frame
    plain = not frame.bodies and not any(tie.rigid for tie in frame.ties) and not rows.factors
    return plain and not any(np.any(link.element.pitch) for link in frame.joints.values())


def by_springs(plan: Plan, deformations: Deformations, load: Array) -> SpringResidual | None:
    """The residual of one matrix, of which the load (n, load cases) on what deforms is all that acts.

    None where known displacements act as well, or what is linear in a load along members.

    Parameters
    ----------
    plan
        The compiled frame.
    deformations
        Deformations by the unknowns that are solved for.
    load
        Loads on these unknowns, (n, load cases).
    """
    frame = plan.frame
    along = frame.weight is not None or any(frame.member_loads.values())
    if along or any(group.strained for group in plan.topology.groups):
        return None
    return SpringResidual(deformations, deformations.springs[:, None], load)


class SpringResidual:
    """Unbalanced loads by deformations that do not vary.

    Parameters
    ----------
    deformations
        The deformations.
    stiffness
        Of the springs, (springs, m).
    forces
        Loads without what known displacements call for, (size, m k).
    rhs_parameters
        Known displacements: the numbers (right-hand-side parameters, m k); None where there are none, or a unit of a
        load is solved for.
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
        """That of some load cases of one matrix without known displacements."""
        return self.under(self.forces[:, cases])

    def under(self, forces: Array) -> SpringResidual:
        """That of one matrix under other forces (size, k) and no known displacements."""
        out = SpringResidual(self.deformations, self.stiffness, forces)
        out.summed_finely = self.summed_finely
        return out

    def finely(self) -> SpringResidual:
        """The same with forces summed in extended precision."""
        out = self.under(self.forces)
        out.given, out.summed_finely = self.given, True
        return out

    def left_by_pairs(self, values: DoubleDouble, root: Array) -> Array:
        """The same of pairs of double numbers, by machine code, times a scale (size, m k)."""
        given = None if isinstance(self.given, float) else DoubleDouble.of(self.given)
        cases = self.forces.shape[1] // max(1, self.stiffness.shape[1])
        stiffness = self.stiffness if cases == 1 else np.repeat(self.stiffness, cases, axis=1)
        return unbalanced(self.deformations.split, given, stiffness, self.forces, values, root)

    def left(self, values: Real) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
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
