"""Forces from displacements: at member ends, in joints and supports, and along members."""

from __future__ import annotations

from functools import cached_property, partial

import numpy as np

from ..arm import transferred
from ..batch import Array, rotated
from ..error_bounds.equilibrium import rounded
from ..error_bounds.kinematics import FrameKinematics
from ..error_bounds.sharing import load_shares
from ..structure.assembly import nodal_loads
from ..structure.connections import TreeEdge
from ..structure.edge import ABOUT, ALONG, Edge
from ..structure.parts import Row, add_row, product
from .along_member import AlongMembers
from .member_field import deflection, end_loads, internal_forces
from .piece_program import forces_on_ends
from .primary import Primary


class Recovery(AlongMembers):
    """What follows from the displacements of a solution.

    Parameters
    ----------
    solution
        Where the unknowns come from.
    """

    def __init__(self, solution: Primary) -> None:
        super().__init__(solution.plan.topology)
        self.solution = solution
        self.plan = solution.plan
        self.tree = solution.plan.tree
        self._pieces: dict[int, Array] = {}

    # -- members ----------------------------------------------------------------------------------------------------

    def end_forces(self, member: str) -> Array:
        """Forces on both ends of a member in its local axes, (..., 12), not to be written to."""
        pieces = self.topology.pieces_of[member]
        start, end = self.piece_forces(pieces[0]), self.piece_forces(pieces[-1])
        if start is end:
            return start
        return np.concatenate([start[..., :6], end[..., 6:]], axis=-1)

    def moved(self, piece: int, x: Array) -> Array:
        """Displacement at stations of a piece in global axes, (k, ..., 6)."""
        group, position = self.group(piece)
        ends = self.piece_displacement(piece)[None]
        local = deflection(self.topology, group, np.array([position]), x[:, None], ends)[:, 0]
        return rotated(np.swapaxes(group.local_axes[position], -1, -2), local)

    def moved_along(self, member: str, at: Array) -> Array:
        """Displacement at stations in each free motion of consistent mechanisms, global, (motions, m, k, 6)."""
        mechanisms = self.solution.consistent_mechanisms
        assert mechanisms is not None
        count = len(mechanisms.motions([]))

        def displacement(piece: int, x: Array, motion: int) -> Array:
            group, position = self.group(piece)
            ends = np.zeros((*self.solution.shape, 12))
            ends[mechanisms.mask] = mechanisms.motions(self._rows(piece))[motion]
            local = group.local(position, ends)
            shapes = group.of(position).shape_functions(group.length[position], x)
            moved = np.einsum("...ij,...j->...i", shapes, local)
            return rotated(np.swapaxes(group.local_axes[position], -1, -2), moved)

        whole = [self.along(member, at, partial(displacement, motion=motion)) for motion in range(count)]
        return np.stack([each[mechanisms.mask] for each in whole])

    def _rows(self, piece: int) -> list[Row]:
        return [self.tree.row(node, k) for node in self.topology.pieces[piece].nodes for k in range(6)]

    def piece_displacement(self, piece: int) -> Array:
        """End displacements of a piece in its local axes, (..., 12)."""
        group, position = self.group(piece)
        nodal = self.solution.stacked(self._rows(piece))
        with np.errstate(invalid="ignore"):  # of mechanisms, whose entries are masked
            return group.local(position, nodal)

    def piece_forces(self, piece: int) -> Array:
        """Forces on both ends of a piece in its local axes, (..., 12)."""
        if piece not in self._pieces:
            group, position = self.group(piece)
            rows = self._rows(piece)
            nodal = self.solution.stacked(rows)
            loads = end_loads(self.topology, group, np.array([position]))[0]
            with np.errstate(invalid="ignore"):  # of mechanisms, whose entries are masked
                found = forces_on_ends(self.plan.grid, group, position, rows, nodal, loads)
                if found is None:
                    local = group.local(position, nodal)
                    found = group.of(position).end_forces(group.length[position], local) - loads
            self._pieces[piece] = np.broadcast_to(found, (*self.solution.shape, 12))
        return self._pieces[piece]

    def internal(self, piece: int, x: Array) -> Array:
        """Internal forces at stations of a piece, (k, ..., 6)."""
        group, position = self.group(piece)
        ends = self.piece_forces(piece)[None]
        return internal_forces(self.topology, group, np.array([position]), x[:, None], ends)[:, 0]

    # -- joints and supports ----------------------------------------------------------------------------------------

    def joint_rows(self, joint: str) -> list[Row]:
        """Relative displacement in a joint, in its axes."""
        if joint in self._branches:
            return [self.tree.joint_row(self._branches[joint], k) for k in range(6)]
        return next(rows for edge, rows in self.tree.closing if edge.kind == "joint" and edge.name == joint)

    def joint_force(self, joint: str) -> Array:
        """Force of a joint on its first node, in its axes, (..., 6)."""
        edge = next(e for e in self.tree.edges if e.kind == "joint" and e.name == joint)
        return self._edge_force(edge)

    def reaction(self, node: str) -> Array:
        """Force of the ground on a node, global, (..., 6)."""
        edge = next(e for e in self.tree.edges if e.kind == "support" and e.name == node)
        return -self._edge_force(edge)

    def _edge_force(self, edge: Edge) -> Array:
        """Force of an edge on its first node, in its axes; redundant ideal components as they share it."""
        excess = self._excess.get(edge)
        return self._any_force(edge) if excess is None else self._any_force(edge) - excess

    @cached_property
    def _excess(self) -> dict[Edge, Array]:
        """What `_any_force` has of forces that need no load, where ideal components are redundant."""
        if not self.tree.elimination.self_stresses:
            return {}
        kinematics = FrameKinematics.of(self.plan).mapped(rounded)
        links, out = kinematics.links, {}
        for load_share in load_shares(kinematics):
            forces = {k: links[k].worked(self._any_force(links[k].edge)) for k in load_share.place}
            with np.errstate(invalid="ignore"):  # of mechanisms
                for k, excess in load_share.excess(forces).items():
                    out[links[k].edge] = np.asarray(links[k].exerted(excess), dtype=np.float64)
        return out

    def _any_force(self, edge: Edge) -> Array:
        """The same as any choice of redundant components has it: springs by their displacement, what is held by
        equilibrium."""
        if edge in self._closing_forces:
            return self._closing_forces[edge]
        branch = next(b for b in self.tree.branches if b.edge is edge)
        out = self._tree_springs(branch)
        if edge.ideal:
            transmitted = -branch.sign * self._in_axes(edge, self._carried_force(branch.child, closed=True))
            for k in edge.ideal:
                out[..., k] = transmitted[..., k]
            if ALONG in edge.ideal and ABOUT not in edge.ideal:
                out[..., ABOUT] -= edge.pitch * out[..., ALONG]
        return out

    def _tree_springs(self, branch: TreeEdge) -> Array:
        moved = [self.tree.joint_row(branch, k) for k in range(6)]
        return self._springs(branch.edge, moved)

    def _springs(self, edge: Edge, moved: list[Row]) -> Array:
        """Forces of an edge's springs on its first node, in its axes, for its relative displacement."""
        force: list[Row] = [{} for _ in range(6)]
        for k, row in enumerate(edge.elastic(moved)):
            add_row(force[k], row, edge.stiffness[k])
        add_row(force[ABOUT], force[ALONG], product(-1.0, edge.pitch))
        return self.solution.stacked(force)

    @cached_property
    def _branches(self) -> dict[str, TreeEdge]:
        return {b.edge.name: b for b in self.tree.branches if b.edge.kind == "joint" and b.edge.name is not None}

    @cached_property
    def _children(self) -> dict[int, list[TreeEdge]]:
        children: dict[int, list[TreeEdge]] = {}
        for branch in self.tree.branches:
            children.setdefault(branch.parent, []).append(branch)
        return children

    @cached_property
    def _closing_springs(self) -> dict[Edge, Array]:
        """Forces of the springs in loop-closing edges on their first nodes."""
        return {edge: self._springs(edge, between) for edge, between in self.tree.closing}

    @cached_property
    def _closing_forces(self) -> dict[Edge, Array]:
        """Forces of loop-closing edges on their first nodes: springs, and multipliers of what they hold."""
        out = {key: force.copy() for key, force in self._closing_springs.items()}
        for constraint, multiplier in zip(self.tree.elimination.given, self._multipliers(), strict=True):
            force, edge = out[constraint.edge], constraint.edge
            force[..., constraint.component] += multiplier
            if constraint.component == ALONG:
                force[..., ABOUT] -= edge.pitch * multiplier
        return out

    def _multipliers(self) -> list[Array]:
        """One multiplier a constraint: what keeps the dependent unknowns in equilibrium."""
        elimination = self.tree.elimination
        out: list[Array] = [np.zeros(self.solution.shape) for _ in elimination.given]
        for dependent, source in elimination.sources.items():
            residual = self._generalised(dependent)
            for index, factor in source.items():
                out[index] = out[index] + factor * residual
        return out

    def _generalised(self, unknown: int) -> Array:
        """Unbalanced force on an unknown before the multipliers."""
        node, k = divmod(unknown, 6)
        total = self._carried_force(node, closed=False)
        branch = next((b for b in self.tree.branches if b.child == node), None)
        if branch is None:
            axes = self.topology.axes(node)
            return (total if axes is None else rotated(np.swapaxes(axes, -1, -2), total))[..., k]
        force = branch.sign * self._in_axes(branch.edge, total) + self._tree_springs(branch)
        advance = branch.edge.pitch * force[..., ALONG] if k == ABOUT else 0.0
        value: Array = force[..., k] + advance
        return value

    def _in_axes(self, edge: Edge, vector: Array) -> Array:
        return vector if edge.axes is None else rotated(np.swapaxes(edge.axes, -1, -2), vector)

    def _carried_force(self, node: int, *, closed: bool) -> Array:
        """Inner minus outer forces at a node and all that it carries, global, (..., 6)."""
        total = self._residual(node, closed=closed)
        for branch in self._children.get(node, []):
            force = self._carried_force(branch.child, closed=closed)
            total = total + self._moved(force, branch.edge, branch.sign)
        return total

    def _moved(self, force: Array, edge: Edge, sign: float) -> Array:
        """A force at the child of a rigid link as felt at its parent."""
        if edge.kind != "rigid":
            return force
        arm = sign * (self.topology.position(edge.second) - self.topology.position(edge.first))
        return transferred(force, arm)

    def _residual(self, node: int, *, closed: bool) -> Array:
        total: Array = np.moveaxis(np.zeros((6, *self.solution.shape)), 0, -1)
        for piece, side in self._touching.get(node, []):
            group, position = self.group(piece)
            end = self.piece_forces(piece)[..., 6 * side : 6 * side + 6]
            total = total + rotated(np.swapaxes(group.local_axes[position], -1, -2), end)
        for loaded, vector in nodal_loads(self.topology):
            if loaded == node:
                total = total - vector
        closing = self._closing_forces if closed else self._closing_springs
        for edge, _ in self.tree.closing:
            if node in (edge.first, edge.second):
                force = closing[edge]
                force = force if edge.axes is None else rotated(edge.axes, force)
                total = total + (force if node == edge.second else -self._moved(force, edge, 1.0))
        return total

    @cached_property
    def _touching(self) -> dict[int, list[tuple[int, int]]]:
        touching: dict[int, list[tuple[int, int]]] = {}
        for index, piece in enumerate(self.topology.pieces):
            for side, node in enumerate(piece.nodes):
                touching.setdefault(node, []).append((index, side))
        return touching
