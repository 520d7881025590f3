"""Joint trees that suit the stiffnesses of each batch entry.

A spring that closes a loop acts on a difference of joint displacements of the tree. If it is much stiffer than the
joints of the tree, digits of that difference are lost; its displacement should then be an unknown itself. Which joint
of a loop is stiffest may differ between batch entries: where an entry's own tree leaves out a joint of the common tree,
the unknowns of that joint represent the displacement of the joint that replaces it.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import add

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .constraints import Elimination
from .disjoint_sets import DisjointSets
from .edge import GROUND, Edge
from .forest import Branch, rooted, spanning
from .parts import RightHandSideParameters, Row, Value, add_row, combine, product
from .topology import Topology
from .tree import Exchanged, JointTree

# A loop-closing spring may be this many times stiffer than those of its loop; the error grows by the same factor.
_SUITS = 16.0
_SIX = range(6)

Mask = NDArray[np.bool_]


def joint_tree(
    topology: Topology, rhs_parameters: RightHandSideParameters, order: Sequence[int] | None = None
) -> JointTree:
    """The joint tree of a frame, in which at each batch entry the displacements of the stiffest joints are unknowns.

    `order` are the indices of the edges in order of preference, if known, see `preference`.
    """
    tree = JointTree.of(topology, rhs_parameters, order)
    chosen, closing = [branch.edge for branch in tree.branches], [edge for edge, _ in tree.closing]
    left = _unsuited(chosen, closing)
    if not left.any():
        return tree
    rows = [_Rows.of(tree, chosen, closing, np.ones(()))]
    while left.any():
        more = _spanning_at(tuple(np.argwhere(left)[0].tolist()), chosen, closing)
        suited = left & ~_unsuited(*more)
        rows.append(_Rows.of(tree, *more, np.where(suited, 1.0, 0.0)))
        left = left & ~suited
    rows[0].where = 1.0 - reduce(add, (each.where for each in rows[1:]))
    return _merged(tree, rows)


def _unsuited(chosen: list[Edge], closing: list[Edge]) -> Mask:
    """Mask of the entries at which a loop-closing spring is much stiffer than a tree edge that it could replace."""
    out: Mask = np.zeros((), dtype=bool)
    for edge, along in _loops(chosen, closing):
        stiffness = edge.stiffest
        for other in along:
            if isinstance(stiffness, np.ndarray) or isinstance(other.stiffest, np.ndarray):
                out = out | np.asarray(stiffness > _SUITS * other.stiffest)
    return out


def _loops(chosen: list[Edge], closing: list[Edge]) -> Iterator[tuple[Edge, list[Edge]]]:
    """Loop-closing edges without ideal components, each with the edges of its loop that have none either."""
    springs = [edge for edge in closing if not edge.ideal]
    if not springs:
        return
    above = {branch.child: branch for branch in rooted(chosen, GROUND)}
    for edge in springs:
        ways = _way(above, edge.first), _way(above, edge.second)
        yield edge, [each.edge for each in ways[0] ^ ways[1] if not each.edge.ideal]


def _way(above: dict[int, Branch[Edge, int]], node: int) -> set[Branch[Edge, int]]:
    """Branches from a node to its root."""
    out = set()
    while node in above:
        out.add(above[node])
        node = above[node].parent
    return out


def _spanning_at(entry: tuple[int, ...], chosen: list[Edge], closing: list[Edge]) -> tuple[list[Edge], list[Edge]]:
    """Edges of the tree that suits one entry, and those that close its loops; edges with ideal components stay."""

    def strength(edge: Edge) -> tuple[int, float]:
        stiffness = np.asarray(edge.stiffest)
        at = tuple(min(k, n - 1) for k, n in zip(entry, stiffness.shape, strict=False))
        return len(edge.ideal), float(stiffness[at])

    constraints = [edge for edge in chosen if edge.ideal]
    springs = [edge for edge in (*chosen, *closing) if not edge.ideal]
    found, left = spanning([*constraints, *sorted(springs, key=strength, reverse=True)])
    return found, [*(edge for edge in closing if edge.ideal), *left]


@dataclass
class _Rows:
    """Rows of displacements over the unknowns of the batch, for the entries that have one own tree.

    Attributes
    ----------
    batch
        The common tree of the batch.
    own
        The tree of these entries, with unknowns of its own.
    names
        For each unknown of the own tree: the unknown of the batch that represents it.
    taken
        For each edge that is only in the own tree: the node whose unknowns represent the displacement of the edge.
    where
        One at these entries and zero at the others, (...).
    """

    batch: JointTree
    own: JointTree
    names: dict[int, int]
    taken: dict[Edge, int]
    where: Array

    @classmethod
    def of(cls, batch: JointTree, chosen: list[Edge], closing: list[Edge], where: Array) -> _Rows:
        """Rows by the own tree of the `chosen` edges, which the `closing` edges complete to loops."""
        own = JointTree(batch.topology, batch.grid, batch.rhs_parameters, batch.edges)
        children = {branch.child for branch in batch.branches}
        roots = dict.fromkeys(branch.parent for branch in batch.branches if branch.parent not in children)
        own.join(chosen, closing, tuple(roots))
        return cls(batch, own, *_names(batch, own), where)

    def of_node(self, node: int, component: int) -> Row:
        """Row of a displacement component of a node, in the node's axes."""
        return self._named(self.own.rows[node][component])

    def between(self, edge: Edge) -> list[Row]:
        """Rows of the relative displacement of an edge that closes a loop in the common tree."""
        branch = self.branches.get(edge)
        if branch is None:
            return [self._named(row) for row in self._closing[edge]]
        return [self._named(self.own.joint_row(branch, k)) for k in _SIX]

    def elastic(self, edge: Edge) -> list[Row]:
        """Rows of the elastic displacement of any edge, that is without offset and advance of a screw."""
        branch = self.branches.get(edge)
        if branch is None:
            return [self._named(row) for row in edge.elastic(self._closing[edge])]
        return [{} if k in edge.ideal else self._named({6 * branch.child + k: 1.0}) for k in _SIX]

    def raw(self, edge: Edge) -> list[Row]:
        """Rows of the elastic displacement of any edge before dependent unknowns are eliminated."""
        branch = self.branches.get(edge)
        if branch is None:
            return [self._renamed(row) for row in edge.elastic(self._closing[edge])]
        return [self._renamed({6 * branch.child + k: 1.0}) for k in _SIX]

    def __post_init__(self) -> None:
        self.branches = {branch.edge: branch for branch in self.own.branches}
        self._closing = dict(self.own.closing)

    def _renamed(self, row: Row) -> Row:
        return {self.names.get(key, key): value for key, value in row.items()}

    def _named(self, row: Row) -> Row:
        return self.batch.elimination.substituted(self._renamed(row))


def _names(batch: JointTree, own: JointTree) -> tuple[dict[int, int], dict[Edge, int]]:
    """The unknowns of the batch that represent those of an own tree, by the latter; and for each edge that is only in
    the own tree, the node whose unknowns represent its displacement.
    """
    children = {branch.edge: branch.child for branch in batch.branches}
    kept = {branch.edge for branch in own.branches}
    parts = DisjointSets[int]()
    for edge in batch.edges:
        if edge.first != GROUND:
            parts.join(edge.first, edge.second)
    spare: dict[int, list[int]] = {}
    for edge, child in children.items():
        if edge not in kept:
            spare.setdefault(parts.find(child), []).append(child)
    names, taken = dict[int, int](), dict[Edge, int]()
    for branch in own.branches:
        if branch.edge not in children:
            taken[branch.edge] = spare[parts.find(branch.child)].pop(0)
        child = taken[branch.edge] if branch.edge in taken else children[branch.edge]
        names |= {6 * branch.child + k: 6 * child + k for k in _SIX}
    return names, taken


def _merged(tree: JointTree, rows: list[_Rows]) -> JointTree:
    """The common tree, in which the unknowns have at each entry the meaning of the entry's own tree."""
    own = JointTree(tree.topology, tree.grid, tree.rhs_parameters, tree.edges, branches=tree.branches)
    whole = tree.elimination
    own.elimination = replace(whole, rows=dict(whole.rows), sources=dict(whole.sources))
    own.rows = {n: [_sum((each.of_node(n, k), each.where) for each in rows) for k in _SIX] for n in tree.rows}
    elastic = {edge: _summed(rows, [each.elastic(edge) for each in rows]) for edge in tree.edges}
    for branch in tree.branches:
        edge, keys = branch.edge, [6 * branch.child + k for k in _SIX]
        if not all(edge in each.branches for each in rows):
            own.elimination.rows |= dict(zip(keys, elastic[edge], strict=True))
            own.elimination.sources |= dict(zip(keys, _sources(whole, rows, edge), strict=True))
            own.given_up |= dict(zip(keys, _given_up(rows, edge), strict=True))
    for edge, _ in tree.closing:
        own.closing.append((edge, _summed(rows, [each.between(edge) for each in rows])))
        where = [each.where for each in rows if edge in each.branches]
        if where:
            own.exchanged[edge] = Exchanged(reduce(add, where), elastic[edge], _sources(whole, rows, edge))
    for edge in (*(branch.edge for branch in tree.branches), *(edge for edge, _ in tree.closing)):
        own.stiffen(edge, elastic[edge])
    own.springs += tree.springs[len(own.springs) :]  # springs on unknowns that represent no displacement
    return own


def _summed(rows: list[_Rows], each: list[list[Row]]) -> list[Row]:
    """Six rows, combined from those by each own tree at its entries."""
    return [_sum((six[k], own.where) for six, own in zip(each, rows, strict=True)) for k in _SIX]


def _sum(given: Iterable[tuple[Row, Value]]) -> Row:
    """Sum of rows, each times a number that is one at its entries and zero at the others."""
    rows, wheres = zip(*given, strict=True)
    out: Row = {}
    for key in dict.fromkeys(key for row in rows for key in row):
        values = [row.get(key, 0.0) for row in rows]
        if all(value is values[0] or _equal(value, values[0]) for value in values):
            out[key] = values[0]
        else:
            add_row(out, {key: combine(zip(wheres, values, strict=True))})
    return out


def _equal(value: Value, other: Value) -> bool:
    return not isinstance(value, np.ndarray) and not isinstance(other, np.ndarray) and bool(value == other)


def _sources(elimination: Elimination, rows: list[_Rows], edge: Edge) -> list[Row]:
    """For each component of an edge, the combination of constraints that determines its dependent unknowns."""
    out: list[Row] = [{} for _ in _SIX]
    for each in rows:
        for combination, row in zip(out, each.raw(edge), strict=True):
            for key, value in row.items():
                add_row(combination, elimination.sources.get(key, {}), product(each.where, value))
    return out


def _given_up(rows: list[_Rows], edge: Edge) -> list[dict[tuple[Edge, int], Value]]:
    """For each component of an edge, its factors by (edge, component) of the edges that replace it in own trees."""
    out: list[dict[tuple[Edge, int], Value]] = [{} for _ in _SIX]
    for each in rows:
        if edge in each.branches:
            continue
        for found, row in zip(out, each.raw(edge), strict=True):
            for taken, child in each.taken.items():
                for k in _SIX:
                    if 6 * child + k in row:
                        value = product(each.where, row[6 * child + k])
                        found[taken, k] = found.get((taken, k), 0.0) + value
    return out
