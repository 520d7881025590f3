"""The graph of a large frame: nodes that carry unknowns, where they are, and which are coupled."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..structure.parts import Row, unknowns
from ..structure.topology import Index, Topology
from ..structure.tree import JointTree
from .dissection import Dissection, dissect
from .patterns import narrow
from .transformation import Transformation


class Graph:
    """Nodes and their coupling through members, joints and ties.

    Parameters
    ----------
    topology
        Nodes and members; the first batch entry gives the positions.
    tree
        What each node's displacement is made of.
    unknowns
        Numbers of the unknowns.
    """

    def __init__(self, topology: Topology, tree: JointTree, unknowns: Sequence[int]) -> None:
        self.topology, self.tree = topology, tree
        self.unknown: Index = np.array(unknowns, dtype=np.int64)
        self.node = self.unknown // 6

    @cached_property
    def transformation(self) -> Transformation:
        """What the displacements of nodes and springs are made of, right-hand-side parameters not being told."""
        return Transformation(6 * len(self.topology.number), self.tree, self.unknown, 0)

    @cached_property
    def free(self) -> NDArray[np.bool_]:
        """Nodes whose six displacements are unknowns of their own, (nodes,)."""
        out = np.ones(len(self.topology.number), dtype=bool)
        out[list(self.tree.rows)] = False
        return out

    @cached_property
    def points(self) -> Array:
        """Positions of all nodes, (nodes, 3)."""
        return self.topology.points

    @property
    def entries(self) -> int:
        """Entries of the stiffness, six by six for each node and each coupled pair."""
        return 36 * (len(self._local[0]) + 2 * len(self.pairs))

    @property
    def coupled(self) -> int:
        """Unknowns that share members or joints with one unknown, at most."""
        return 6 * (1 + int(np.bincount(self.pairs.reshape(-1)).max(initial=0)))

    @cached_property
    def pairs(self) -> Index:
        """Coupled pairs of nodes that carry unknowns, (m, 2), the lower first."""
        count, ends = len(self.topology.number), self.topology.ends
        if not self.tree.springs and not any(k >= 0 for six in self.tree.rows.values() for row in six for k in row):
            both = ends[self.free[ends].all(axis=1)]
            return _distinct(both[:, 0], both[:, 1], count)
        free = np.flatnonzero(self.free)
        on_edges = {node: _nodes(six) for node, six in self.tree.rows.items()}
        owners = [np.full(len(own), node, dtype=np.int64) for node, own in on_edges.items()]
        rows = np.concatenate([free, *owners])
        columns = np.concatenate([free, *on_edges.values()])
        carries = scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count))
        joined = scipy.sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
        whole = joined + scipy.sparse.csr_matrix((np.ones(count), (range(count), range(count))), shape=(count, count))
        coupled = (carries.T @ whole @ carries).tocoo()
        first, second = [coupled.row], [coupled.col]
        for spring in self.tree.springs:
            own = _nodes([spring.row])
            first.append(np.repeat(own, len(own)))
            second.append(np.tile(own, len(own)))
        i, j = np.concatenate(first).astype(np.int64), np.concatenate(second).astype(np.int64)
        return _distinct(i, j, count)

    @cached_property
    def dissection(self) -> Dissection:
        """Elimination order of the nodes that carry unknowns; `order` counts these only."""
        carrying, pairs = self._local
        return dissect(self.points[carrying], pairs)

    @cached_property
    def band(self) -> Index:
        """Order of the nodes that carry unknowns, as in `dissection`, that keeps neighbours near each other."""
        carrying, pairs = self._local
        return narrow(pairs[:, 0], pairs[:, 1], len(carrying))

    @cached_property
    def width(self) -> int:
        """Unknowns on one side of the diagonal in that order, six a node."""
        apart = np.abs(np.diff(_ranks(self.band)[self._local[1]], axis=1))
        return 6 * int(apart.max(initial=0)) + 6

    @cached_property
    def _local(self) -> tuple[Index, Index]:
        """Nodes that carry unknowns, and the coupled pairs as numbers among them."""
        carrying = self.node[np.diff(self.node, prepend=-1) > 0]  # unknowns are in order
        return carrying, np.searchsorted(carrying, self.pairs)

    def order(self, nodes: Index, where: NDArray[np.bool_]) -> Index:
        """Order of the unknowns `where`, as numbers among them, that follows an order of nodes."""
        place = np.searchsorted(self._local[0], self.node[where])
        return np.argsort(_ranks(nodes)[place], kind="stable")


def _distinct(first: Index, second: Index, count: int) -> Index:
    """Pairs of different nodes (m, 2) without repetition, the lower first."""
    low, high = np.minimum(first, second), np.maximum(first, second)
    found = np.unique((low * count + high)[low < high])
    return np.stack([found // max(count, 1), found % max(count, 1)], axis=1)


def _ranks(order: Index) -> Index:
    """Where each number stands in an order."""
    ranks = np.empty_like(order)
    ranks[order] = np.arange(len(order))
    return ranks


def _nodes(rows: list[Row]) -> Index:
    """Nodes that carry the unknowns of some rows."""
    return np.array(sorted({k // 6 for row in rows for k in unknowns(row)}), dtype=np.int64)
