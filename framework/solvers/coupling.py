"""The equations of a batch as sums of terms: which numbers of members, springs and loads add up to which entry.

The displacements of the nodes are ``u = T q + G s`` over the unknowns q and the right-hand-side parameters s, so that
an entry of ``T^T K T`` is a sum of entries of the members' stiffness, each times two factors of T; terms between an
unknown and a right-hand-side parameter are loads. The terms are found once for the batch, by array operations; their
values are computed for some entries at a time, see `evaluation`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import repeat
from operator import or_
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from ..batched.stage import Forces
from ..cache import TERMS
from ..lazily import cached_property
from ..structure.group import Group
from ..structure.parts import Grid, RightHandSideParameters, Value, mask_of, mask_of_shape
from ..structure.topology import Index, Topology
from ..structure.tree import JointTree
from .graph import Graph
from .terms import MOST, Tables, TermPattern, term_pattern, term_weight

Mask = NDArray[np.bool_]
# Deformations are examined for this many batch entries times members at a time.
_LOOKED = 2**15
# Numbers are copied into stacked arrays if they take up to this many bytes.
_STACKED = 2**27
# Weight of a member's deformations in the cache.
_NUMBERS = 72


class Together:
    """Numbers of a batch, those of equal shape stacked in one array, from which entries can be taken at once.

    Parameters
    ----------
    values
        The numbers, each of its own batch shape.

    Attributes
    ----------
    count
        How many numbers there are.
    parts
        For each shape the places of its numbers, (k,), and the array (k, ...); not stacked where the copy would take
        much memory.
    plain
        The numbers, (count,), if none of them varies; else None.
    """

    def __init__(self, values: Sequence[Value]) -> None:
        self.count = len(values)
        self.plain: NDArray[np.float64] | None = None
        self.parts: list[tuple[Index, NDArray[np.float64]]]
        if self.count and {*map(type, values)} == {float}:  # as often
            self.plain = np.array(values)
            self.parts = [(np.arange(self.count), self.plain)]
            return
        shapes = [value.shape if isinstance(value, np.ndarray) else () for value in values]
        apart = 8 * sum(map(math.prod, shapes)) > _STACKED
        places: dict[object, list[int]] = {}
        for place, shape in enumerate(shapes):
            places.setdefault(place if apart else shape, []).append(place)
        self.parts = [
            (np.array(at), np.asarray(values[at[0]])[None] if apart else np.array([values[k] for k in at], np.float64))
            for at in places.values()
        ]


@dataclass(eq=False)
class EvaluatedBlock:
    """Numbers that are evaluated together: the stiffness of a group of n members, the joint springs, or the loads.

    Attributes
    ----------
    first
        Index of the first number of the block among the numbers of all blocks.
    count
        How many numbers the block has.
    group
        The members; None for springs and loads.
    rows
        Deformations (n, s, 12) per unit displacement of the nodes, if they do not vary over the batch: number
        ``n i + piece`` is then the stiffness of spring i of a piece. Else None: number ``n (12 a + b) + piece`` is
        entry (a, b) of the stiffness of a piece.
    values
        Spring stiffnesses or loads; empty for members.
    mask
        Mask of the batch axes over which the numbers vary.
    """

    first: int
    count: int
    group: Group | None
    rows: NDArray[np.float64] | None
    values: Sequence[Value]
    mask: int

    @cached_property
    def together(self) -> Together:
        """The values, stacked by batch shape."""
        return Together(self.values)


class Described(Protocol):
    """The part of a plan that `Coupling` uses."""

    @property
    def topology(self) -> Topology: ...

    @property
    def tree(self) -> JointTree: ...

    @property
    def grid(self) -> Grid: ...

    @property
    def graph(self) -> Graph: ...

    @property
    def forces(self) -> Forces: ...

    @property
    def rhs_parameters(self) -> RightHandSideParameters: ...


class Coupling:
    """The equations of a frame as sums of terms.

    Parameters
    ----------
    plan
        The plan of the frame.
    everywhere
        Whether to look for nonzero numbers at all entries of the batch; False for the first alone, as an estimate.

    Attributes
    ----------
    blocks
        Blocks of the numbers in the terms.
    pattern, factor
        The terms, and the constant factor of each, (terms,).
    transformation
        T and G.
    factors
        Varying factors of T.
    mask
        Mask of the batch axes over which the stiffness varies.
    exact
        Whether the terms are those of all entries, not only of the first.
    """

    def __init__(self, plan: Described, *, everywhere: bool = True) -> None:
        topology, tree, grid = plan.topology, plan.tree, plan.grid
        unknown, forces = plan.graph.unknown, plan.forces  # which add right-hand-side parameters
        self.grid, self.size, self.rhs_parameters = grid, len(unknown), len(plan.rhs_parameters.values)
        self._everywhere, self.exact = everywhere, True
        self.transformation = plan.graph.links.transformation(self.rhs_parameters)
        self.factors = self.transformation.factors
        self.blocks: list[EvaluatedBlock] = []
        members = _members(plan)
        given = repeat(None) if members is None else members.rows
        for group, own in zip(topology.groups, given, strict=members is not None):
            self._of_members(group, own)
        self._block(len(tree.springs), None, None, [spring.stiffness for spring in tree.springs])
        loads = self._of_loads(forces)
        self.pattern: TermPattern
        self.factor: NDArray[np.float64]
        if members is None or members.weight > MOST:
            self.pattern, self.factor = self._terms(plan, loads)
        else:
            key = (*members.key, self.rhs_parameters, loads.tobytes())
            self.pattern, self.factor = TERMS.found(key, lambda: self._terms(plan, loads), members.weight)
        stiff = [block.mask for block in self.blocks[:-1]] + [mask_of(value) for value in self.factors]
        self.mask = reduce(or_, stiff, 0)
        self.imposed = any(k < 0 for rows in tree.rows.values() for row in rows for k in row) or any(
            k < 0 for spring in tree.springs for k in spring.row
        )

    @property
    def label(self) -> Index:
        """Connected component of each unknown, (n,)."""
        return self.pattern.label

    @property
    def loaded(self) -> Mask:
        """Whether a load, an offset or a prescribed displacement acts on the component of each unknown, (n,)."""
        return self.pattern.loaded

    @cached_property
    def masks(self) -> Index:
        """Mask of the batch axes over which the coupling of each unknown varies, (n,)."""
        terms, stiff = self.pattern, self.pattern.stiff
        by_block = np.zeros(len(terms.source), dtype=np.int64)
        for block in self.blocks[:-1]:
            by_block[(terms.source >= block.first) & (terms.source < block.first + block.count)] = block.mask
        own = np.array([*map(mask_of, self.factors), 0], dtype=np.int64)
        masks = by_block | own[terms.first] | own[terms.second]
        out = np.zeros(self.size, dtype=np.int64)
        for places in (terms.low, terms.high):
            np.bitwise_or.at(out, places[stiff], masks[stiff])
        return out

    # -- blocks and terms ---------------------------------------------------------------------------------------------

    def _of_members(self, group: Group, known: NDArray[np.float64] | None) -> None:
        """Add the block of a group of members, whose deformations may be known."""
        count, rows = len(group.pieces), _deformed(group) if known is None else known
        if rows is None:
            self.exact = self.exact and self._everywhere
        self._block(count * (144 if rows is None else rows.shape[1]), group, rows, [])

    def _terms(self, plan: Described, loads: Index) -> tuple[TermPattern, NDArray[np.float64]]:
        """The terms that are not zero, and their constant factors, (terms,)."""
        topology, rows = plan.topology, self.transformation
        blocks = self.blocks[: len(topology.groups)]
        known = [block.rows for block in blocks if block.rows is not None]
        acting = [self._acting(block) for block in blocks]
        springs = 6 * len(topology.number), len(plan.tree.springs)
        tables = Tables(rows.start, rows.column, rows.varying, self.size)
        pattern = term_pattern(tables, acting, [group.dofs for group in topology.groups], springs, loads)
        found = pattern.factors(known, rows.share)
        used = found != 0.0  # products of tiny factors may underflow to zero
        return (pattern, found) if used.all() else (pattern.at(used), found[used])

    def _acting(self, block: EvaluatedBlock) -> Mask:
        """Mask of the displacements that deform each spring, see `term_pattern`."""
        assert block.group is not None
        acting: Mask = self._used(block.group)[..., None] if block.rows is None else block.rows != 0.0
        return acting

    def _used(self, group: Group) -> Mask:
        """Mask of the entries of each piece's stiffness that are not zero somewhere in the batch, (n, 12, 12)."""
        count, shape = len(group.pieces), group.stiffness_shape
        entries = int(np.prod(shape, dtype=np.int64))
        if not self._everywhere:
            for axis in range(len(shape)):
                group = group.cut(axis, slice(0, 1))
        if count * entries <= _LOOKED or not self._everywhere:
            return _seen(group)
        axis = int(np.argmax(shape))
        step = max(1, _LOOKED * shape[axis] // (count * entries))
        slices = (slice(k, k + step) for k in range(0, shape[axis], step))
        found: Mask = np.logical_or.reduce([_seen(group.cut(axis, indices)) for indices in slices])
        return found

    def _of_loads(self, forces: Forces) -> Index:
        """Displacement on which each load acts, and its right-hand-side parameter, (loads, 2)."""
        given = [
            (dof, source, value)
            for dof, sources in forces.items()
            for source, parts in sources.items()
            for value in parts.values()
        ]
        self._block(len(given), None, None, [value for _, _, value in given])
        return np.array([(dof, source) for dof, source, _ in given], dtype=np.int64).reshape(-1, 2)

    def _block(
        self, count: int, group: Group | None, rows: NDArray[np.float64] | None, values: Sequence[Value]
    ) -> None:
        before = self.blocks[-1].first + self.blocks[-1].count if self.blocks else 0
        shapes = [value.shape for value in values if isinstance(value, np.ndarray)]
        mask = reduce(or_, map(mask_of_shape, shapes if group is None else [group.stiffness_shape]), 0)
        self.blocks.append(EvaluatedBlock(before, count, group, rows, values, mask))


class _Members(NamedTuple):
    """Deformations of members in the cache, for given positions of nodes.

    Attributes
    ----------
    key
        Key of the terms of the frame.
    rows
        Deformations (n, s, 12) of each group.
    weight
        Weight of the terms of the frame.
    """

    key: tuple[object, ...]
    rows: list[NDArray[np.float64]]
    weight: int


def _members(plan: Described) -> _Members | None:
    """Deformations of members that depend on the positions of nodes alone, from the cache; None where they do not."""
    links, topology = plan.graph.links, plan.topology
    if links.key is None or topology.geometry is None or len(topology.ends) > _LOOKED:
        return None
    key = ("members", links.key, topology.geometry)

    def found() -> _Members | None:
        rows = [own for own in map(_deformed, topology.groups) if own is not None]
        weight = sum(term_weight(own != 0.0) for own in rows)
        return _Members(("terms", *key[1:]), rows, weight) if len(rows) == len(topology.groups) else None

    kept: _Members | None = TERMS.found(key, found, _NUMBERS * len(topology.ends))
    return kept


def _deformed(group: Group) -> NDArray[np.float64] | None:
    """Deformations (n, s, 12) per unit displacement of the nodes; None where they vary over the batch."""
    if any(set(each.shape[1:-1]) - {1} for each in (group.chord, *(turn[..., 0] for turn in group.end_axes))):
        return None
    if group.springs is not None:
        return _along(group, group.springs[1])
    if set(group.shape) - {1}:  # one member shows whether they vary; all members at all entries take much memory
        one = group.part(slice(0, 1))
        if set(one.element.springs(one.length)[1].shape[1:-2]) - {1}:
            return None
        for axis in range(group.chord.ndim - 2):
            group = group.cut(axis, slice(0, 1))
    return _along(group, group.element.springs(group.length)[1])


def _along(group: Group, rows: NDArray[np.float64]) -> NDArray[np.float64] | None:
    """Deformations (n, s, 12) in the nodes' axes, from `rows` in local axes; None where they vary over the batch."""
    if set(rows.shape[1:-2]) - {1}:
        return None
    start, end = (turn.reshape(-1, 1, 3, 3) for turn in group.end_axes)
    local = rows.reshape(len(group.pieces), -1, 4, 3)
    rotated = np.concatenate([local[:, :, :2] @ start, local[:, :, 2:] @ end], axis=2)
    return rotated.reshape(*rotated.shape[:2], 12)


def _seen(group: Group) -> Mask:
    stiffness, rows = group.element.springs(group.length)
    acts = _anywhere(stiffness, 1)
    local = _anywhere(rows, 2).astype(np.int64).reshape(len(group.pieces), -1, 4, 3)
    start, end = (_anywhere(turn, 2).astype(np.int64) for turn in group.end_axes)
    rotated = np.stack([local[:, :, k] @ (start if k < 2 else end) for k in range(4)], axis=2)
    deforms = (rotated.reshape(*rotated.shape[:2], 12) > 0) & acts[..., None]
    each = deforms.astype(np.int64)
    found: Mask = np.swapaxes(each, -1, -2) @ each > 0
    return found


def _anywhere(array: NDArray[np.float64], trailing: int) -> Mask:
    """Whether numbers (n, ..., *trailing) are not zero at some batch entry, (n, *trailing)."""
    axes = tuple(range(1, array.ndim - trailing))
    found: Mask = (array != 0.0).any(axis=axes)
    return found
