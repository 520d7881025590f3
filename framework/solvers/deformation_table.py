"""Deformations of members and joints per unit of the unknowns, as sparse matrices, if they are the same for a batch.

They depend on positions and connections of the nodes. Where the elements' own numbers have no effect on them, they are
cached for the next frame with the same nodes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array, any_of
from ..batched.plan import Plan
from ..batched.unloaded import Unloaded
from ..cache import TERMS
from ..error_bounds.deformations import constant_springs
from ..error_bounds.kinematic_edge import Real, extended
from ..lazily import cached_property
from ..program.pair_code import Rows
from ..structure.topology import Index
from .evaluation import Picked
from .patterns import MANY, ProductPattern, filled, kept, pattern_by_rows, product_pattern
from .transformation import Transformation, expanded

Mask = NDArray[np.bool_]
# Weight of an entry in the cache, including those for subsets of unknowns, and in the pattern of the stiffness; and the
# number of subsets that are kept.
_EACH, _PRODUCTS, _FEW = 16, 32, 4
# Frames with more members than this are not cached.
_MOST = 2**12


@dataclass(frozen=True)
class _Pattern:
    """The sparsity patterns of `Deformations`, which frames of one topology share.

    Attributes
    ----------
    taken, shares
        For each term the index of its deformation per displacement, and of its factor in `Transformation.share`.
    acting
        Numbers of the springs that the unknowns deform.
    unknowns, parameters, back
        For each matrix the order of the terms in it, and a matrix of its pattern.
    """

    taken: Index
    shares: Index
    acting: Index
    unknowns: tuple[Index, scipy.sparse.csr_matrix]
    parameters: tuple[Index, scipy.sparse.csr_matrix]
    back: tuple[Index, scipy.sparse.csr_matrix]


class _Table:
    """Deformations of springs per unknown and right-hand-side parameter, without the stiffness of the springs.

    Attributes
    ----------
    acting, by_unknowns, by_parameters, back
        As of `Deformations`.
    lengths
        Lengths of the members of each group.
    """

    def __init__(self, pattern: _Pattern, data: Real, lengths: Sequence[Array] = ()) -> None:
        self.acting, self.lengths = pattern.acting, lengths
        self.by_unknowns, self.by_parameters = (
            filled(where, data[order]) for order, where in (pattern.unknowns, pattern.parameters)
        )
        order, where = pattern.back
        self.back = filled(where, data[order].astype(np.float64))
        self._some: dict[bytes, tuple[_Table, Index]] = {}

    @cached_property
    def rounded(self) -> scipy.sparse.csr_matrix:
        """Deformations per unknown in double precision, (springs, unknowns)."""
        return filled(self.by_unknowns, self.by_unknowns.data.astype(np.float64))

    @cached_property
    def row(self) -> Index:
        """Index of the spring of each entry of `by_unknowns`."""
        return np.repeat(np.arange(len(self.acting)), np.diff(self.by_unknowns.indptr))

    @cached_property
    def product(self) -> tuple[ProductPattern, scipy.sparse.csr_matrix] | None:
        """Pattern of the stiffness, and the contribution of each spring to its entries; None if it is too large."""
        pattern = product_pattern(self.back, self.rounded)
        return None if pattern is None else (pattern, pattern.shares(self.back.data, self.rounded.data))

    @cached_property
    def split(self) -> Rows:
        """Deformations per unknown in double-double precision."""
        return Rows.of(self.by_unknowns)

    def restricted(self, where: Mask) -> tuple[_Table, Index]:
        """Deformations per unknown in `where` (n,), without right-hand-side parameters; and the springs that deform."""
        key = where.tobytes()
        found = self._some.get(key)
        if found is None:
            found = self._of(where)
            if len(self._some) >= _FEW:
                self._some.clear()
            self._some[key] = found
        return found

    def _of(self, where: Mask) -> tuple[_Table, Index]:
        table = self.by_unknowns

        def pattern() -> _Pattern:
            taken = np.flatnonzero(where[table.indices])
            acts, spring = np.unique(self.row[taken], return_inverse=True)
            column = (np.cumsum(where) - 1)[table.indices[taken]]
            size, count = int(where.sum()), len(acts)
            own, back = pattern_by_rows(spring, column, (count, size)), pattern_by_rows(column, spring, (size, count))
            none = np.zeros(0, dtype=np.int64)
            return _Pattern(taken, none, acts, own, pattern_by_rows(none, none, (count, 0)), back)

        found = kept("restricted", (table.indptr, table.indices, where), pattern)
        out = _Table(found, table.data[found.taken])
        out.acting = self.acting[found.acting]
        return out, found.acting


class Deformations:
    """Deformations of all springs per unit of the unknowns and right-hand-side parameters, constant over the batch.

    Spring i of a piece has the number ``n i + piece`` within its group of n members; the groups follow each other, and
    the springs of joints come last.

    Parameters
    ----------
    plan
        The plan of the frame, see `are_described`.
    rows
        Displacements of nodes and springs over the unknowns.
    place
        Place of each unknown among those that are solved for, (n,); -1 for others.

    Attributes
    ----------
    acting
        Numbers of the springs that these unknowns deform.
    by_unknowns, by_parameters
        Deformations of these springs per unknown and per right-hand-side parameter, (springs, unknowns or parameters).
    back
        `by_unknowns` transposed, in double precision.
    """

    def __init__(self, plan: Plan | Unloaded, rows: Transformation, place: Index) -> None:
        links, geometry = plan.graph.links, plan.topology.geometry
        self._plan: Plan | Unloaded | None = plan
        if links.key is None or geometry is None or len(plan.topology.ends) > _MOST:
            table, stiffness = _found(plan, rows, place)
            self._take(table)
            self.springs = stiffness[self.acting]
            return
        found: list[Array] = []

        def made() -> _Table:
            table, stiffness = _found(plan, rows, place)
            found.append(stiffness)
            return table

        key = ("deformations", links.key, geometry, rows.known, place.tobytes())
        self._take(TERMS.found(key, made, _weight))
        if found:  # on the way, as it would be found later
            self.springs = found[0][self.acting]

    def _take(self, table: _Table) -> None:
        self._table, self.acting = table, table.acting
        self.by_unknowns, self.by_parameters, self.back = table.by_unknowns, table.by_parameters, table.back

    @cached_property
    def springs(self) -> Array:
        """Stiffness of these springs at the first entry of the batch, (springs,)."""
        assert self._plan is not None  # a frame of members alone, whose deformations came from the cache
        stiffness, first = [], _first(self._plan)
        for group, length in zip(self._plan.topology.groups, self._table.lengths, strict=True):
            found = first.of_element(group).spring_stiffness(length)
            found = found.reshape(-1, found.shape[-1])
            if len(found) != len(length):
                found = np.broadcast_to(found, (len(length), found.shape[-1]))
            stiffness.append(found.T.reshape(-1))
        whole = stiffness[0] if len(stiffness) == 1 else np.concatenate([np.zeros(0), *stiffness])
        springs: Array = whole[self.acting]
        return springs

    @property
    def split(self) -> Rows:
        """Deformations per unknown in double-double precision."""
        return self._table.split

    def restricted(self, where: Mask) -> Deformations:
        """Deformations per unknown in `where`, a mask (n,), without right-hand-side parameters."""
        out = object.__new__(Deformations)
        table, acting = self._table.restricted(where)
        out._plan = None
        out._take(table)
        out.springs = self.springs[acting]
        return out

    def stiffness(self) -> scipy.sparse.csr_matrix | None:
        """Stiffness (n, n) of a constant frame, symmetric to the last bit; None if a spring stiffness is negative.

        It is in double precision, for a factor with which solutions are refined.
        """
        if any_of(self.springs < 0.0):
            return None
        if (product := self._table.product) is not None:
            pattern, shares = product
            return pattern.of(shares, self.springs)
        root, table = np.sqrt(self.springs), self._table.rounded
        weighted, own = self.back.data * root[self.back.indices], table.data * root[self._table.row]
        return scipy.sparse.csr_matrix(filled(self.back, weighted) @ filled(table, own))


def _weight(table: _Table) -> int:
    """Weight of a table in the cache, with its cached properties."""
    entries = table.by_unknowns.nnz + table.by_parameters.nnz
    return _EACH * entries + min(_PRODUCTS * entries, MANY)


def _first(plan: Plan | Unloaded) -> Picked:
    """The first entry of a batch."""
    return Picked.first(plan.frame.shape)


def _found(plan: Plan | Unloaded, rows: Transformation, place: Index) -> tuple[_Table, Array]:
    """The deformations of a frame, and the stiffness of all its springs at the first entry of the batch."""
    picked, groups = _first(plan), plan.topology.groups
    each = [constant_springs(plan, group, picked.of_element(group)) for group in groups]
    found = [rows for _, _, rows in each]
    used = [each.astype(bool) for each in found]
    dofs, joints = [group.dofs for group in groups], len(plan.tree.springs)
    tables = [rows.start, rows.column, place, np.array([rows.known, 6 * len(plan.topology.number), joints])]
    masks = [np.packbits(each) for each in used]
    pattern = kept("deformations", [*masks, *dofs, *tables], lambda: _pattern(used, dofs, *tables))
    every = [*(each.reshape(-1) for each in found), extended(np.ones(joints))]
    data = (every[0] if len(found) == 1 and not joints else np.concatenate(every))[pattern.taken]
    data *= rows.share[pattern.shares]
    links = [np.reshape(spring.stiffness, -1)[0] for spring in plan.tree.springs]
    of_members = [k.T.reshape(-1).astype(np.float64, copy=False) for _, k, _ in each]
    stiffness = np.concatenate([*of_members, np.array(links, np.float64)])
    return _Table(pattern, data, [length.astype(np.float64) for length, _, _ in each]), stiffness


def _pattern(
    used: Sequence[Mask], dofs: Sequence[Index], start: Index, column: Index, place: Index, counts: Index
) -> _Pattern:
    """The pattern, given masks `used` (n, springs, 12) of nonzero deformations and DOF numbers `dofs` (n, 12)."""
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
    # right-hand-side parameters that are not needed, as for a stiffness, come after those that are
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
