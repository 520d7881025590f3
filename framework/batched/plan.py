"""What depends on the description alone: numbers, joint coordinates, connected components, elimination orders."""

from __future__ import annotations

import copy
import functools
import operator
from collections.abc import Callable, Iterable
from functools import cached_property
from typing import Any

import numpy as np
from scipy.sparse import csr_matrix
from scipy.sparse.csgraph import connected_components

from ..clock import timed
from ..description import Description
from ..solvers.graph import Graph
from ..solvers.method import LARGE, Method, choose
from ..structure.assembly import force_entries, stiffness_entries
from ..structure.edge import GROUND
from ..structure.parts import Grid, Knowns, Parts, Row, Value, add, unknowns
from ..structure.topology import Group, Index, Topology
from ..structure.tree import JointTree
from ..structure.varying import Varying
from .block import Block, BlockFactor
from .chunks import large_masks
from .condensation import Chain, Condensation, chains, loaded, retained
from .order import Order, Pattern, link, order
from .progress import Springs
from .stage import Forces, Matrix


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
        self.frame = frame
        self.asked = method
        self.times: dict[str, float] = {}
        self.grid = Grid(frame.shape)
        self.knowns = Knowns(self.grid, _geometry(frame))
        with timed(self.times, "numbering"):
            self.topology = Topology.of(frame, cut=cut)
            self.tree = JointTree.of(self.topology, self.knowns)
        self._given = len(self.knowns.values)
        self._blocks: dict[int, Block] = {}
        self._orders_of: dict[int, tuple[Order, Order]] = {}
        self.solver: Any = None
        self.factors: dict[int, BlockFactor] = {}
        self._parts: dict[int, Plan] = {}
        self.again = False

    def __getstate__(self) -> dict[str, object]:
        """What a copy or another process needs; it factorises again."""
        return {**vars(self), "factors": {}, "_parts": {}}

    def reloaded(self, frame: Description) -> Plan:
        """This plan for a frame that differs in its loads alone: numbers, matrix, orders and factors are shared."""
        twin = copy.copy(self)
        twin.frame, twin.times, twin._blocks, twin.factors = frame, {}, {}, dict(self.factors)
        twin._parts = {}
        twin.again = self.again or "solution" in self.times
        twin.knowns = Knowns(self.grid, self.knowns.geometry, self.knowns.values[: self._given])
        twin.topology = copy.copy(self.topology)
        object.__setattr__(twin.topology, "frame", frame)
        twin._forget("forces", "excited", "chains")
        if "chains" in vars(self) and twin.chains != self.chains:
            twin._orders_of, twin.factors = {}, {}
            twin._forget("condensed", "matrix")
        twin.solver = self.solver.reloaded(twin) if hasattr(self.solver, "reloaded") else None
        return twin

    @cached_property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        tree = self.tree
        numbers = [row[k] for rows in tree.rows.values() for row in rows for k in unknowns(row)]
        numbers += [v for s in tree.springs for v in (s.stiffness, *(s.row[k] for k in unknowns(s.row)))]
        same = all(set(group.stiffness_shape) <= {1} for group in self.topology.groups)
        return same and all(isinstance(v, float) for v in numbers)

    @property
    def large(self) -> bool:
        """Whether this is one large frame, whose stiffness does not vary over the batch: a sparse way is faster."""
        return len(self.unknowns) > LARGE and self.constant

    @cached_property
    def graph(self) -> Graph:
        """Nodes and their coupling, for the sparse ways."""
        return Graph(self.topology, self.tree, self.unknowns)

    @cached_property
    def method(self) -> Method:
        """The way in which this plan is solved, and why."""
        return choose(self, self.asked)

    @cached_property
    def chains(self) -> list[Chain]:
        """Members in line, between nodes that nothing but these is on."""
        return chains(self.topology, self.tree.rows.keys() | loaded(self.topology))

    @cached_property
    def condensed(self) -> Condensation:
        """Chains of members as one stiffness each."""
        return Condensation(self.topology, self.chains)

    @cached_property
    def varying(self) -> Varying:
        """Members whose stiffness is left to the chunks."""
        groups = [group for group in self.topology.groups if self.varies(group)]
        with timed(self.times, "pattern"):
            return Varying.of(groups, self.grid)

    @cached_property
    def matrix(self) -> Matrix:
        """Parts of the stiffness of members and chains by pair of DOFs, in the nodes' axes."""
        varying = self.varying
        groups = [group for group in self.topology.groups if not self.varies(group)]
        with timed(self.times, "assembly"):
            return stiffness_entries(groups, self.grid, self.condensed, varying)

    def scale(self, dof: int) -> Parts:
        """Parts of the stiffness whose rounding the diagonal of the matrix carries."""
        out = dict(self.matrix.get(dof, {}).get(dof, {}))
        if dof in self.condensed.excess:
            add(out, 0, self.condensed.excess[dof])
        return out

    def retained(self, row: Row) -> Row:
        """`row` without the unknowns inside chains: over those of their ends."""
        return retained(row, self.condensed, self.tree.rows)

    @cached_property
    def forces(self) -> Forces:
        """Parts of the loads by DOF and known number, in the nodes' axes."""
        with timed(self.times, "assembly"):
            return force_entries(self.topology, self.knowns)

    @cached_property
    def unknowns(self) -> list[int]:
        """All unknowns: displacements of free nodes, joint-relative coordinates of the others."""
        on_edges = {k for rows in self.tree.rows.values() for row in rows for k in unknowns(row)}
        on_edges |= {k for spring in self.tree.springs for k in unknowns(spring.row)}
        free = np.setdiff1d(np.arange(len(self.topology.number)), list(self.tree.rows))
        own = (6 * free[:, None] + np.arange(6)).astype(np.int64)
        found: list[int] = np.union1d(own, np.array(sorted(on_edges), dtype=np.int64)).tolist()
        return found

    @cached_property
    def component(self) -> dict[int, int]:
        """Connected component of every unknown, named by one of its unknowns."""
        first = np.arange(6 * len(self.topology.number))
        for node, rows in self.tree.rows.items():
            first[6 * node : 6 * node + 6] = [next(iter(unknowns(row)), -1) for row in rows]
        in_dofs = first[self._neighbours]
        coupled = [unknowns(row) for rows in self.tree.rows.values() for row in rows]
        coupled += [unknowns(spring.row) for spring in self.tree.springs]
        both = np.array([(keys[0], k) for keys in coupled for k in keys[1:]], dtype=np.int64).reshape(-1, 2)
        both = np.concatenate([in_dofs[(in_dofs >= 0).all(axis=1)], both])
        pairs = np.searchsorted(self.unknowns, both).T
        size = len(self.unknowns)
        graph = csr_matrix((np.ones(pairs.shape[1], dtype=bool), (pairs[0], pairs[1])), shape=(size, size))
        _, label = connected_components(graph, directed=False)
        first = np.unique(label, return_index=True)[1]
        return {k: self.unknowns[leader] for k, leader in zip(self.unknowns, first[label].tolist(), strict=True)}

    @property
    def _neighbours(self) -> Index:
        """Pairs of DOF numbers that members couple, (pairs, 2)."""
        pairs = [(a, b) for a, row in self.matrix.items() for b in row]
        return np.concatenate([np.array(pairs, dtype=np.int64).reshape(-1, 2), self.condensed.coupled])

    @cached_property
    def excited(self) -> set[int]:
        """Components that a load, an offset or a prescribed displacement reaches."""
        pushed = set(self.forces)
        rows = {6 * n + k: row for n, six in self.tree.rows.items() for k, row in enumerate(six)}
        moved = [dof for dof, row in rows.items() if min(row, default=0) < 0]
        if moved:
            near = self._neighbours
            pushed |= set(near[np.isin(near[:, 1], moved), 0].tolist())
        reached = {k for dof in pushed for k in self._coupled(dof)}
        reached |= {k for spring in self.tree.springs if min(spring.row, default=0) < 0 for k in unknowns(spring.row)}
        return {self.component[k] for k in reached}

    @cached_property
    def islands(self) -> Index:
        """By node the part of the frame that it is in; members, joints and ties connect, supports do not, (nodes,)."""
        joined = [(edge.first, edge.second) for edge in self.tree.edges if edge.first != GROUND]
        first, second = np.concatenate([self.topology.ends, np.array(joined, dtype=np.int64).reshape(-1, 2)]).T
        size = len(self.topology.number)
        graph = csr_matrix((np.ones(len(first), dtype=bool), (first, second)), shape=(size, size))
        return connected_components(graph, directed=False)[1].astype(np.int64)

    def part(self, node: int) -> Plan:
        """The plan of that part of the frame alone which a node is in; this one where loads reach no other."""
        if len(self.excited) < 2:
            return self
        island = int(self.islands[node])
        if island not in self._parts:
            inside = {name for name in self.excited if self.islands[name // 6] == island}
            if len(inside) == len(self.excited):
                return self
            twin = self._parts[island] = copy.copy(self)
            twin.factors = self.factors
            vars(twin)["excited"] = inside
        return self._parts[island]

    def reaching(self, unknowns: Iterable[int]) -> Plan:
        """This plan where what these unknowns are coupled with counts as loaded, too; itself where it is."""
        inside = self.excited | {self.component[k] for k in unknowns}
        if len(inside) == len(self.excited):
            return self
        twin = copy.copy(self)
        twin.factors, twin._parts = self.factors, {}
        vars(twin)["excited"] = inside
        return twin

    def members_of(self, component: int) -> set[int]:
        """Unknowns of a component."""
        return {k for k, name in self.component.items() if name == component}

    @property
    def components(self) -> set[int]:
        """Names of all components."""
        return set(self.component.values())

    def block(self, component: int) -> Block:
        """A component assembled, with its elimination orders."""
        if component not in self._blocks:
            with timed(self.times, "elimination order"):
                self._blocks[component] = self._assembled(component)
        return self._blocks[component]

    def varies(self, group: Group) -> bool:
        """Whether the stiffness of members varies over so much of the batch that it is left to the chunks."""
        shape = group.stiffness_shape
        return large_masks(self.grid)[sum(1 << axis for axis, n in enumerate(shape) if n > 1)]

    def _forget(self, *names: str) -> None:
        for name in names:
            vars(self).pop(name, None)

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
        if component not in self._orders_of:
            pattern: Pattern = {}
            for a, row in matrix.items():
                for b, parts in row.items():
                    if parts or (a == b and a not in ends):
                        link(pattern, a, b, _union(parts))
            for entry in varying.entries if varying else ():
                link(pattern, *entry.at, entry.mask)
            self._orders_of[component] = self._orders(pattern, inner, ends, springs, unknown)
        orders = self._orders_of[component]
        scale = {a: self.scale(a) if a in own else {} for a in matrix}
        return Block(self.grid, orders, matrix, scale, forces, ends, springs, self.knowns.values, varying)

    def _orders(
        self, pattern: Pattern, inner: list[int], rows: dict[int, Row], springs: Springs, unknown: set[int]
    ) -> tuple[Order, Order]:
        mask = self.grid.mask
        first = order(pattern, inner, self.grid)
        reduced: Pattern = {k: {k: 0} for k in unknown.difference(inner)}
        for a, coupled in pattern.items():
            for b, over in coupled.items():
                _link_rows(reduced, _masks(rows[a], mask), _masks(rows[b], mask), over)
        for spring, stiffness in springs:
            _link_rows(reduced, _masks(spring, mask), _masks(spring, mask), mask(stiffness))
        return first, order(reduced, list(reduced), self.grid)


def _masks(row: Row, mask: Callable[[Value], int]) -> dict[int, int]:
    return {k: mask(row[k]) for k in unknowns(row)}


def _link_rows(pattern: Pattern, left: dict[int, int], right: dict[int, int], over: int) -> None:
    for i, first in left.items():
        for j, second in right.items():
            link(pattern, i, j, over | first | second)


def _union(parts: Parts) -> int:
    return functools.reduce(operator.or_, parts, 0)


def _geometry(frame: Description) -> int:
    """Mask of the axes over which positions vary."""
    shapes = [node.coordinates.shape[:-1] for node in frame.nodes.values()]
    shapes += [body.origin.shape[:-1] for body in frame.bodies.values()]
    shapes += [body.axes.shape[:-2] for body in frame.bodies.values()]
    joint = np.broadcast_shapes(*shapes)
    sizes = (1,) * (len(frame.shape) - len(joint)) + joint
    return sum(1 << axis for axis, n in enumerate(sizes) if n > 1)
