"""The part of a plan that does not depend on the loads and is shared by all load cases."""

from __future__ import annotations

import math
from collections.abc import Collection
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from ..cache import PATTERNS, PROGRAMS
from ..description import Description
from ..lazily import cached_property
from ..solvers.graph import Graph, Links
from ..solvers.method import BROADCAST, LARGE
from ..structure.assembly import stiffness_entries
from ..structure.connections import of_supports
from ..structure.disjoint_sets import least_of_sets
from ..structure.own_trees import joint_tree
from ..structure.parts import Grid, Matrix, Parts, RightHandSideParameters, Row, add, mask_of_shape, unknowns
from ..structure.topology import Group, Index, Topology
from ..structure.tree import JointTree
from ..structure.varying import Varying
from .batch_numbers import FEW, MEDIUM, BatchNumbers, Met
from .block import Block
from .chunks import large_masks
from .condensation import Chain, Condensation
from .one_entry import EntryLinks, EntryNumbers, forest
from .order import Masks, link, pattern_of, two_stages

# Up to this many unknowns connected components are found without sparse matrices.
_FEW = 200
# Weight of a node or member in the cache of connections.
_NUMBERS = 64
# Largest weight that is cached.
_HEAVY = 2**19
# Number of sets of condensed chains for which the entries of the stiffness are kept.
_MATRICES = 2


class Unloaded:
    """A frame without its loads: its unknowns, how they are coupled, and its stiffness.

    Parameters
    ----------
    frame
        The description.
    cut
        Whether members are divided into their segments.
    method
        Name of the method that the user asked for; None to choose by expected time.
    former
        What is known of an earlier frame whose members, not divided, connect the same nodes; None for nothing.
    apart
        Whether each offset that varies is a right-hand-side parameter of its own, even if the geometry varies as well.
    """

    def __init__(
        self,
        frame: Description,
        *,
        cut: bool,
        method: str | None,
        former: Former | None = None,
        apart: bool = False,
    ) -> None:
        self.frame, self.asked = frame, method
        self.grid = Grid(frame.shape)
        self.topology = _topology(frame, cut=cut, former=former)
        self.rhs_parameters = RightHandSideParameters(self.grid, 0 if apart else _geometry(self.topology))
        self._stacks = _stacks(self.topology, former)
        if former is not None and not (cut or former.moved or former.elements):
            self._take_over(former.unloaded)
        numbered = former is not None and self.topology.number is former.unloaded.topology.number
        linked = former.unloaded if former is not None and former.linked and numbered else None
        self._links = None if linked is None else linked.known_links
        short = not frame.shape or 1 < self.grid.sizes[-1] <= MEDIUM
        self._plain = short and not (cut or apart) and frame.absent is None and method in (None, BROADCAST)
        self._met = self._alike() if self._plain and frame.shape else Met()
        if frame.shape:  # numbers of batches are gathered only if a program is likely
            self._plain = self._plain and self._met.count > max(FEW, self._met.least) and not self._met.without
        joined = bool(frame.joints or frame.ties)
        self._forest: bool = self._plain and (not joined or (forest(frame) if linked is None else linked._forest))
        if not self._forest:
            self.tree  # noqa: B018  # raises an error now if constraints contradict each other

    @cached_property
    def tree(self) -> JointTree:
        """The joint tree, which expresses each node's displacement in joint-relative coordinates."""
        if self._supports is None:
            known = self.known_links
            return joint_tree(self.topology, self.rhs_parameters, None if known is None else known.order)
        return JointTree.by(self.topology, self.rhs_parameters, self.links.connections)

    def _take_over(self, other: Unloaded) -> None:
        """Share what is known of the stiffness of the same members with other joints or loads."""
        if other.grid.shape == self.grid.shape:
            vars(self).update({name: vars(other)[name] for name in ("matrices", "varying") if name in vars(other)})

    @cached_property
    def matrices(self) -> dict[tuple[object, ...], Matrix]:
        """Entries of the stiffness of members, by the chains of these that are condensed, the last few."""
        return {}

    @cached_property
    def numbers(self) -> EntryNumbers | BatchNumbers | None:
        """The numbers of a frame with a single batch entry or a short batch; None for others, and for a large frame."""
        if not self._plain or (self.frame.shape and not self._forest):
            return None
        frame = self.frame
        coupled = sum(map(len, frame.supports.values())) + 6 * (len(frame.joints) + len(frame.ties))
        if 6 * len(self.topology.number) - coupled > LARGE:
            return None
        if frame.shape:
            return BatchNumbers(self.topology, self.grid, self._met, self.rhs_parameters.geometry)
        return EntryNumbers(self.topology, self._stacks, self._links)

    def _alike(self) -> Met:
        """How often batches like this one were met, this time included."""
        frame, ends = self.frame, self.topology.ends
        counts = len(self.topology.number), len(frame.joints), len(frame.ties), len(frame.supports)
        met: Met = PROGRAMS.found(("met", self.grid.shape, ends.tobytes(), counts, (*frame.loads,)), Met, ends.size)
        met.count += 1
        return met

    @property
    def known_entry(self) -> EntryNumbers | None:
        """The numbers of a frame with a single batch entry, if they are known already; else None."""
        known: object = vars(self).get("numbers")
        return known if isinstance(known, EntryNumbers) else None

    @property
    def known_stacks(self) -> list[NDArray[Any]] | None:
        """Stiffness matrices of the members of a frame with a single batch entry, if computed already; else None."""
        known = self.known_entry
        return self._stacks if known is None else known.stacks

    @property
    def known_links(self) -> EntryLinks | None:
        """Numbers of the joints, ties and supports of a frame with a single batch entry, if known; else None."""
        known = self.known_entry
        return self._links if known is None else known.links

    @cached_property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        if math.prod(self.grid.shape) == 1:
            return True
        tree = self.tree
        if not all(set(group.stiffness_shape) <= {1} for group in self.topology.groups):
            return False
        rows = [row for rows in tree.rows.values() for row in rows] + [spring.row for spring in tree.springs]
        numbers = [value for row in rows for k, value in row.items() if k >= 0]
        numbers += [spring.stiffness for spring in tree.springs]
        return all(isinstance(v, float) for v in numbers)

    @cached_property
    def graph(self) -> Graph:
        """Graph of the nodes and their coupling, for the sparse methods."""
        return Graph(self.topology, self.links)

    @cached_property
    def varying(self) -> Varying:
        """Members whose stiffness varies so much that each chunk assembles it."""
        large = large_masks(self.grid)
        groups = self.topology.groups if any(large) else []
        return Varying.of([each for each in groups if large[mask_of_shape(each.stiffness_shape)]], self.grid, large)

    @cached_property
    def links(self) -> Links:
        """Unknowns and their coupling; cached for frames without joints and ties that are connected alike."""
        count, ends, key = len(self.topology.number), self.topology.ends, self._supports
        if key is None:
            return Links(count, ends, self.tree.connections)

        def found() -> Links:
            return Links(count, ends, JointTree.of(self.topology, self.rhs_parameters).connections, key)

        links: Links = PATTERNS.found(("links", *key), found, self._weight)
        return links

    @cached_property
    def _supports(self) -> tuple[object, ...] | None:
        """Key of `links` in the cache; None where they are not cached."""
        return of_supports(self.topology) if self._weight <= _HEAVY else None

    @property
    def _weight(self) -> int:
        return _NUMBERS * (len(self.topology.number) + len(self.topology.ends))

    @property
    def connected_components(self) -> Index:
        """Number of the connected part of the frame for each node, (nodes,); supports do not connect."""
        return self.links.components

    def varies(self, group: Group) -> bool:
        """Whether the stiffness of a group of members varies so much that each chunk assembles it."""
        return large_masks(self.grid)[mask_of_shape(group.stiffness_shape)]


class Former(NamedTuple):
    """An earlier frame whose members, not divided, connect the same nodes, and how it differs from the new one.

    Attributes
    ----------
    unloaded
        The earlier frame.
    moved
        Whether the positions of nodes differ.
    elements
        Whether the elements of members differ.
    linked
        Whether joints, ties, supports and bodies are the same.
    """

    unloaded: Unloaded
    moved: bool
    elements: bool
    linked: bool


class Chained:
    """The stiffness of a frame with chains of members condensed.

    Parameters
    ----------
    unloaded
        The frame without its loads.
    chains
        The chains to condense.
    """

    def __init__(self, unloaded: Unloaded, chains: list[Chain]) -> None:
        self.unloaded = unloaded
        self.chains = chains
        self._blocks: dict[int, tuple[Block, set[int]]] = {}
        self.condensed = Condensation(unloaded.topology, chains)

    @cached_property
    def matrix(self) -> Matrix:
        """Parts of the stiffness of members and chains by pair of DOFs, in the nodes' axes."""
        known, key = (
            self.unloaded.matrices,
            (self.unloaded.grid.shape, *[(*p,) for chain in self.chains for p in chain]),
        )
        found = known.get(key)
        if found is None:
            for old in list(known)[: 1 - _MATRICES]:
                known.pop(old, None)
            found = known[key] = self._matrix()
        return found

    def _matrix(self) -> Matrix:
        varying = self.unloaded.varying
        left = {numbers.group for numbers, _ in varying.groups}
        groups = [group for group in self.unloaded.topology.groups if group not in left]
        stacks = self.unloaded.known_stacks
        known = {} if stacks is None else dict(zip(self.unloaded.topology.groups, stacks, strict=True))
        return stiffness_entries(groups, self.unloaded.grid, self.condensed, varying, known)

    def scale(self, dof: int) -> Parts:
        """Parts of the scale of a diagonal entry of the matrix."""
        out = dict(self.matrix.get(dof, {}).get(dof, {}))
        if self.chains and dof in self.condensed.excess:
            add(out, 0, self.condensed.excess[dof])
        return out

    @cached_property
    def component(self) -> dict[int, int]:
        """Connected component of every unknown, identified by the first of its unknowns."""
        tree, names = self.unloaded.tree, self.unloaded.links.unknowns
        if len(names) <= _FEW:
            return self._joined_one_by_one()
        first = np.arange(6 * len(self.unloaded.topology.number))
        for node, rows in tree.rows.items():
            first[6 * node : 6 * node + 6] = [next(iter(unknowns(row)), -1) for row in rows]
        in_dofs = first[self.neighbours]
        coupled = [unknowns(row) for rows in tree.rows.values() for row in rows]
        coupled += [unknowns(spring.row) for spring in tree.springs]
        both = np.array([(keys[0], k) for keys in coupled for k in keys[1:]], dtype=np.int64).reshape(-1, 2)
        both = np.concatenate([in_dofs[(in_dofs >= 0).all(axis=1)], both])
        pairs = np.searchsorted(names, both).T
        size = len(names)
        graph = scipy.sparse.csr_matrix((np.ones(pairs.shape[1], dtype=bool), (pairs[0], pairs[1])), shape=(size, size))
        _, label = scipy.sparse.csgraph.connected_components(graph, directed=False)
        leaders = np.unique(label, return_index=True)[1]
        return {k: names[leader] for k, leader in zip(names, leaders[label].tolist(), strict=True)}

    def _joined_one_by_one(self) -> dict[int, int]:
        """`component` of a small frame, without sparse matrices."""
        tree = self.unloaded.tree
        joined: list[tuple[int, int]] = []
        first: dict[int, int | None] = {}
        for node, rows in tree.rows.items():
            for k, row in enumerate(rows):
                met = [key for key in row if key >= 0]
                first[6 * node + k] = met[0] if met else None
                joined += [(met[0], other) for other in met[1:]]
        for spring in tree.springs:
            met = [key for key in spring.row if key >= 0]
            joined += [(met[0], other) for other in met[1:]]
        pairs = [(a, b) for a, row in self.matrix.items() for b in row if b > a]
        for a, b in pairs + self.condensed.coupled.tolist():
            start, end = first.get(a, a), first.get(b, b)
            if start is not None and end is not None:
                joined.append((start, end))
        return least_of_sets(self.unloaded.links.unknowns, joined)

    @cached_property
    def members(self) -> dict[int, list[int]]:
        """Unknowns of each component, in order."""
        out: dict[int, list[int]] = {}
        for k, name in self.component.items():
            out.setdefault(name, []).append(k)
        return out

    @cached_property
    def neighbours(self) -> Index:
        """Pairs of DOF numbers that members couple, (pairs, 2)."""
        pairs = [(a, b) for a, row in self.matrix.items() for b in row]
        return np.concatenate([np.array(pairs, dtype=np.int64).reshape(-1, 2), self.condensed.coupled])

    def coupled_with(self, dofs: Collection[int]) -> set[int]:
        """DOF numbers that members couple with the given ones."""
        found = {a for dof in dofs for a in self.matrix.get(dof, ())}
        condensed = self.condensed.coupled
        return found.union(condensed[np.isin(condensed[:, 1], list(dofs)), 0].tolist()) if len(condensed) else found

    def block(self, component: int) -> tuple[Block, set[int]]:
        """The assembled equations of a component without loads; and the DOFs whose loads belong to it."""
        if component not in self._blocks:
            self._blocks[component] = self._assembled(component)
        return self._blocks[component]

    def _is_of(self, row: Row, component: int) -> bool:
        """Whether a row is over unknowns of a component: if one of them is, all are."""
        return next((self.component[k] for k in row if k >= 0), None) == component

    def _assembled(self, component: int) -> tuple[Block, set[int]]:
        tree = self.unloaded.tree
        unknown = {k for k in self.members[component] if k // 6 not in self.condensed.nodes}
        rows = {6 * node + k: row for node, rows in tree.rows.items() for k, row in enumerate(rows) if row}
        ends = {a: row for a, row in rows.items() if self._is_of(row, component)}
        inner = sorted(k for k in unknown if k // 6 not in tree.rows)
        own = set(inner) | set(ends)
        ends |= {b: rows[b] for a in own for b in self.matrix.get(a, {}) if b not in own and b in rows}
        coupled = own | set(ends)
        matrix = {a: {b: parts for b, parts in self.matrix.get(a, {}).items() if b in coupled} for a in own}
        for a in own:
            matrix[a].setdefault(a, {})
        for b in set(ends) - own:
            matrix[b] = {a: matrix[a][b] for a in own if b in matrix[a]} | {b: {}}
        springs = [(spring.row, spring.stiffness) for spring in tree.springs if self._is_of(spring.row, component)]
        varying = self.unloaded.varying.within(own, coupled)
        pattern = pattern_of(matrix, ends)
        for entry in varying.entries if varying else ():
            link(pattern, *entry.at, entry.mask)
        grid = self.unloaded.grid
        masks = Masks.of(ends, springs)
        orders = two_stages(grid, pattern, inner, sorted(unknown.difference(inner)), masks)
        scale = {a: self.scale(a) if a in own else {} for a in matrix}
        return Block(grid, orders, masks, matrix, scale, {}, ends, springs, [], varying), own


def _topology(frame: Description, *, cut: bool, former: Former | None) -> Topology:
    """Nodes and members, reusing those of an earlier frame."""
    if former is None:
        return Topology.of(frame, cut=cut)
    known = former.unloaded.topology
    if not (former.moved or former.elements):
        return known.loaded(frame)
    return known.remade(frame, moved=former.moved, elements=former.elements)


def _stacks(topology: Topology, former: Former | None) -> list[NDArray[Any]] | None:
    """Stiffness matrices of the members of a single batch entry, if those of an earlier frame are known; else None."""
    known = None if former is None else former.unloaded.known_stacks
    if former is None or known is None or not (former.moved or former.elements):
        return known
    return topology.stiffness_beside(former.unloaded.topology, known)


def _geometry(topology: Topology) -> int:
    """Mask of the batch axes over which positions of nodes and axes of bodies vary."""
    frame = topology.frame
    if not frame.shape or (not frame.bodies and topology.plain_positions is not None):
        return 0
    shapes = {node.coordinates.shape[:-1] for node in frame.nodes.values()}
    shapes |= {body.origin.shape[:-1] for body in frame.bodies.values()}
    shapes |= {body.axes.shape[:-2] for body in frame.bodies.values()}
    if shapes == {()}:
        return 0
    shapes.discard(())
    joint = next(iter(shapes)) if len(shapes) == 1 else np.broadcast_shapes(*shapes)
    return mask_of_shape((1,) * (len(frame.shape) - len(joint)) + joint)
