"""What solutions of a batch leave of their equations, so exactly that a rigid motion costs nothing.

Where geometry and joints do not vary, the deformations by the unknowns are one sparse matrix in extended precision; the
forces that they call for may then be summed in double precision, as nothing is lost in them.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..error_bounds.deformations import springs
from ..error_bounds.equilibrium import EquilibriumResidual
from ..error_bounds.kinematics import FrameKinematics, Real, extended
from ..error_bounds.picked import PickedStatics, plan_at
from ..error_bounds.resistance import resisted
from ..structure.parts import Extended
from ..structure.topology import Index
from .coupling import Coupling
from .evaluation import Picked, numbers_of

Mask = NDArray[np.bool_]
# Bytes of a member in extended precision.
_MEMBER = 3000


class Residual(Protocol):
    """Unbalanced loads of some entries."""

    def left(self, values: Real) -> Array:
        """Unbalanced load (m, k, size) of values (m, k, size), both by unknown."""
        ...


class Deformations:
    """Deformations of all springs by the unknowns and the right-hand-side parameters, the same at all entries.

    Parameters
    ----------
    plan
        The compiled frame.
    loaded
        Unknowns that are solved for, (n,).
    """

    def __init__(self, plan: Plan, loaded: Mask) -> None:
        self.coupling: Coupling = plan.coupling
        picked = Picked.of(plan.frame.shape, 0, np.zeros(1, dtype=np.int64))
        parts = [self._of_members(plan, picked), self._of_joints(plan)]
        data, row, column = (np.concatenate(each) for each in zip(*parts, strict=True))
        count, change = self.coupling.blocks[-1].first, self.coupling.transformation
        local = scipy.sparse.coo_matrix((data, (row, column)), shape=(count, change.shape[0])).tocsr()
        whole = scipy.sparse.csr_matrix(local @ change.astype(Extended))
        size = self.coupling.size
        unknown, known = whole[:, :size][:, np.flatnonzero(loaded)], whole[:, size:]
        self.acting: Index = np.flatnonzero(np.diff(unknown.indptr))
        self.by_unknowns, self.by_parameters = (
            scipy.sparse.csr_matrix(unknown[self.acting]),
            scipy.sparse.csr_matrix(known[self.acting]),
        )
        self.back = scipy.sparse.csr_matrix(self.by_unknowns.astype(np.float64).T)

    def _of_members(self, plan: Plan, picked: Picked) -> tuple[Real, Index, Index]:
        out: list[tuple[Real, Index, Index]] = [(extended(np.zeros(0)), *(np.zeros(0, dtype=np.int64),) * 2)]
        for block, kind in zip(self.coupling.blocks, springs(plan_at(plan, picked)), strict=False):
            rows = kind.rows[0]
            piece, spring, k = np.nonzero(rows)
            dofs = 6 * kind.nodes[piece, k // 6] + k % 6
            out.append((rows[piece, spring, k], block.first + spring * len(rows) + piece, dofs))
        data, row, column = (np.concatenate(each) for each in zip(*out, strict=True))
        return data, row, column

    def _of_joints(self, plan: Plan) -> tuple[Real, Index, Index]:
        block = self.coupling.blocks[-2]
        own = np.arange(block.count)
        return extended(np.ones(block.count)), block.first + own, 6 * len(plan.topology.number) + own

    def stiffness(self, picked: Picked) -> Array:
        """Stiffness of the springs that act at some entries, (springs, m)."""
        count = len(picked.index[0]) if picked.index else 1
        each = [numbers_of(block, picked) for block in self.coupling.blocks[:-1]]
        whole = [np.broadcast_to(numbers, (len(numbers), count)) for numbers in each]
        found: Array = np.concatenate([np.zeros((0, count)), *whole])[self.acting]
        return found


def are_constant(plan: Plan) -> bool:
    """Whether deformations by the unknowns are the same at all entries, and described without rounding on the way."""
    coupling, frame = plan.coupling, plan.frame
    plain = not frame.bodies and not any(tie.rigid for tie in frame.ties) and not coupling.factors
    screws = any(np.any(link.element.pitch) for link in frame.joints.values())
    return plain and not screws and all(block.rows is not None for block in coupling.blocks if block.group is not None)


class SpringResidual:
    """Residual by deformations that do not vary.

    Parameters
    ----------
    deformations
        The deformations.
    stiffness
        Of the springs, (springs, m).
    forces
        Loads without what known displacements call for, (m, k, size).
    rhs_parameters
        Known displacements: the numbers (knowns, m, k); None where a unit of a load is solved for.
    """

    def __init__(
        self, deformations: Deformations, stiffness: Array, forces: Array, rhs_parameters: Array | None
    ) -> None:
        self.deformations, self.stiffness, self.forces = deformations, stiffness, forces
        self.given: Real | float = 0.0
        if rhs_parameters is not None and deformations.by_parameters.nnz:
            self.given = deformations.by_parameters @ extended(rhs_parameters.reshape(len(rhs_parameters), -1))

    def left(self, values: Real) -> Array:
        """Unbalanced load (m, k, size) of values (m, k, size), both by unknown."""
        m, k, size = values.shape
        flat = np.ascontiguousarray(np.moveaxis(values, -1, 0)).reshape(size, m * k)
        deformed = (self.deformations.by_unknowns @ flat + self.given).astype(np.float64)
        pulls = (deformed.reshape(-1, m, k) * self.stiffness[:, :, None]).reshape(-1, m * k)
        inner = (self.deformations.back @ pulls).reshape(size, m, k)
        left: Array = self.forces - np.moveaxis(inner, 0, -1)
        return left


class StaticsResidual:
    """Residual of entries of which each has its own geometry.

    Parameters
    ----------
    plan, kinematics
        The compiled frame, and its kinematics at the whole batch.
    picked
        The entries, (m k,).
    names
        Numbers of the unknowns.
    units
        Loads (m, k, size) where units of the right-hand-side parameters are solved for; None where all that acts is.
    """

    def __init__(
        self, plan: Plan, kinematics: FrameKinematics, picked: Picked, names: Sequence[int], units: Array | None
    ) -> None:
        self.names, self.units = list(names), units
        self.statics = PickedStatics(plan, kinematics, picked)

    def left(self, values: Real) -> Array:
        """Unbalanced load (m, k, size) of values (m, k, size), both by unknown."""
        if self.units is not None:
            met = np.moveaxis(resisted(self.statics, self.names, np.moveaxis(values, 1, 0)), 0, 1)
            return np.asarray(self.units - met, dtype=np.float64)
        state = EquilibriumResidual(self.statics, _same, self.names, values.reshape(-1, len(self.names)), 1)
        return state.balance.reshape(values.shape).astype(np.float64)

    @staticmethod
    def bytes(plan: Plan) -> int:
        """What an entry takes."""
        return _MEMBER * max(1, len(plan.topology.ends))


def _same(array: Real, trailing: int) -> Real:
    return array
