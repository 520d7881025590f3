"""Joint-relative coordinates: displacements of nodes expressed by those of root nodes and of the joints in between.

Joints, rigid links, ties and supports are edges between nodes and the ground. A spanning forest of them gives each
node a parent, and ``u_child = u_parent + R (delta + offset)``. The unknowns are the displacements of the roots and the
joint displacements delta: a stiff spring stands alone on the diagonal of its own delta, an ideal component has no
unknown, and a free one has no spring. Edges that close a loop add springs, or constraints that are eliminated
(Featherstone, *Rigid Body Dynamics Algorithms*, 2008, ch. 4 and 8, uses the same coordinates for motion).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..batch import Array, aligned
from ..described.parts import Tie
from ..description import Description
from .connections import Connections, TreeEdge
from .constraints import Constraint, Elimination, eliminate
from .edge import ABOUT, ALONG, GROUND, Edge, preference, strengths
from .forest import rooted, spanning
from .parts import (
    Grid,
    RightHandSideParameters,
    Row,
    Value,
    add_row,
    combined_each,
    is_zero,
    product,
    scaled_each,
)
from .topology import Topology

# Three rows of a matrix whose columns are axes in global components; None for the global axes.
Matrix3 = list[list[Value]] | None
_SIX = range(6)
_NONE: tuple[Row, ...] = tuple({} for _ in _SIX)


@dataclass(frozen=True)
class TreeSpring:
    """A spring of a `stiffness` on the displacement that `row` gives."""

    row: Row
    stiffness: Value


@dataclass(frozen=True)
class Exchanged:
    """An edge that closes a loop in the common tree, but belongs to the own tree of some batch entries.

    Attributes
    ----------
    where
        One at these entries and zero at the others, (...).
    rows
        Rows of its elastic displacement, each of which is a single unknown at these entries.
    sources
        For each row the combination of constraints that determines its dependent unknowns.
    """

    where: Value
    rows: list[Row]
    sources: list[Row]


@dataclass
class JointTree:
    """The displacements of all nodes as rows over the unknowns and right-hand-side parameters, by a tree of edges.

    Unknown 6 n + k is the displacement k of node n if it is on no edge or a root, or else that of the edge from its
    parent.

    Attributes
    ----------
    topology
        The numbered nodes and members.
    grid
        The batch.
    rhs_parameters
        The right-hand-side parameters.
    edges
        Joints, rigid links, ties and supports.
    rows
        For each node on an edge: the rows of its six displacements, in the node's axes.
    branches
        Edges of the tree, parents before children.
    closing
        Edges that close a loop, with the rows of their relative displacement in the edge's axes.
    springs
        All joint springs.
    elimination
        Dependent unknowns, by the ideal components that close loops.
    exchanged
        Edges that close a loop at some batch entries only.
    given_up
        For each unknown of an edge that is not in the tree at all entries: its factors by (exchanged edge, component)
        where it is not.
    turn_of_body
        Axes of bodies, kept once they were computed.
    """

    topology: Topology
    grid: Grid
    rhs_parameters: RightHandSideParameters
    edges: list[Edge]
    rows: dict[int, list[Row]] = field(default_factory=dict)
    branches: list[TreeEdge] = field(default_factory=list)
    closing: list[tuple[Edge, list[Row]]] = field(default_factory=list)
    springs: list[TreeSpring] = field(default_factory=list)
    elimination: Elimination = field(default_factory=Elimination)
    exchanged: dict[Edge, Exchanged] = field(default_factory=dict)
    given_up: dict[int, dict[tuple[Edge, int], Value]] = field(default_factory=dict)
    turn_of_body: dict[str, Matrix3] = field(default_factory=dict, repr=False)

    @classmethod
    def of(
        cls, topology: Topology, rhs_parameters: RightHandSideParameters, order: Sequence[int] | None = None
    ) -> JointTree:
        """Choose the tree and express all nodes by it; `order` is the order of preference of the edges, if known."""
        tree = cls(topology, rhs_parameters.grid, rhs_parameters, edges_of(topology, rhs_parameters))
        if order is None:
            order = preference([(e.first, e.second) for e in tree.edges], strengths(tree.edges))
        tree.grow(*spanning([tree.edges[k] for k in order]))
        return tree

    @classmethod
    def by(cls, topology: Topology, rhs_parameters: RightHandSideParameters, known: Connections) -> JointTree:
        """The tree of a frame with supports alone, from the connections of another frame."""
        return cls(topology, rhs_parameters.grid, rhs_parameters, known.edges, known.rows, known.branches)

    @property
    def connections(self) -> Connections:
        """The parts of the tree that frames with the same connections can share."""
        return Connections(self.edges, self.branches, self.rows, [spring.row for spring in self.springs])

    def grow(self, chosen: list[Edge], closing: list[Edge]) -> None:
        """Build the tree from the `chosen` edges, add the `closing` ones, and eliminate dependent unknowns."""
        self.join(chosen, closing)
        self._hold()

    def join(self, chosen: list[Edge], closing: list[Edge], roots: tuple[int, ...] = ()) -> None:
        """Build the tree from the given `roots` and add the `closing` edges, without eliminating dependent unknowns."""
        for branch in rooted(chosen, GROUND, roots):
            self._derive(branch)
        for edge in closing:
            self._close(edge)

    def row(self, node: int, component: int) -> Row:
        """Row of a displacement component of a node, in the node's axes."""
        return self.rows[node][component] if node in self.rows else {6 * node + component: 1.0}

    def joint_row(self, branch: TreeEdge, component: int) -> Row:
        """Row of a relative displacement of a tree edge, in the edge's axes, offset and advance of a screw included."""
        row = dict(branch.edge.offset[component])
        if component not in branch.edge.ideal:
            add_row(row, self.elimination.substituted({6 * branch.child + component: 1.0}))
        if component == ALONG and not is_zero(branch.edge.pitch):
            add_row(row, self.joint_row(branch, ABOUT), branch.edge.pitch)
        return row

    def turn(self, node: int) -> Matrix3:
        """Axes of a node as columns."""
        body = None if node == GROUND else self.topology.bodies[node]
        if body is None:
            return None
        if body not in self.turn_of_body:
            self.turn_of_body[body] = entries(self.grid, self.topology.axes_of[body])
        return self.turn_of_body[body]

    def axes(self, edge: Edge) -> Matrix3:
        """Axes of an edge as columns."""
        return entries(self.grid, edge.axes)

    def arm(self, edge: Edge) -> list[Value]:
        """Vector from the first to the second node of a rigid link in global axes, three components."""
        return self.grid.components(self.topology.position(edge.second) - self.topology.position(edge.first))

    def global_rows(self, node: int) -> list[Row]:
        """Rows of the six displacements of a node in global axes."""
        if node == GROUND:
            return [{} for _ in _SIX]
        return _rotated(self.turn(node), [self.row(node, k) for k in range(6)])

    # -- building ---------------------------------------------------------------------------------------------------

    def _derive(self, branch: TreeEdge) -> None:
        edge, child, sign = branch.edge, branch.child, branch.sign
        if branch.parent != GROUND and branch.parent not in self.rows:
            self.rows[branch.parent] = [{6 * branch.parent + k: 1.0} for k in _SIX]
        self.branches.append(branch)
        self.stiffen(edge, [{6 * child + k: 1.0} for k in _SIX])
        rows = self._carried(edge, branch.parent, sign)
        columns = _columns(self.axes(edge), sign)
        for k in _SIX:
            free, offset = k not in edge.ideal, edge.offset[k]
            if not free and not offset:
                continue
            for i, factor in columns[k].items():
                if offset:
                    add_row(rows[i], offset, factor)
                if free:
                    rows[i][6 * child + k] = factor
        if edge.kind == "joint" and (isinstance(edge.pitch, np.ndarray) or edge.pitch != 0.0):
            turn: Row = edge.offset[ABOUT] if ABOUT in edge.ideal else {**edge.offset[ABOUT], 6 * child + ABOUT: 1.0}
            for i, factor in columns[ALONG].items():
                add_row(rows[i], turn, product(edge.pitch, factor))
        self.rows[child] = _rotated(_transposed(self.turn(child)), rows)

    def _carried(self, edge: Edge, node: int, sign: float = 1.0) -> list[Row]:
        """Rows of the global displacement at the far end of an edge that moves with `node`: plus rotation x arm."""
        moved = self.global_rows(node)
        rows = [dict(row) for row in moved]
        if edge.kind == "rigid":
            arm = [product(sign, a) for a in self.arm(edge)]
            for i, j, k in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
                add_row(rows[i], moved[3 + j], arm[k])
                add_row(rows[i], moved[3 + k], product(-1.0, arm[j]))
        return rows

    def _close(self, edge: Edge) -> None:
        moved = [dict(row) for row in self.global_rows(edge.second)]
        for row, first in zip(moved, self._carried(edge, edge.first), strict=True):
            add_row(row, first, -1.0)
        between = _rotated(_transposed(self.axes(edge)), moved)
        self.closing.append((edge, between))
        self.stiffen(edge, edge.elastic(between))

    def stiffen(self, edge: Edge, elastic: list[Row]) -> None:
        """Add the springs of an edge, given the rows of its elastic displacement."""
        if edge.kind != "joint":
            return
        for k, stiffness in enumerate(edge.stiffness):
            if k not in edge.ideal and (isinstance(stiffness, np.ndarray) or stiffness != 0.0):
                self.springs.append(TreeSpring(elastic[k], stiffness))

    def _hold(self) -> None:
        """Eliminate the ideal components of the edges that close a loop."""
        elastic = [(edge, edge.elastic(between)) for edge, between in self.closing]
        size = self.topology.frame.size
        constrained = [Constraint(rows[k], edge, k, size) for edge, rows in elastic for k in edge.ideal]
        if not constrained:
            return
        self.elimination = eliminate(self.rhs_parameters, constrained, self.topology.frame.absent)
        change = self.elimination.substituted
        self.rows = {node: [change(row) for row in rows] for node, rows in self.rows.items()}
        self.springs = [TreeSpring(change(spring.row), spring.stiffness) for spring in self.springs]
        self.closing = [(edge, [change(row) for row in rows]) for edge, rows in self.closing]
        # unknowns that represent no displacement at an entry get a unit spring there, and nothing else acts on them
        self.springs += [TreeSpring({key: 1.0}, where) for key, where in self.elimination.idle.items()]


def edges_of(topology: Topology, rhs_parameters: RightHandSideParameters) -> list[Edge]:
    """Joints, rigid links, ties and supports of a frame."""
    frame, number = topology.frame, topology.number
    joints = _joints(frame, rhs_parameters, number)
    ties = [_tie(tie, number) for tie in frame.ties]
    return joints + ties + [_support(frame, rhs_parameters, node, number) for node in frame.supports]


def _joints(frame: Description, rhs_parameters: RightHandSideParameters, number: dict[str, int]) -> list[Edge]:
    links = frame.joints.values()
    ideal = np.array([np.isinf(link.element.stiffness.reshape(-1, 6)[:1]).any(axis=0) for link in links])
    constrained = [tuple(k for k in _SIX if row[k]) for row in ideal.tolist()]
    grid, ndim, edges = rhs_parameters.grid, len(frame.shape), []
    for (name, link), components in zip(frame.joints.items(), constrained, strict=True):
        axes = None if link.element.axes is None else aligned(link.element.axes, ndim, 2)
        springs = _springs(grid, link.element.stiffness)
        offset = _offset(rhs_parameters, frame.offsets.get(name, {}))
        pitch = grid.value(link.element.pitch / (2.0 * np.pi))
        ends = number[link.first], number[link.second]
        edges.append(Edge(name, "joint", *ends, components, springs, axes, offset, pitch))
    return edges


def _springs(grid: Grid, stiffness: Array) -> tuple[Value, ...]:
    """The six stiffnesses, 0.0 where they are infinite."""
    if stiffness.size == 6:
        return tuple(0.0 if k == np.inf else k for k in stiffness.reshape(-1).tolist())
    infinite = np.isinf(stiffness)
    return tuple(grid.components(np.where(infinite, 0.0, stiffness) if infinite.any() else stiffness))


def _tie(tie: Tie, number: dict[str, int]) -> Edge:
    kind = "rigid" if tie.rigid else "tie"
    return Edge(None, kind, number[tie.master], number[tie.slave], tie.components, (0.0,) * 6, None, _NONE)


def _support(frame: Description, rhs_parameters: RightHandSideParameters, node: str, number: dict[str, int]) -> Edge:
    constrained = frame.supports[node]
    ideal = tuple(sorted(constrained))
    return Edge(node, "support", GROUND, number[node], ideal, (0.0,) * 6, None, _offset(rhs_parameters, constrained))


def _offset(rhs_parameters: RightHandSideParameters, given: Mapping[int, Array]) -> tuple[Row, ...]:
    return rhs_parameters.six(given) if given else _NONE


def strongest_first(edges: list[Edge]) -> list[Edge]:
    """Edges in order of preference for the tree."""
    return sorted(edges, key=lambda edge: edge.strength, reverse=True)


def entries(grid: Grid, axes: Array | None) -> Matrix3:
    """Axes (..., 3, 3) as three rows of numbers; None for the global ones."""
    if axes is None:
        return None
    flat = grid.components(axes, trailing=2) if axes.size != 9 else list[Value](axes.reshape(-1).tolist())
    return [flat[0:3], flat[3:6], flat[6:9]]


def _columns(axes: Matrix3, sign: float) -> list[Row]:
    """For each component along the axes, its six global components per unit, times `sign`."""
    if axes is None:
        return [{k: sign} for k in _SIX]
    return scaled_each([{block + i: axes[i][axis] for i in range(3)} for block in (0, 3) for axis in range(3)], sign)


def _transposed(matrix: Matrix3) -> Matrix3:
    return None if matrix is None else [list(column) for column in zip(*matrix, strict=True)]


def _rotated(matrix: Matrix3, rows: list[Row]) -> list[Row]:
    """Both three-component blocks multiplied by `matrix`."""
    if matrix is None:
        return rows
    return combined_each([zip(three, rows[block : block + 3], strict=True) for block in (0, 3) for three in matrix])
