"""Spanning trees of joints for the stiffnesses that each batch entry has.

A spring that closes a loop acts on the difference of joint displacements of the tree. Where it is much the stiffer,
that difference is lost beside them; it had better be a joint displacement itself. Which joint of a loop is stiffest may
differ from entry to entry: the unknowns of one that an entry had better leave out of its tree then stand there for
the displacement of one that it takes in its place.
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

# A closing spring may be so much stiffer than those of its loop: that share of the digits is lost.
_SUITS = 16.0
_SIX = range(6)

Mask = NDArray[np.bool_]


def joint_tree(
    topology: Topology, rhs_parameters: RightHandSideParameters, order: Sequence[int] | None = None
) -> JointTree:
    """The tree of joints, rigid links, ties and supports, in which each batch entry has its stiffest as unknowns.

    The `order` of preference of the first entry's edges may be known.
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
    """Where a closing spring is much stiffer than one that it could take the place of."""
    out: Mask = np.zeros((), dtype=bool)
    for edge, along in _loops(chosen, closing):
        stiffness = edge.stiffest
        for other in along:
            if isinstance(stiffness, np.ndarray) or isinstance(other.stiffest, np.ndarray):
                out = out | np.asarray(stiffness > _SUITS * other.stiffest)
    return out


def _loops(chosen: list[Edge], closing: list[Edge]) -> Iterator[tuple[Edge, list[Edge]]]:
    """Edges without ideal components that close a loop, and those edges of its tree that are alike."""
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
    """The tree of one entry and what closes its loops; what has ideal components is in it as it was."""

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
    """Displacements over the unknowns of the batch, at entries that have one tree.

    Attributes
    ----------
    batch
        The tree of the batch.
    own
        That of the entries, on its own unknowns.
    names
        By these: the unknowns that stand for them.
    taken
        By edge that the tree of the batch has not: the node the unknowns of which stand for its own.
    where
        One at the entries and zero at the others.
    """

    batch: JointTree
    own: JointTree
    names: dict[int, int]
    taken: dict[Edge, int]
    where: Array

    @classmethod
    def of(cls, batch: JointTree, chosen: list[Edge], closing: list[Edge], where: Array) -> _Rows:
        """Express all nodes by a tree of its own."""
        own = JointTree(batch.topology, batch.grid, batch.rhs_parameters, batch.edges)
        children = {branch.child for branch in batch.branches}
        roots = dict.fromkeys(branch.parent for branch in batch.branches if branch.parent not in children)
        own.join(chosen, closing, tuple(roots))
        return cls(batch, own, *_names(batch, own), where)

    def of_node(self, node: int, component: int) -> Row:
        """Displacement of a node."""
        return self._named(self.own.rows[node][component])

    def between(self, edge: Edge) -> list[Row]:
        """Relative displacement of an edge that closes a loop in the tree of the batch."""
        branch = self.branches.get(edge)
        if branch is None:
            return [self._named(row) for row in self._closing[edge]]
        return [self._named(self.own.joint_row(branch, k)) for k in _SIX]

    def elastic(self, edge: Edge) -> list[Row]:
        """The same without what is imposed, of any edge."""
        branch = self.branches.get(edge)
        if branch is None:
            return [self._named(row) for row in edge.elastic(self._closing[edge])]
        return [{} if k in edge.ideal else self._named({6 * branch.child + k: 1.0}) for k in _SIX]

    def raw(self, edge: Edge) -> list[Row]:
        """The same over unknowns of which some are dependent."""
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
    """By unknown of an entry's own tree the unknown of the batch that stands for it; and by edge that only the own tree
    has, the node whose unknowns these are."""
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
    """The tree of the batch, its unknowns at each entry those of the entry's own."""
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
    own.springs += tree.springs[len(own.springs) :]  # what holds unknowns that stand for nothing
    return own


def _summed(rows: list[_Rows], each: list[list[Row]]) -> list[Row]:
    """Six rows, at each entry those by its own tree."""
    return [_sum((six[k], own.where) for six, own in zip(each, rows, strict=True)) for k in _SIX]


def _sum(given: Iterable[tuple[Row, Value]]) -> Row:
    """Rows, each at the entries at which the number beside it is one; that number is zero at the others."""
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
    """Combinations of constraints by which the dependent unknowns in an edge's displacement are determined."""
    out: list[Row] = [{} for _ in _SIX]
    for each in rows:
        for combination, row in zip(out, each.raw(edge), strict=True):
            for key, value in row.items():
                add_row(combination, elimination.sources.get(key, {}), product(each.where, value))
    return out


def _given_up(rows: list[_Rows], edge: Edge) -> list[dict[tuple[Edge, int], Value]]:
    """By component of an edge: how it follows from those of the edges in the tree in its place."""
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
