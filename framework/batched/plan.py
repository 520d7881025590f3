"""What depends on the description alone: numbers, joint coordinates, connected components, elimination orders."""

from __future__ import annotations

import copy
import functools
import operator
from collections.abc import Callable, Iterable
from functools import cached_property

import numpy as np

from ..cache import ORDERS, Bounded
from ..clock import timed
from ..description import Description
from ..solvers.graph import Graph
from ..solvers.method import Method
from ..structure.assembly import force_entries
from ..structure.parts import Grid, Parts, Row, Value, unknowns
from ..structure.topology import Group, Index
from ..structure.tree import Tree
from ..structure.varying import Varying
from .block import Block
from .condensation import Chain, Condensation, chains, loaded
from .order import Order, Pattern, link, order
from .progress import Springs
from .stage import Forces, Matrix
from .unloaded import Chained, Unloaded

# Sets of chains, which differ by the nodes that loads are on, of which plans of one frame share the stiffness.
_CHAINED = 2


class Plan:
    """A frame compiled: which unknowns there are, how they are coupled, which of them a load can reach.

    Parameters
    ----------
    frame
        The description.
    cut
        Whether members are cut into their segments: for inertia and buckling, not for statics.
    method
        The way in which it is to be solved, see `linkframe.framework.solvers.method`; the plan chooses where None.
    """

    def __init__(self, frame: Description, *, cut: bool = False, method: str | None = None) -> None:
        times: dict[str, float] = {}
        with timed(times, "numbering"):
            unloaded = Unloaded(frame, cut=cut, method=method)
        self._chained: Bounded[tuple[object, ...], Chained] = Bounded(_CHAINED)
        self._of(frame, unloaded, times, again=False)

    def _of(self, frame: Description, unloaded: Unloaded, times: dict[str, float], *, again: bool) -> None:
        self.frame, self.unloaded, self.times, self.again = frame, unloaded, times, again
        self.topology = unloaded.topology.loaded(frame)
        self.knowns = unloaded.knowns.copy()
        self._blocks: dict[int, Block] = {}

    def reloaded(self, frame: Description) -> Plan:
        """The plan of a frame that differs from this one in its loads alone: numbers, matrix and orders are shared."""
        twin = object.__new__(Plan)
        twin._chained = self._chained
        twin._of(frame, self.unloaded, {}, again=self.again or "solution" in self.times)
        return twin

    def _exciting(self, components: set[int]) -> Plan:
        """This plan with `components` for those that are loaded."""
        twin = copy.copy(self)
        twin.excited = components
        return twin

    # -- without the loads ------------------------------------------------------------------------------------------

    @property
    def asked(self) -> str | None:
        """The method that was asked for."""
        return self.unloaded.asked

    @property
    def grid(self) -> Grid:
        """The batch."""
        return self.unloaded.grid

    @property
    def tree(self) -> Tree:
        """What each node's displacement is made of."""
        return self.unloaded.tree

    @property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        return self.unloaded.constant

    @property
    def large(self) -> bool:
        """Whether this is one large frame, whose stiffness does not vary over the batch: a sparse way is faster."""
        return self.unloaded.large

    @property
    def graph(self) -> Graph:
        """Nodes and their coupling, for the sparse ways."""
        return self.unloaded.graph

    @property
    def method(self) -> Method:
        """The way in which this plan is solved, and why."""
        return self.unloaded.method

    @property
    def unknowns(self) -> list[int]:
        """All unknowns: displacements of free nodes, joint-relative coordinates of the others."""
        return self.unloaded.unknowns

    @property
    def islands(self) -> Index:
        """By node the part of the frame that it is in; members, joints and ties connect, supports do not, (nodes,)."""
        return self.unloaded.islands

    def varies(self, group: Group) -> bool:
        """Whether the stiffness of members varies over so much of the batch that it is left to the chunks."""
        return self.unloaded.varies(group)

    @cached_property
    def varying(self) -> Varying:
        """Members whose stiffness is left to the chunks."""
        with timed(self.times, "pattern"):
            return self.unloaded.varying

    # -- condensed --------------------------------------------------------------------------------------------------

    @cached_property
    def chained(self) -> Chained:
        """The stiffness, with members in line condensed that no load is on."""
        found = chains(self.topology, self.tree.rows.keys() | loaded(self.topology))
        key = tuple(tuple(part) for chain in found for part in chain)
        return self._chained.found(key, lambda: Chained(self.unloaded, found))

    @property
    def chains(self) -> list[Chain]:
        """Members in line, between nodes that nothing but these is on."""
        return self.chained.chains

    @property
    def condensed(self) -> Condensation:
        """Chains of members as one stiffness each."""
        return self.chained.condensed

    @cached_property
    def matrix(self) -> Matrix:
        """Parts of the stiffness of members and chains by pair of DOFs, in the nodes' axes."""
        self.varying  # noqa: B018  # which has a time of its own
        with timed(self.times, "assembly"):
            return self.chained.matrix

    def scale(self, dof: int) -> Parts:
        """Parts of the stiffness whose rounding the diagonal of the matrix carries."""
        return self.chained.scale(dof)

    def retained(self, row: Row) -> Row:
        """`row` without the unknowns inside chains: over those of their ends."""
        return self.chained.retained(row)

    @property
    def component(self) -> dict[int, int]:
        """Connected component of every unknown, named by one of its unknowns."""
        return self.chained.component

    # -- loaded -----------------------------------------------------------------------------------------------------

    @cached_property
    def forces(self) -> Forces:
        """Parts of the loads by DOF and known number, in the nodes' axes."""
        with timed(self.times, "assembly"):
            return force_entries(self.topology, self.knowns)

    @cached_property
    def excited(self) -> set[int]:
        """Components that a load, an offset or a prescribed displacement reaches."""
        pushed = set(self.forces)
        rows = {6 * n + k: row for n, six in self.tree.rows.items() for k, row in enumerate(six)}
        moved = [dof for dof, row in rows.items() if min(row, default=0) < 0]
        if moved:
            near = self.chained.neighbours
            pushed |= set(near[np.isin(near[:, 1], moved), 0].tolist())
        reached = {k for dof in pushed for k in self._coupled(dof)}
        reached |= {k for spring in self.tree.springs if min(spring.row, default=0) < 0 for k in unknowns(spring.row)}
        return {self.component[k] for k in reached}

    def part(self, node: int) -> Plan:
        """The plan of that part of the frame alone which a node is in; this one where loads reach no other."""
        if len(self.excited) < 2:
            return self
        inside = {name for name in self.excited if self.islands[name // 6] == self.islands[node]}
        return self if len(inside) == len(self.excited) else self._exciting(inside)

    def reaching(self, unknowns: Iterable[int]) -> Plan:
        """This plan where what these unknowns are coupled with counts as loaded, too; itself where it is."""
        inside = self.excited | {self.component[k] for k in unknowns}
        return self if len(inside) == len(self.excited) else self._exciting(inside)

    def members_of(self, component: int) -> set[int]:
        """Unknowns of a component."""
        return set(self.chained.members[component])

    @property
    def components(self) -> set[int]:
        """Names of all components."""
        return set(self.chained.members)

    def block(self, component: int) -> Block:
        """A component assembled, with its elimination orders."""
        if component not in self._blocks:
            with timed(self.times, "elimination order"):
                self._blocks[component] = self._assembled(component)
        return self._blocks[component]

    def _coupled(self, dof: int) -> list[int]:
        """Unknowns in a nodal displacement."""
        node, k = divmod(dof, 6)
        return unknowns(self.tree.row(node, k))

    def _assembled(self, component: int) -> Block:
        unknown = {k for k in self.members_of(component) if k // 6 not in self.condensed.nodes}
        rows = {6 * node + k: row for node, rows in self.tree.rows.items() for k, row in enumerate(rows) if row}
        ends = {a: row for a, row in rows.items() if any(self.component[k] == component for k in unknowns(row)[:1])}
        inner = sorted(k for k in unknown if k // 6 not in self.tree.rows)
        own = set(inner) | set(ends)
        ends |= {b: rows[b] for a in own for b in self.matrix.get(a, {}) if b not in own and b in rows}
        held = own | set(ends)
        matrix = {a: {b: parts for b, parts in self.matrix.get(a, {}).items() if b in held} for a in own}
        for a in own:
            matrix[a].setdefault(a, {})
        for b in set(ends) - own:
            matrix[b] = {a: matrix[a][b] for a in own if b in matrix[a]} | {b: {}}
        springs = [
            (s.row, s.stiffness)
            for s in self.tree.springs
            if any(self.component[k] == component for k in unknowns(s.row)[:1])
        ]
        forces = {a: self.forces[a] for a in own if a in self.forces}
        varying = self.varying.within(own, held)
        pattern: Pattern = {}
        for a, row in matrix.items():
            for b, parts in row.items():
                if parts or (a == b and a not in ends):
                    link(pattern, a, b, _union(parts))
        for entry in varying.entries if varying else ():
            link(pattern, *entry.at, entry.mask)
        orders = _orders(self.grid, pattern, inner, ends, springs, unknown)
        scale = {a: self.scale(a) if a in own else {} for a in matrix}
        return Block(self.grid, orders, matrix, scale, forces, ends, springs, self.knowns.values, varying)


def _orders(
    grid: Grid, pattern: Pattern, inner: list[int], rows: dict[int, Row], springs: Springs, unknown: set[int]
) -> tuple[Order, Order]:
    """Orders of both stages of an elimination; frames of one topology have them in common."""
    mask = grid.mask
    left = sorted(unknown.difference(inner))
    ends = {a: _masks(row, mask) for a, row in rows.items()}
    sprung = [(_masks(row, mask), mask(stiffness)) for row, stiffness in springs]
    key = (
        grid.shape,
        tuple((a, tuple(row.items())) for a, row in pattern.items()),
        tuple(inner),
        tuple(left),
        tuple((a, tuple(row.items())) for a, row in ends.items()),
        tuple((tuple(row.items()), over) for row, over in sprung),
    )

    def ordered() -> tuple[Order, Order]:
        first = order(pattern, inner, grid)
        reduced: Pattern = {k: {k: 0} for k in left}
        for a, coupled in pattern.items():
            for b, over in coupled.items():
                _link_rows(reduced, ends[a], ends[b], over)
        for spring, over in sprung:
            _link_rows(reduced, spring, spring, over)
        return first, order(reduced, list(reduced), grid)

    found: tuple[Order, Order] = ORDERS.found(key, ordered, sum(map(len, pattern.values())))
    return found


def _masks(row: Row, mask: Callable[[Value], int]) -> dict[int, int]:
    return {k: mask(row[k]) for k in unknowns(row)}


def _link_rows(pattern: Pattern, left: dict[int, int], right: dict[int, int], over: int) -> None:
    for i, first in left.items():
        for j, second in right.items():
            link(pattern, i, j, over | first | second)


def _union(parts: Parts) -> int:
    return functools.reduce(operator.or_, parts, 0)
