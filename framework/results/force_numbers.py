"""Forces at member ends, in joints and in supports, component by component: for arrays or terms of a recording."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cached_property

import numpy as np

from ..batch import Array, aligned
from ..batched.plan import Plan
from ..structure.assembly import component_loads, mass_loads
from ..structure.connections import TreeEdge
from ..structure.edge import ABOUT, ALONG, Edge
from ..structure.group import Group
from ..structure.parts import Row, Value, add_row, combine, product
from ..structure.tree import entries
from .member_field import end_loads

# A function that returns the values of rows over unknowns and right-hand-side parameters.
Values = Callable[[Sequence[Row]], Sequence[Value]]
Matrix = Sequence[Sequence[Value]]


class ForceNumbers:
    """Forces from displacements, component by component.

    Parameters
    ----------
    plan
        The plan of the frame.
    place
        Function that returns the group of a piece, and its position there.
    values
        Function that returns the values of rows.
    take
        Function that returns a known number as the calculation uses it: itself, or a term of a recording.
    ends
        Function that returns the forces on the ends of a piece as an array, (..., 12).
    written
        Whether a recording is made: `ends` is then used only if the element has no formula.
    loaded
        Whether the loads act, free strains included; without them what imposed displacements cause is found.
    """

    def __init__(
        self,
        plan: Plan,
        place: Callable[[int], tuple[Group, int]],
        values: Values,
        take: Callable[[Value], Value],
        ends: Callable[[int], Array],
        *,
        written: bool,
        loaded: bool = True,
    ) -> None:
        self.grid, self.topology, self.tree = plan.grid, plan.topology, plan.tree
        self.values, self._place, self._take, self._arrays, self._written = values, place, take, ends, written
        self._loaded = loaded
        self._nodes: dict[int, Sequence[Value]] = {}
        self._ends: dict[int, Sequence[Value]] = {}
        self._sums: dict[bool, dict[int, list[Value]]] = {False: {}, True: {}}

    def displacement(self, node: int) -> Sequence[Value]:
        """The six displacements of a node in global axes."""
        axes = self.tree.turn(node)
        return self._node(node) if axes is None else _rotated(self._taken(axes), self._node(node))

    # -- pieces -----------------------------------------------------------------------------------------------------

    def ends(self, piece: int) -> Sequence[Value]:
        """The twelve forces and moments on the ends of a piece in its local axes."""
        if piece not in self._ends:
            found = self.by_formula(piece) if self._written else None
            self._ends[piece] = self._components(self._arrays(piece)) if found is None else found
        return self._ends[piece]

    def member_ends(self, member: str) -> Sequence[Value]:
        """The twelve forces and moments on the ends of a member in its local axes."""
        pieces = self.topology.pieces_of[member]
        return [*self.ends(pieces[0])[:6], *self.ends(pieces[-1])[6:]]

    def by_formula(self, piece: int) -> Sequence[Value] | None:
        """Forces on the ends of a piece by the element's formula, see `end_force_numbers`; None without one."""
        group, position = self._place(piece)
        moved = [value for node in self.topology.pieces[piece].nodes for value in self._node(node)]
        start, end = (self._matrix(turn[position]) for turn in group.end_axes)
        local = [*_rotated(start, moved[:6]), *_rotated(end, moved[6:])]
        length = aligned(group.length[position], len(self.grid.shape))
        found = group.of(position).end_force_numbers(length, local)
        if found is None or not self._loaded:
            return found
        loads = self.grid.components(end_loads(self.topology, group, np.array([position]))[0])
        return [force - self._take(load) for force, load in zip(found, loads, strict=True)]

    def _node(self, node: int) -> Sequence[Value]:
        """The six displacements of a node in its own axes."""
        if node not in self._nodes:
            self._nodes[node] = self.values([self.tree.row(node, k) for k in range(6)])
        return self._nodes[node]

    def _components(self, array: Array) -> list[Value]:
        if self._written:
            return [self._take(value) for value in self.grid.components(array)]
        return list(np.moveaxis(array, -1, 0))

    def _matrix(self, axes: Array) -> Matrix:
        return self._taken(entries(self.grid, axes) or [])

    def _taken(self, axes: Sequence[Sequence[Value]]) -> Matrix:
        return [[self._take(value) for value in row] for row in axes]

    # -- joints and supports ----------------------------------------------------------------------------------------

    def of_edge(self, edge: Edge) -> list[Value]:
        """Force of an edge on its first node, in the edge's axes: springs by displacement, constraints by equilibrium.

        Redundant constraint forces are those of one arbitrary choice.
        """
        if edge in self._closing_springs:
            return self._closing_forces[edge]
        branch = next(b for b in self.tree.branches if b.edge is edge)
        out = self._tree_springs(branch)
        if edge.ideal:
            carried = self._in_axes(edge, self._carried(branch.child, closed=True))
            for k in edge.ideal:
                out[k] = product(-branch.sign, carried[k])
            if ALONG in edge.ideal and ABOUT not in edge.ideal:
                out[ABOUT] = out[ABOUT] - product(self._take(edge.pitch), out[ALONG])
        return out

    def _tree_springs(self, branch: TreeEdge) -> list[Value]:
        return self._springs(branch.edge, [self.tree.joint_row(branch, k) for k in range(6)])

    def _springs(self, edge: Edge, moved: list[Row]) -> list[Value]:
        """Forces of an edge's springs on its first node, in the edge's axes, given the rows of its displacement."""
        force: list[Row] = [{} for _ in range(6)]
        for k, row in enumerate(edge.elastic(moved)):
            add_row(force[k], row, edge.stiffness[k])
        add_row(force[ABOUT], force[ALONG], product(-1.0, edge.pitch))
        return list(self.values(force))

    @cached_property
    def _children(self) -> dict[int, list[TreeEdge]]:
        children: dict[int, list[TreeEdge]] = {}
        for branch in self.tree.branches:
            children.setdefault(branch.parent, []).append(branch)
        return children

    @cached_property
    def _closing_springs(self) -> dict[Edge, list[Value]]:
        """Spring forces of loop-closing edges on their first nodes."""
        return {edge: self._springs(edge, between) for edge, between in self.tree.closing}

    @cached_property
    def _closing_forces(self) -> dict[Edge, list[Value]]:
        """Forces of loop-closing edges on their first nodes: spring forces and Lagrange multipliers of constraints."""
        out = {edge: list(force) for edge, force in self._closing_springs.items()}
        for constraint, multiplier in zip(self.tree.elimination.given, self._multipliers(), strict=True):
            force, edge = out[constraint.edge], constraint.edge
            force[constraint.component] = force[constraint.component] + multiplier
            if constraint.component == ALONG:
                force[ABOUT] = force[ABOUT] - product(self._take(edge.pitch), multiplier)
        return out

    def _multipliers(self) -> list[Value]:
        """The Lagrange multiplier of each constraint, from the equilibrium of the dependent unknowns."""
        elimination = self.tree.elimination
        out: list[Value] = [0.0] * len(elimination.given)
        for dependent, source in elimination.sources.items():
            residual = self._generalised(dependent)
            for index, factor in source.items():
                out[index] = out[index] + product(self._take(factor), residual)
        return out

    def _generalised(self, unknown: int) -> Value:
        """Unbalanced force on an unknown before the multipliers."""
        node, k = divmod(unknown, 6)
        total = self._carried(node, closed=False)
        branch = next((b for b in self.tree.branches if b.child == node), None)
        if branch is None:
            axes = self.topology.axes(node)
            return total[k] if axes is None else _rotated(_transposed(self._matrix(axes)), total)[k]
        springs, outer = self._tree_springs(branch), self._in_axes(branch.edge, total)
        force = [product(branch.sign, a) + b for a, b in zip(outer, springs, strict=True)]
        return force[k] + product(self._take(branch.edge.pitch), force[ALONG]) if k == ABOUT else force[k]

    def _in_axes(self, edge: Edge, vector: Sequence[Value]) -> Sequence[Value]:
        return vector if edge.axes is None else _rotated(_transposed(self._matrix(edge.axes)), vector)

    def _carried(self, node: int, *, closed: bool) -> list[Value]:
        """Internal minus external forces on a node and all nodes that it carries in the tree, six global components.

        Found from the tips inwards and kept, so that the joints of a chain do not each begin at its tip.
        """
        sums, carried = self._sums[closed], [node]
        for at in carried:
            if at not in sums:
                carried += [branch.child for branch in self._children.get(at, [])]
        for at in reversed(carried):
            if at not in sums:
                total = self._residual(at, closed=closed)
                for branch in self._children.get(at, []):
                    total = _sum(total, self._moved(sums[branch.child], branch.edge, branch.sign))
                sums[at] = total
        return sums[node]

    def _moved(self, force: list[Value], edge: Edge, sign: float) -> list[Value]:
        """A force at the child of an edge transferred to its parent, with its moment along a rigid link."""
        if edge.kind != "rigid":
            return force
        arm = [product(sign, self._take(value)) for value in self.tree.arm(edge)]
        turning = [
            product(arm[(k + 1) % 3], force[(k + 2) % 3]) - product(arm[(k + 2) % 3], force[(k + 1) % 3])
            for k in range(3)
        ]
        return [*force[:3], *_sum(force[3:], turning)]

    def _residual(self, node: int, *, closed: bool) -> list[Value]:
        total: list[Value] = [0.0] * 6
        for piece, side in self._touching.get(node, []):
            group, position = self._place(piece)
            back = _transposed(self._matrix(group.local_axes[position]))
            total = _sum(total, _rotated(back, self.ends(piece)[6 * side : 6 * side + 6]))
        for k, load in self._loads.get(node, []):
            total[k] = total[k] - load
        closing = self._closing_forces if closed else self._closing_springs
        for edge, _ in self.tree.closing:
            if node in (edge.first, edge.second):
                force = closing[edge]
                force = force if edge.axes is None else _rotated(self._matrix(edge.axes), force)
                total = _sum(total, force if node == edge.second else [-x for x in self._moved(force, edge, 1.0)])
        return total

    @cached_property
    def _loads(self) -> dict[int, list[tuple[int, Value]]]:
        """Components and values of the loads on each node."""
        loads: dict[int, list[tuple[int, Value]]] = {}
        if not self._loaded:
            return loads
        for node, k, value in component_loads(self.topology):
            loads.setdefault(node, []).append((k, self._take(self.grid.value(value))))
        for node, vector in mass_loads(self.topology):
            loads.setdefault(node, []).extend(enumerate(map(self._take, self.grid.components(vector))))
        return loads

    @cached_property
    def _touching(self) -> dict[int, list[tuple[int, int]]]:
        touching: dict[int, list[tuple[int, int]]] = {}
        for index, piece in enumerate(self.topology.pieces):
            for side, node in enumerate(piece.nodes):
                touching.setdefault(node, []).append((index, side))
        return touching


def _sum(one: Sequence[Value], other: Sequence[Value]) -> list[Value]:
    return [a + b for a, b in zip(one, other, strict=True)]


def _rotated(matrix: Matrix, vector: Sequence[Value]) -> list[Value]:
    """A vector of three-component blocks, each multiplied by a matrix."""
    return [
        combine(zip(three, vector[block : block + 3], strict=True))
        for block in range(0, len(vector), 3)
        for three in matrix
    ]


def _transposed(matrix: Matrix) -> Matrix:
    return list(zip(*matrix, strict=True))
