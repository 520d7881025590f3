"""Joint-relative coordinates: the displacement of every node from those of a few, and of the joints between them.

Joints, rigid links, ties and supports are edges between nodes and the ground. A spanning forest of them gives each
node a parent, and ``u_child = u_parent + R (delta + offset)``: the unknowns are the displacements of the roots and the
joint displacements delta, so that a stiff spring stands alone on the diagonal of its own delta, an ideal component is
simply absent and a free one has no spring. Edges that close a loop add springs, or constraints that are eliminated
(Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 4 and 8, uses the same coordinates for motion).
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass, field

import numpy as np

from .batch import Array, aligned
from .constraints import Constraint, Elimination, eliminate
from .frame import Frame, Tie
from .parts import Grid, Row, Value, add_row, combine, is_zero
from .topology import Topology

GROUND = -1
Matrix3 = list[list[Value]]
_IDENTITY: Matrix3 = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]


@dataclass(frozen=True)
class Edge:
    """Connection between two nodes (or the ground): six springs from 0 to inf between them.

    Attributes
    ----------
    name
        The joint, or the node supported; None for ties.
    kind
        ``joint``, ``support``, ``rigid`` or ``tie``.
    first, second
        Node numbers, GROUND for the ground.
    ideal
        Components that are held.
    stiffness
        By component, 0.0 where there is no spring.
    axes
        (..., 3, 3) as columns, None for the global ones.
    offset
        Imposed relative displacement by component.
    """

    name: str | None
    kind: str
    first: int
    second: int
    ideal: tuple[int, ...]
    stiffness: tuple[Value, ...]
    axes: Array | None
    offset: tuple[Value, ...]

    @property
    def strength(self) -> tuple[int, float]:
        """Sorts what had better be in the tree: most ideal components, then the stiffest."""
        return len(self.ideal), max(float(np.max(k)) for k in self.stiffness)


@dataclass(frozen=True)
class Branch:
    """An edge of the tree, seen from `child` to `parent`; `sign` is 1 where the child is the edge's second node."""

    edge: Edge
    parent: int
    child: int
    sign: float


@dataclass(frozen=True)
class Spring:
    """A spring on the displacement ``row . q + gap``."""

    row: Row
    stiffness: Value
    gap: Value


@dataclass
class Tree:
    """What each node's displacement is made of.

    Attributes
    ----------
    rows, shifts
        For each node on an edge: six sparse rows over the unknowns, and six known parts, in the node's axes.
    branches
        Tree edges, parents before children.
    closing
        Edges that close a loop, with their six rows and known parts in the edge's axes.
    springs
        All springs, on the unknowns.
    elimination
        Unknowns that loop-closing ideal components made dependent.
    """

    topology: Topology
    grid: Grid
    edges: list[Edge]
    rows: dict[int, list[Row]] = field(default_factory=dict)
    shifts: dict[int, list[Value]] = field(default_factory=dict)
    branches: list[Branch] = field(default_factory=list)
    closing: list[tuple[Edge, list[Row], list[Value]]] = field(default_factory=list)
    springs: list[Spring] = field(default_factory=list)
    elimination: Elimination = field(default_factory=Elimination)

    @classmethod
    def of(cls, topology: Topology) -> Tree:
        """Choose the tree and express all nodes by it."""
        grid = Grid(topology.frame.shape)
        tree = cls(topology, grid, edges_of(topology, grid))
        chosen, closing = _spanning(tree.edges)
        tree._grow(chosen)
        for edge in closing:
            tree._close(edge)
        tree._hold()
        return tree

    def row(self, node: int, component: int) -> tuple[Row, Value]:
        """A displacement component of a node, in its own axes, over the unknowns, and its known part."""
        if node in self.rows:
            return self.rows[node][component], self.shifts[node][component]
        return {6 * node + component: 1.0}, 0.0

    def unknown(self, branch: Branch, component: int) -> tuple[Row, Value]:
        """A joint displacement of a tree edge, elastic and free part, and its offset."""
        free = component not in branch.edge.ideal
        row = self.elimination.substituted({6 * branch.child + component: 1.0}) if free else ({}, 0.0)
        return row[0], combine([(1.0, row[1]), (1.0, branch.edge.offset[component])])

    def turn(self, node: int) -> Matrix3:
        """Axes of a node as columns."""
        return _entries(self.grid, None if node == GROUND else self.topology.axes(node))

    def arm(self, edge: Edge) -> list[Value]:
        """Vector from the first to the second node of a rigid link, global; zero for every other edge."""
        if edge.kind != "rigid":
            return [0.0, 0.0, 0.0]
        return self.grid.components(self.topology.position(edge.second) - self.topology.position(edge.first))

    # -- building ---------------------------------------------------------------------------------------------------

    def _grow(self, chosen: list[Edge]) -> None:
        at: dict[int, list[Edge]] = {GROUND: []}
        for edge in chosen:
            at.setdefault(edge.first, []).append(edge)
            at.setdefault(edge.second, []).append(edge)
        seen: set[int] = set()
        for root in at:
            if root in seen:
                continue
            seen.add(root)
            if root != GROUND:
                self.rows[root] = [{6 * root + k: 1.0} for k in range(6)]
                self.shifts[root] = [0.0] * 6
            queue = deque([root])
            while queue:
                parent = queue.popleft()
                for edge in at[parent]:
                    child = edge.second if edge.first == parent else edge.first
                    if child not in seen:
                        seen.add(child)
                        self._derive(Branch(edge, parent, child, 1.0 if child == edge.second else -1.0))
                        queue.append(child)

    def _derive(self, branch: Branch) -> None:
        edge, child = branch.edge, branch.child
        self.branches.append(branch)
        self.springs += [
            Spring({6 * child + k: 1.0}, edge.stiffness[k], 0.0)
            for k in range(6)
            if k not in edge.ideal and not is_zero(edge.stiffness[k])
        ]
        moved = self.global_rows(branch.parent)
        arm = [combine([(branch.sign, a)]) for a in self.arm(edge)]
        rows, shifts = _carried(moved, arm)
        axes = _entries(self.grid, edge.axes)
        for k in range(6):
            block, axis = divmod(k, 3)
            for i in range(3):
                factor = combine([(branch.sign, axes[i][axis])])
                shifts[3 * block + i] = combine([(1.0, shifts[3 * block + i]), (factor, edge.offset[k])])
                if k not in edge.ideal:
                    add_row(rows[3 * block + i], {6 * child + k: 1.0}, factor)
        self.rows[child], self.shifts[child] = _rotated(_transposed(self.turn(child)), rows, shifts)

    def global_rows(self, node: int) -> tuple[list[Row], list[Value]]:
        """Displacement of a node in global axes: rows over the unknowns and known parts."""
        if node == GROUND:
            return [{} for _ in range(6)], [0.0] * 6
        rows, shifts = zip(*(self.row(node, k) for k in range(6)), strict=True)
        return _rotated(self.turn(node), list(rows), list(shifts))

    def _close(self, edge: Edge) -> None:
        first, knowns = _carried(self.global_rows(edge.first), self.arm(edge))
        second, others = self.global_rows(edge.second)
        for k in range(6):
            add_row(second[k], first[k], -1.0)
            others[k] = combine([(1.0, others[k]), (-1.0, knowns[k])])
        rows, gaps = _rotated(_transposed(_entries(self.grid, edge.axes)), second, others)
        gaps = [combine([(1.0, gap), (-1.0, offset)]) for gap, offset in zip(gaps, edge.offset, strict=True)]
        self.closing.append((edge, rows, gaps))
        self.springs += [
            Spring(rows[k], edge.stiffness[k], gaps[k])
            for k in range(6)
            if k not in edge.ideal and not is_zero(edge.stiffness[k])
        ]

    def _hold(self) -> None:
        """Eliminate the ideal components of the edges that close a loop."""
        held = [
            Constraint(rows[k], gaps[k], edge, k) for edge, rows, gaps in self.closing for k in edge.ideal
        ]
        if not held:
            return
        self.elimination = eliminate(self.grid, held)
        for node in self.rows:
            new = [self.elimination.substituted(row) for row in self.rows[node]]
            self.rows[node] = [row for row, _ in new]
            pairs = zip(self.shifts[node], new, strict=True)
            self.shifts[node] = [combine([(1.0, own), (1.0, known)]) for own, (_, known) in pairs]
        self.springs = [self._substituted(spring) for spring in self.springs]

    def _substituted(self, spring: Spring) -> Spring:
        row, known = self.elimination.substituted(spring.row)
        return Spring(row, spring.stiffness, combine([(1.0, spring.gap), (1.0, known)]))


def edges_of(topology: Topology, grid: Grid) -> list[Edge]:
    """Joints, rigid links, ties and supports of a frame."""
    frame, number = topology.frame, topology.number
    joints = [_joint(frame, grid, name, number) for name in frame.joints]
    ties = [_tie(tie, number) for tie in frame.ties]
    return joints + ties + [_support(frame, grid, node, number) for node in frame.supports]


def _joint(frame: Frame, grid: Grid, name: str, number: dict[str, int]) -> Edge:
    link = frame.joints[name]
    stiffness = link.element.stiffness
    ideal = tuple(int(k) for k in np.flatnonzero(np.isinf(stiffness.reshape(-1, 6)[0])))
    springs = tuple(grid.components(np.where(np.isinf(stiffness), 0.0, stiffness)))
    axes = None if link.element.axes is None else aligned(link.element.axes, len(frame.shape), 2)
    offset = _filled(grid, frame.offsets.get(name, {}))
    return Edge(name, "joint", number[link.first], number[link.second], ideal, springs, axes, offset)


def _tie(tie: Tie, number: dict[str, int]) -> Edge:
    kind = "rigid" if tie.rigid else "tie"
    return Edge(None, kind, number[tie.master], number[tie.slave], tie.components, (0.0,) * 6, None, (0.0,) * 6)


def _support(frame: Frame, grid: Grid, node: str, number: dict[str, int]) -> Edge:
    held = frame.supports[node]
    ideal = tuple(sorted(held))
    return Edge(node, "support", GROUND, number[node], ideal, (0.0,) * 6, None, _filled(grid, held))


def _filled(grid: Grid, given: dict[int, Array]) -> tuple[Value, ...]:
    values = ((grid.value(given[k]) if k in given else 0.0) for k in range(6))
    return tuple(0.0 if not np.any(value) else value for value in values)


def _spanning(edges: list[Edge]) -> tuple[list[Edge], list[Edge]]:
    """Spanning forest by Kruskal's rule, strongest edges first, and the edges that are left over."""
    leader: dict[int, int] = {}

    def find(node: int) -> int:
        while leader.setdefault(node, node) != node:
            leader[node] = leader[leader[node]]
            node = leader[node]
        return node

    chosen, closing = [], []
    for edge in sorted(edges, key=lambda e: e.strength, reverse=True):
        a, b = find(edge.first), find(edge.second)
        if a == b:
            closing.append(edge)
        else:
            leader[a] = b
            chosen.append(edge)
    return chosen, closing


def _entries(grid: Grid, axes: Array | None) -> Matrix3:
    if axes is None:
        return _IDENTITY
    flat = grid.components(axes, trailing=2)
    return [flat[0:3], flat[3:6], flat[6:9]]


def _transposed(matrix: Matrix3) -> Matrix3:
    return [list(column) for column in zip(*matrix, strict=True)]


def _rotated(matrix: Matrix3, rows: list[Row], shifts: list[Value]) -> tuple[list[Row], list[Value]]:
    """Both three-component blocks multiplied by `matrix`."""
    new: list[Row] = [{} for _ in range(6)]
    known: list[Value] = [0.0] * 6
    for block in (0, 3):
        for i in range(3):
            for j in range(3):
                if not is_zero(matrix[i][j]):
                    add_row(new[block + i], rows[block + j], matrix[i][j])
            known[block + i] = combine([(matrix[i][j], shifts[block + j]) for j in range(3)])
    return new, known


def _carried(moved: tuple[list[Row], list[Value]], arm: list[Value]) -> tuple[list[Row], list[Value]]:
    """Rigid motion at the end of `arm`: displacement plus rotation x arm."""
    rows = [dict(row) for row in moved[0]]
    shifts = list(moved[1])
    for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        minus = combine([(-1.0, arm[j])])
        add_row(rows[i], moved[0][3 + j], arm[k])
        add_row(rows[i], moved[0][3 + k], minus)
        shifts[i] = combine([(1.0, shifts[i]), (arm[k], moved[1][3 + j]), (minus, moved[1][3 + k])])
    return rows, shifts
