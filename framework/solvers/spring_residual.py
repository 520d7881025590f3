"""What solutions leave of their equations by deformations of members and joints that do not vary over the batch.

They are one sparse matrix in extended precision, so that a rigid motion costs nothing; the forces that they call for
may then be summed in double precision, as hardly anything is lost in them: `SpringResidual.finely` is for what is near
to singular.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..error_bounds.deformations import constant_springs
from ..error_bounds.kinematic_edge import Real, extended
from ..program.pair_code import DoubleDouble, Rows, unbalanced
from ..structure.topology import Index
from .evaluation import Picked
from .patterns import filled, kept, pattern_by_rows, product
from .transformation import Transformation, expanded

Mask = NDArray[np.bool_]


@dataclass(frozen=True)
class _Pattern:
    """Where the numbers of `Deformations` lie, which frames of one topology have in common.

    Attributes
    ----------
    taken, shares
        Numbers among the deformations by displacements, and among the shares of `Transformation`, whose products are
        the terms.
    acting
        Numbers of the springs that the unknowns deform.
    unknowns, parameters, back
        Order of the terms in each matrix, and a matrix of its pattern.
    """

    taken: Index
    shares: Index
    acting: Index
    unknowns: tuple[Index, scipy.sparse.csr_matrix]
    parameters: tuple[Index, scipy.sparse.csr_matrix]
    back: tuple[Index, scipy.sparse.csr_matrix]


class Deformations:
    """Deformations of all springs by the unknowns and the right-hand-side parameters, the same at all entries.

    Those of spring i of a group of n members are numbers ``n i + piece``, group by group; those of joints and supports
    follow.

    Parameters
    ----------
    plan
        The compiled frame, see `are_described`.
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
    back
        The first of these transposed, in double precision.
    springs
        Stiffness of these springs at the first entry of the batch, (springs,).
    """

    def __init__(self, plan: Plan | Unloaded, rows: Transformation, place: Index) -> None:
        picked = Picked.of(plan.frame.shape, 0, np.zeros(1, dtype=np.int64))
        groups = plan.topology.groups
        each = [constant_springs(plan, group, picked.of_group(group).element) for group in groups]
        found = [rows for _, rows in each]
        used = [each.astype(bool) for each in found]
        dofs, joints = [group.dofs for group in groups], len(plan.tree.springs)
        tables = [rows.start, rows.column, place, np.array([rows.known, 6 * len(plan.topology.number), joints])]
        masks = [np.packbits(each) for each in used]
        pattern = kept("deformations", [*masks, *dofs, *tables], lambda: _pattern(used, dofs, *tables))
        every = [*(each.reshape(-1) for each in found), extended(np.ones(joints))]
        data = (every[0] if len(found) == 1 and not joints else np.concatenate(every))[pattern.taken]
        data *= rows.share[pattern.shares]
        self._fill(pattern, data)
        links = [np.reshape(spring.stiffness, -1)[0] for spring in plan.tree.springs]
        of_members = [k.T.reshape(-1).astype(np.float64, copy=False) for k, _ in each]
        self.springs = np.concatenate([*of_members, np.array(links, np.float64)])[self.acting]

    @cached_property
    def split(self) -> Rows:
        """Deformations by the unknowns in pairs of double numbers."""
        return Rows.of(self.by_unknowns)

    def restricted(self, where: Mask) -> Deformations:
        """Those by some of the unknowns, (n,), and by no right-hand-side parameters."""
        table = self.by_unknowns

        def pattern() -> _Pattern:
            taken = np.flatnonzero(where[table.indices])
            row = np.repeat(np.arange(len(self.acting)), np.diff(table.indptr))[taken]
            acts, spring = np.unique(row, return_inverse=True)
            column = (np.cumsum(where) - 1)[table.indices[taken]]
            size, count = int(where.sum()), len(acts)
            own, back = pattern_by_rows(spring, column, (count, size)), pattern_by_rows(column, spring, (size, count))
            none = np.zeros(0, dtype=np.int64)
            return _Pattern(taken, none, acts, own, pattern_by_rows(none, none, (count, 0)), back)

        found = kept("restricted", (table.indptr, table.indices, where), pattern)
        out, data = object.__new__(Deformations), table.data[found.taken]
        out._fill(found, data)
        out.acting, out.springs = self.acting[found.acting], self.springs[found.acting]
        return out

    def _fill(self, pattern: _Pattern, data: Real) -> None:
        """Matrices of the numbers of a pattern."""
        self.acting = pattern.acting
        self.by_unknowns, self.by_parameters = (
            filled(where, data[order]) for order, where in (pattern.unknowns, pattern.parameters)
        )
        order, where = pattern.back
        self.back = filled(where, data[order].astype(np.float64))

    def stiffness(self) -> scipy.sparse.csr_matrix | None:
        """Stiffness (n, n) of a frame that does not vary, symmetric to the last bit; None where one spring is negative.

        In double precision it serves for a factor, with which solutions are refined.
        """
        if (self.springs < 0.0).any():
            return None
        root, table = np.sqrt(self.springs), self.by_unknowns
        weighted = filled(self.back, self.back.data * root[self.back.indices])
        each = np.repeat(root, np.diff(table.indptr))
        return product(weighted, filled(table, table.data.astype(np.float64) * each))


def _pattern(
    used: Sequence[Mask], dofs: Sequence[Index], start: Index, column: Index, place: Index, counts: Index
) -> _Pattern:
    """The pattern of deformations by the displacements `dofs` (n, 12) of members, `used` (n, springs, 12)."""
    known, displacements, joints = counts.tolist()
    springs, columns, numbers, first, before = [], [], [], 0, 0
    for mask, of in zip(used, dofs, strict=True):
        piece, spring, k = np.nonzero(mask)
        numbers.append(before + np.flatnonzero(mask))
        springs.append(first + spring * len(mask) + piece)
        columns.append(of[piece, k])
        first, before = first + mask.shape[0] * mask.shape[1], before + mask.size
    each = np.arange(joints)
    number, spring, dof = (
        np.concatenate([*some, more + each])
        for some, more in ((numbers, before), (springs, first), (columns, displacements))
    )
    item, at = expanded(start, dof)
    spring = spring[item]
    # known numbers that are not asked for, as for a stiffness, come behind those that are
    where = np.concatenate([place, len(place) + np.arange(known), [-1]])[np.minimum(column[at], len(place) + known)]
    given, own = where >= len(place), (where >= 0) & (where < len(place))
    acts = np.zeros(first + joints, dtype=bool)
    acts[spring[own]] = True
    given &= acts[spring]
    mine, others = np.flatnonzero(own), np.flatnonzero(given)
    spring, size, count = (np.cumsum(acts) - 1)[spring], int((place >= 0).sum()), int(acts.sum())
    matrices = [
        (mine, spring, where, (count, size)),
        (others, spring, where - len(place), (count, known)),
        (mine, where, spring, (size, count)),
    ]
    ordered = [pattern_by_rows(row[some], other[some], shape) for some, row, other, shape in matrices]
    orders = [(some[order], found) for (some, *_), (order, found) in zip(matrices, ordered, strict=True)]
    return _Pattern(number[item], at, np.flatnonzero(acts), orders[0], orders[1], orders[2])


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
        deformed = self.deformations.by_unknowns @ values
        tensions: Real = deformed if isinstance(self.given, float) else deformed + self.given
        if not self.summed_finely:
            tensions = tensions.astype(np.float64)
        by_entry = tensions.reshape(springs, count, cases // max(1, count))
        by_entry *= self.stiffness[:, :, None]
        back = self.deformations.by_unknowns.T if self.summed_finely else self.deformations.back
        left: Array = (self.forces - back @ tensions).astype(np.float64, copy=False)
        return left
