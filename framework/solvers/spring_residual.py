"""What solutions leave of their equations by deformations of members and joints that do not vary over the batch.

They are one sparse matrix in extended precision, so that a rigid motion costs nothing; the forces that they call for
may then be summed in double precision, as hardly anything is lost in them: `SpringResidual.finely` is for what is near to
singular.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..error_bounds.deformations import constant_rows
from ..error_bounds.kinematic_edge import Real, extended
from ..structure.topology import Group, Index
from .evaluation import Picked
from .patterns import by_rows
from .transformation import Transformation

Mask = NDArray[np.bool_]


class Deformations:
    """Deformations of all springs by the unknowns and the right-hand-side parameters, the same at all entries.

    Those of spring i of a group of n members are numbers ``n i + piece``, group by group; those of joints and supports
    follow.

    Parameters
    ----------
    plan
        The compiled frame, see `are_constant`.
    rows
        What its displacements are made of.
    place
        Place of each unknown among those that are solved for, (n,); -1 where it is none of these.

    Attributes
    ----------
    acting
        Numbers of the springs that these deform.
    by_unknowns, by_parameters
        Their deformations by a unit of each.
    """

    def __init__(self, plan: Plan, rows: Transformation, place: Index) -> None:
        data, spring, dof, count = _by_displacements(plan)
        item, at = rows.expanded(dof)
        data, spring, column = data[item] * rows.share[at], spring[item], rows.column[at]
        column = np.concatenate([place, len(place) + np.arange(rows.known)])[column]
        known, own = column >= len(place), (column >= 0) & (column < len(place))
        acts = np.zeros(count, dtype=bool)
        acts[spring[own]] = True
        self.acting: Index = np.flatnonzero(acts)
        known &= acts[spring]
        where, size = (np.cumsum(acts) - 1)[spring], int((place >= 0).sum())
        self.by_unknowns = by_rows(data[own], where[own], column[own], (len(self.acting), size))
        columns = column[known] - len(place)
        self.by_parameters = by_rows(data[known], where[known], columns, (len(self.acting), rows.known))
        self.back = by_rows(data[own].astype(np.float64), column[own], where[own], (size, len(self.acting)))


def _by_displacements(plan: Plan) -> tuple[Real, Index, Index, int]:
    """Deformations by displacements: numbers, which spring, which displacement, and how many springs there are."""
    joints, first = np.arange(len(plan.tree.springs)), 0
    picked = Picked.of(plan.frame.shape, 0, np.zeros(1, dtype=np.int64))
    out: list[tuple[Real, Index, Index]] = []
    for group in plan.topology.groups:
        found = constant_rows(plan, group, picked.of_group(group).element)
        piece, spring, k = np.nonzero(found)
        out.append((found[piece, spring, k], first + spring * len(found) + piece, group.dofs[piece, k]))
        first += found.shape[0] * found.shape[1]
    out.append((extended(np.ones(len(joints))), first + joints, 6 * len(plan.topology.number) + joints))
    data, spring, dof = (np.concatenate(each) for each in zip(*out, strict=True))
    return data, spring, dof, first + len(joints)


def are_described(plan: Plan, rows: Transformation) -> bool:
    """Whether deformations by the unknowns are described without rounding on the way, and factors do not vary."""
    frame = plan.frame
    plain = not frame.bodies and not any(tie.rigid for tie in frame.ties) and not rows.factors
    return plain and not any(np.any(link.element.pitch) for link in frame.joints.values())


def by_springs(plan: Plan, where: Mask, load: Array) -> SpringResidual | None:
    """The residual of one matrix, of which the load (n, load cases) on the unknowns `where` (n,) is all that acts.

    None where known displacements act as well, or what is linear in a load along members; and where deformations are
    not described without rounding.
    """
    topology, frame = plan.topology, plan.frame
    rows = plan.graph.transformation
    along = frame.weight is not None or any(frame.member_loads.values()) or any(g.strained for g in topology.groups)
    if along or rows.imposed or not are_described(plan, rows):
        return None
    deformations = Deformations(plan, rows, np.where(where, np.cumsum(where) - 1, -1))
    each = [_stiffness(group).reshape(-1) for group in topology.groups]
    joints = np.array([np.reshape(spring.stiffness, -1)[0] for spring in plan.tree.springs], dtype=np.float64)
    stiffness = np.concatenate([*each, joints])[deformations.acting]
    return SpringResidual(deformations, stiffness[:, None], load[where])


def _stiffness(group: Group) -> Array:
    """Stiffness of the springs of members that do not vary over the batch, (springs, pieces)."""
    found = group.element.springs(group.length)[0]
    return np.broadcast_to(found.reshape(-1, found.shape[-1]), (len(group.pieces), found.shape[-1])).T


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
        self._summed_finely = False
        if rhs_parameters is not None and deformations.by_parameters.nnz:
            self.given = deformations.by_parameters @ extended(rhs_parameters)

    def of(self, cases: slice) -> SpringResidual:
        """That of some load cases of one matrix without known displacements."""
        return self.under(self.forces[:, cases])

    def under(self, forces: Array) -> SpringResidual:
        """That of one matrix under other forces (size, k) and no known displacements."""
        out = SpringResidual(self.deformations, self.stiffness, forces)
        out._summed_finely = self._summed_finely
        return out

    def finely(self) -> SpringResidual:
        """The same with forces summed in extended precision."""
        out = self.under(self.forces)
        out.given, out._summed_finely = self.given, True
        return out

    def left(self, values: Real) -> Array:
        """Unbalanced load (size, m k) of the values (size, m k) of the unknowns."""
        (springs, count), cases = self.stiffness.shape, values.shape[1]
        deformed = self.deformations.by_unknowns @ values
        tensions: Real = deformed if isinstance(self.given, float) else deformed + self.given
        if not self._summed_finely:
            tensions = tensions.astype(np.float64)
        by_entry = tensions.reshape(springs, count, cases // max(1, count))
        by_entry *= self.stiffness[:, :, None]
        back = self.deformations.by_unknowns.T if self._summed_finely else self.deformations.back
        left: Array = (self.forces - back @ tensions).astype(np.float64, copy=False)
        return left
