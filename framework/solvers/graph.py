"""The graph of a frame: its nodes with unknowns, their positions and coupling, and orders of elimination."""

from __future__ import annotations

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..lazily import cached_property
from ..structure.connections import Connections
from ..structure.disjoint_sets import least_of_sets
from ..structure.edge import GROUND
from ..structure.parts import Row, unknowns
from ..structure.topology import Index, Topology
from .dissection import Dissection, dissect
from .patterns import connected, narrow
from .transformation import Transformation

# Number of orders of unknowns, and of transformations, that are kept.
_FEW = 16
# Up to this many nodes connected parts are found without sparse matrices.
_SMALL = 200


class Links:
    """Unknowns, and the coupling of nodes by members, joints and ties, independent of the positions of nodes.

    Parameters
    ----------
    count
        Number of nodes.
    ends
        Node numbers of the ends of members, (pieces, 2).
    connections
        Joints, ties and supports, and the rows of displacements.
    key
        Key by which frames share this object in the cache; None where they do not.

    Attributes
    ----------
    free
        Mask of the nodes whose six displacements are unknowns, (nodes,).
    unknown, unknowns
        Numbers of all unknowns, (n,), and as a list: displacements of free nodes, joint-relative coordinates of others.
    """

    def __init__(
        self, count: int, ends: Index, connections: Connections, key: tuple[object, ...] | None = None
    ) -> None:
        self.count, self.ends, self.connections, self.key = count, ends, connections, key
        self.free = np.ones(count, dtype=bool)
        self.free[list(connections.rows)] = False
        self.unknown = self._numbers()
        self.unknowns: list[int] = self.unknown.tolist()
        self._transformations: dict[int, Transformation] = {}
        self._orders: dict[bytes, Index] = {}

    def _numbers(self) -> Index:
        rows = self.connections.rows
        own: Index = (6 * np.flatnonzero(self.free)[:, None] + np.arange(6)).reshape(-1)
        on_edges = {k for six in rows.values() for row in six for k in row if k >= 0}
        on_edges.update(k for row in self.connections.springs for k in row if k >= 0)
        return np.union1d(own, np.array(list(on_edges), dtype=np.int64)) if on_edges else own

    @cached_property
    def node(self) -> Index:
        """Node of each unknown, (n,)."""
        found: Index = self.unknown // 6
        return found

    @cached_property
    def components(self) -> Index:
        """Number of the connected part of the frame for each node, (nodes,); supports do not connect."""
        joined = [(edge.first, edge.second) for edge in self.connections.edges if edge.first != GROUND]
        if self.count <= _SMALL:  # without sparse matrices, which take a while to load
            least = least_of_sets(range(self.count), [*map(tuple, self.ends.tolist()), *joined])
            number = {name: k for k, name in enumerate(dict.fromkeys(least.values()))}
            return np.array([number[name] for name in least.values()], dtype=np.int64)
        first, second = np.concatenate([self.ends, np.array(joined, dtype=np.int64).reshape(-1, 2)]).T
        return connected(first, second, self.count)

    @cached_property
    def count_of_components(self) -> int:
        """Number of connected parts."""
        return int(self.components.max(initial=-1)) + 1

    @cached_property
    def unsupported(self) -> Index:
        """Numbers of the parts that have neither a support nor a tie, which may resist rotations."""
        floats = np.ones(self.count_of_components, dtype=bool)
        for edge in self.connections.edges:
            if edge.kind == "tie" or GROUND in (edge.first, edge.second):
                floats[self.components[edge.second if edge.first == GROUND else edge.first]] = False
        return np.flatnonzero(floats)

    def transformation(self, parameters: int) -> Transformation:
        """Displacements of nodes and springs over the unknowns and so many right-hand-side parameters."""
        found = self._transformations.get(parameters)
        if found is None:
            dofs, (_, _, rows, springs) = 6 * self.count, self.connections
            found = Transformation(dofs, rows, springs, self.unknown, parameters)
            if len(self._transformations) >= _FEW:
                self._transformations.clear()
            self._transformations[parameters] = found
        return found

    @cached_property
    def pairs(self) -> Index:
        """Coupled pairs of nodes with unknowns, (m, 2), the lower number first."""
        count, ends, (_, _, rows_of, springs) = self.count, self.ends, self.connections
        if not springs and not any(k >= 0 for six in rows_of.values() for row in six for k in row):
            both = ends[self.free[ends].all(axis=1)]
            return _distinct(both[:, 0], both[:, 1], count)
        free = np.flatnonzero(self.free)
        on_edges = {node: _nodes(six) for node, six in rows_of.items()}
        owners = [np.full(len(own), node, dtype=np.int64) for node, own in on_edges.items()]
        rows = np.concatenate([free, *owners])
        columns = np.concatenate([free, *on_edges.values()])
        carries = scipy.sparse.csr_matrix((np.ones(len(rows)), (rows, columns)), shape=(count, count))
        joined = scipy.sparse.csr_matrix((np.ones(len(ends)), (ends[:, 0], ends[:, 1])), shape=(count, count))
        whole = joined + scipy.sparse.csr_matrix((np.ones(count), (range(count), range(count))), shape=(count, count))
        coupled = (carries.T @ whole @ carries).tocoo()
        first, second = [coupled.row], [coupled.col]
        for row in springs:
            own = _nodes([row])
            first.append(np.repeat(own, len(own)))
            second.append(np.tile(own, len(own)))
        i, j = np.concatenate(first).astype(np.int64), np.concatenate(second).astype(np.int64)
        return _distinct(i, j, count)

    @cached_property
    def band(self) -> Index:
        """Order of the nodes with unknowns, as indices among these, that keeps neighbours near each other.

        Of the two directions it is the one towards the supports, in which pivots stay large: nodes that are eliminated
        first can move with the rest.
        """
        carrying, pairs = self.local
        order = narrow(pairs[:, 0], pairs[:, 1], len(carrying))
        ranks = _ranks(order)[np.searchsorted(carrying, self.supported)]
        away = len(ranks) > 0 and 2.0 * ranks.mean() < len(order) - 1
        return np.ascontiguousarray(order[::-1]) if away else order

    @cached_property
    def supported(self) -> Index:
        """Nodes with unknowns that are supported, or connected to supported nodes without unknowns, (m,)."""
        supported, carries = np.zeros((2, self.count), dtype=bool)
        supported[[edge.second for edge in self.connections.edges if edge.first == GROUND]] = True
        supported[[edge.first for edge in self.connections.edges if edge.second == GROUND]] = True
        carries[self.local[0]] = True
        fixed = supported & ~carries
        first, second = self.ends.T
        near = supported.copy()
        near[first[fixed[second]]] = True
        near[second[fixed[first]]] = True
        return np.flatnonzero(near & carries)

    @cached_property
    def width(self) -> int:
        """Half band width in the order `band`, in unknowns, with six of them at each node."""
        apart = np.abs(np.diff(_ranks(self.band)[self.local[1]], axis=1))
        return 6 * int(apart.max(initial=0)) + 6

    @cached_property
    def local(self) -> tuple[Index, Index]:
        """Nodes with unknowns, and the coupled pairs as indices among these."""
        carrying = self.node[np.diff(self.node, prepend=-1) > 0]  # unknowns are in order
        return carrying, np.searchsorted(carrying, self.pairs)

    def order(self, nodes: Index, where: NDArray[np.bool_]) -> Index:
        """Order of the unknowns in the mask `where`, as indices among these, that follows an order of nodes."""
        place = np.searchsorted(self.local[0], self.node[where])
        return np.argsort(_ranks(nodes)[place], kind="stable")

    def band_order(self, where: NDArray[np.bool_]) -> Index:
        """Order of the unknowns in the mask `where` that follows `band`."""
        key = where.tobytes()
        found = self._orders.get(key)
        if found is None:
            found = self.order(self.band, where)
            if len(self._orders) >= _FEW:
                self._orders.clear()
            self._orders[key] = found
        return found


class Graph:
    """Nodes and their coupling through members, joints and ties.

    Parameters
    ----------
    topology
        Nodes and members; the first batch entry gives the positions.
    links
        Which nodes are coupled.
    """

    def __init__(self, topology: Topology, links: Links) -> None:
        self.topology, self.links = topology, links
        self.unknown, self.node = links.unknown, links.node

    @property
    def transformation(self) -> Transformation:
        """Displacements of nodes and springs over the unknowns, without right-hand-side parameters."""
        return self.links.transformation(0)

    @property
    def free(self) -> NDArray[np.bool_]:
        """Mask of the nodes whose six displacements are unknowns, (nodes,)."""
        return self.links.free

    @cached_property
    def points(self) -> Array:
        """Positions of all nodes, (nodes, 3)."""
        return self.topology.points

    @property
    def entries(self) -> int:
        """Number of entries of the stiffness, with six by six for each node and twice for each coupled pair."""
        return 36 * (len(self.links.local[0]) + 2 * len(self.links.pairs))

    @property
    def coupled(self) -> int:
        """Largest number of unknowns with which one unknown is coupled, itself included."""
        return 6 * (1 + int(np.bincount(self.links.pairs.reshape(-1)).max(initial=0)))

    @cached_property
    def dissection(self) -> Dissection:
        """Nested dissection of the nodes with unknowns; its `order` are indices among these."""
        carrying, pairs = self.links.local
        return dissect(self.points[carrying], pairs)

    @property
    def band(self) -> Index:
        """Order of the nodes with unknowns, as indices among these, that keeps neighbours near each other."""
        return self.links.band

    @property
    def width(self) -> int:
        """Half band width in the order `band`, in unknowns, with six of them at each node."""
        return self.links.width

    def order(self, nodes: Index, where: NDArray[np.bool_]) -> Index:
        """Order of the unknowns in the mask `where`, as indices among these, that follows an order of nodes."""
        return self.links.band_order(where) if nodes is self.links.band else self.links.order(nodes, where)


def _distinct(first: Index, second: Index, count: int) -> Index:
    """Distinct pairs of different nodes, (m, 2), the lower number first."""
    low, high = np.minimum(first, second), np.maximum(first, second)
    found = np.unique((low * count + high)[low < high])
    return np.stack([found // max(count, 1), found % max(count, 1)], axis=1)


def _ranks(order: Index) -> Index:
    """Position of each number in an order."""
    ranks = np.empty_like(order)
    ranks[order] = np.arange(len(order))
    return ranks


def _nodes(rows: list[Row]) -> Index:
    """Nodes whose unknowns occur in some rows."""
    return np.array(sorted({k // 6 for row in rows for k in unknowns(row)}), dtype=np.int64)
