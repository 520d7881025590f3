"""A frame compiled for large displacement: which coordinates are free, which follow, and all numbers by entry."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_matrix

from ..assembly import component_loads
from ..batch import Array, aligned, turned
from ..errors import FrameError
from ..member_loads import applied_forces, weight_forces
from ..plan import Plan
from ..topology import Group, Index
from ..tree import GROUND, Branch, Edge
from .corotation import DEFORMATIONS, Pieces
from .law import Law, law_of
from .links import Link
from .numbers import Numbers, Where
from .plane import WHOLE, plane

HELD = -1


@dataclass(frozen=True)
class Stack:
    """Pieces of one group as `Numbers`; ``ends`` (n, 2) are their node numbers."""

    ends: Index
    level: Numbers
    length: Numbers
    stiffness: Numbers
    work: Numbers | None

    def at(self, where: Where, factor: float) -> Pieces:
        """The numbers of some entries, with the loads multiplied by `factor`."""
        work = None if self.work is None else factor * self.work.at(where)
        return Pieces(self.level.at(where), self.length.at(where), self.stiffness.at(where), work)


@dataclass(frozen=True)
class Joint:
    """An edge of the tree between a child and its parent, its own coordinates in part unknown."""

    edge: Edge
    parent: int
    child: int
    forward: bool
    axes: Numbers | None
    arm: Numbers | None
    offset: Numbers
    stiffness: Numbers
    law: Law | None

    def at(self, where: Where) -> Link:
        """Geometry at some entries."""
        axes = None if self.axes is None else self.axes.at(where)
        arm = None if self.arm is None else self.arm.at(where)
        return Link(axes, arm, self.loose, self.forward, self.edge.kind != "tie")

    @cached_property
    def loose(self) -> NDArray[np.bool_]:
        """Components of rotation that turn first: the softest."""
        most = [np.inf if k in self.edge.ideal else float(np.max(self.edge.stiffness[k])) for k in (3, 4, 5)]
        return np.array([value == min(most) for value in most])


class Model:
    """Coordinates of a frame at finite displacement.

    Nodes that are free, or held in a way that leaves all rotation or none, have displacements and spins of their own;
    every other node hangs on its parent in the tree of joints, rigid links, ties and supports by the edge's own six
    coordinates. Columns number the unknowns; those from `free` on are driven: known, but not zero.

    Parameters
    ----------
    plan
        The plan of the frame, its members cut into their segments.
    flat
        Whether a frame in a plane is kept to it.
    clearance
        Whether joints have their clearances.
    """

    def __init__(self, plan: Plan, *, flat: bool = True, clearance: bool = True) -> None:
        self.plan, self.clearance = plan, clearance
        self.frame, self.topology = plan.frame, plan.topology
        self.ndim = len(plan.frame.shape)
        self.count = len(plan.topology.number)
        if plan.tree.closing:
            name = plan.tree.closing[0][0].name or plan.tree.closing[0][0].kind
            raise FrameError(f"{name!r} closes a loop of joints and supports: a large solution needs a member in it")
        _check_releases(plan)
        self.joints: list[Joint] = []
        self.targets: dict[tuple[int, int], Numbers] = {}
        self.plain = np.ones(self.count, dtype=bool)
        columns = np.zeros((6, self.count), dtype=np.int64)
        for branch in plan.tree.branches:
            self._hang(branch, columns)
        columns[:, self._idle()] = HELD
        self.components = plane(self) if flat else WHOLE
        columns[[k for k in range(6) if k not in self.components]] = HELD
        free = np.flatnonzero((columns == 0).T)
        order = columns.T.reshape(-1)
        order[free] = np.arange(len(free))
        self.free = len(free)
        self.driven = list(self.targets)
        for number, (node, k) in enumerate(self.driven):
            order[6 * node + k] = self.free + number
        self.columns = order.reshape(self.count, 6).T.copy()
        self.size = self.free + len(self.driven)

    # -- structure --------------------------------------------------------------------------------------------------

    def _hang(self, branch: Branch, columns: Index) -> None:
        edge, child = branch.edge, branch.child
        given = self._offsets(edge)
        rotations = [k for k in edge.ideal if k >= 3]
        plain = edge.kind == "support" and (not rotations or (len(rotations) == 3 and not set(given) & {3, 4, 5}))
        columns[list(edge.ideal), child] = HELD
        for k, value in given.items():
            if k in edge.ideal:
                self.targets[child, k] = Numbers.of(value, self.ndim, 0)
        if plain:
            return
        self.plain[child] = False
        whole = [np.asarray(given.get(k, 0.0)) for k in range(6)]
        springs = [np.asarray(value, dtype=np.float64) for value in edge.stiffness]
        arm = None
        if edge.kind == "rigid":
            places = [aligned(self._place(node), self.ndim, 1) for node in (edge.first, edge.second)]
            arm = Numbers.of(places[1] - places[0], self.ndim, 1)
        self.joints.append(
            Joint(
                edge,
                branch.parent,
                child,
                branch.sign > 0.0,
                None if edge.axes is None else Numbers.of(edge.axes, self.ndim, 2),
                arm,
                Numbers.of(np.stack(np.broadcast_arrays(*whole), axis=-1), self.ndim, 1),
                Numbers.of(np.stack(np.broadcast_arrays(*springs), axis=-1), self.ndim, 1),
                law_of(self.frame.joints[edge.name].element) if edge.kind == "joint" and edge.name else None,
            )
        )

    def _offsets(self, edge: Edge) -> dict[int, Array]:
        """Given displacements of an edge that are not zero."""
        known = {"joint": self.frame.offsets, "support": self.frame.supports}.get(edge.kind, {})
        given = known.get(edge.name, {}) if edge.name else {}
        return {k: value for k, value in given.items() if np.any(value)}

    def _place(self, node: int) -> Array:
        return self.topology.position(node)

    def _idle(self) -> list[int]:
        """Nodes that nothing is fixed to."""
        touched = set(self.topology.ends.reshape(-1).tolist())
        touched |= {node for joint in self.joints for node in (joint.parent, joint.child)}
        return [node for node in range(self.count) if node not in touched]

    @cached_property
    def chains(self) -> list[list[int]]:
        """For every node the column of each coordinate that moves it: its parent's, then its own."""
        out: list[list[int]] = [[int(c) for c in self.columns[:, node]] for node in range(self.count)]
        for joint in self.joints:
            above = [] if joint.parent == GROUND else out[joint.parent]
            out[joint.child] = above + out[joint.child]
        return out

    @cached_property
    def symmetric(self) -> bool:
        """Whether the loads have a potential: no moments, or rotation about one fixed axis."""
        moments = any(k >= 3 for _, k, _ in component_loads(self.topology))
        return not moments or len(self.components) < 6

    # -- numbers ----------------------------------------------------------------------------------------------------

    @cached_property
    def stacks(self) -> list[Stack]:
        """Members' pieces, group by group."""
        return [self._stack(group) for group in self.topology.groups]

    def _stack(self, group: Group) -> Stack:
        used = np.ix_(DEFORMATIONS, DEFORMATIONS)
        stiffness = group.element.stiffness_matrix(group.length)[..., used[0], used[1]]
        work = self._work(group)
        return Stack(
            self.topology.ends[group.pieces],
            Numbers.of(group.level, self.ndim, 2, leading=1),
            Numbers.of(group.length, self.ndim, 0, leading=1),
            Numbers.of(stiffness, self.ndim, 2, leading=1),
            None if work is None else Numbers.of(work, self.ndim, 3, leading=1),
        )

    def _work(self, group: Group) -> Array | None:
        """Work of the loads between the ends on the deformations, (n, ..., 3, 3, 7)."""
        out: Array | None = None
        for position, x, force in self._between(group):
            length = group.length[position]
            moved = group.element.shape_functions(length, x)[..., :3, list(DEFORMATIONS)]
            moved[..., 0, 0] -= x / length
            share = force[..., :3, None, None] * moved[..., None, :, :]
            if out is None:
                out = np.zeros((len(group.pieces), *(1,) * self.ndim, 3, 3, 7))
            if out[position].shape != np.broadcast_shapes(out[position].shape, share.shape):
                shape = np.broadcast_shapes(out.shape[1:], share.shape[1:])
                out = np.array(np.broadcast_to(out, (len(out), *shape)))
            out[position] += share
        return out

    def _between(self, group: Group) -> Iterator[tuple[Index, Array, Array]]:
        """Point forces on pieces, in local axes: which pieces, where, how much."""
        everywhere = np.arange(len(group.pieces))
        for x, force in weight_forces(self.topology, group, everywhere):
            yield everywhere, x, force
        for position, piece in enumerate(group.pieces):
            if self.topology.pieces[piece].member in self.frame.member_loads:
                for x, force in applied_forces(self.topology, group, position):
                    if np.any(force[..., 3:]):
                        member = self.topology.pieces[piece].member
                        raise FrameError(f"point load on {member!r} has a moment: put a node there and load it")
                    yield np.array([position]), x, force

    @property
    def loads(self) -> Numbers:
        """Forces and moments on all nodes, loads on members shared between their ends (6, nodes, ...)."""
        return self._summed[0]

    @cached_property
    def _summed(self) -> tuple[Numbers, Array]:
        at: dict[int, Array] = {}
        reach = np.zeros(6)

        def put(node: int, force: Array) -> None:
            np.maximum(reach, np.abs(force).reshape(-1, 6).max(axis=0), out=reach)
            at[node] = at[node] + force if node in at else force

        for node, k, value in component_loads(self.topology):
            put(node, value[..., None] * np.eye(6)[k])
        for node, weight, _ in self.hung:
            put(node, np.concatenate([weight, np.zeros_like(weight)], axis=-1))
        for group in self.topology.groups:
            for positions, x, force in self._between(group):
                pushed = turned(np.swapaxes(group.level[positions], -1, -2), force)
                share = (x / group.length[positions])[..., None]
                for row, position in enumerate(positions):
                    first, second = self.topology.ends[group.pieces[position]].tolist()
                    put(first, (pushed * (1.0 - share))[row])
                    put(second, (pushed * share)[row])
        shape = np.broadcast_shapes(*(force.shape[:-1] for force in at.values())) if at else ()
        out = np.zeros((self.count, *shape, 6))
        for node, force in at.items():
            out[node] += force
        return Numbers.of(out, self.ndim, 1, leading=1), reach

    @property
    def reach(self) -> Array:
        """Largest magnitude of all loads, by component (6,)."""
        return self._summed[1]

    @cached_property
    def hung(self) -> list[tuple[int, Array, Array]]:
        """Weights of masses: node, force (..., 3), arm from the node at the start (..., 3)."""
        if self.frame.weight is None:
            return []
        out = []
        for point in self.frame.masses.values():
            matrix = point.element.mass_matrix()
            mass = matrix[..., 0, 0, None]
            moment = np.stack([matrix[..., 5, 1], matrix[..., 3, 2], matrix[..., 4, 0]], axis=-1)
            arm = np.divide(moment, mass, out=np.zeros(np.broadcast_shapes(moment.shape, mass.shape)), where=mass > 0.0)
            out.append((self.topology.number[point.node], mass * self.frame.weight, arm))
        return out

    # -- pattern ----------------------------------------------------------------------------------------------------

    @cached_property
    def linked(self) -> list[NDArray[np.bool_]]:
        """By stack, which pieces end at a node that hangs on others."""
        return [~self.plain[stack.ends].all(axis=1) for stack in self.stacks]

    @cached_property
    def gather(self) -> list[csr_matrix]:
        """By stack, the sum of end forces (12 n) over the nodes' components (6 nodes)."""
        out = []
        for stack in self.stacks:
            count = len(stack.ends)
            component = np.arange(12)[:, None]
            rows = (component % 6) * self.count + stack.ends[:, :].T[component[:, 0] // 6]
            values = np.ones(12 * count)
            shape = (6 * self.count, 12 * count)
            out.append(csr_matrix((values, (rows.reshape(-1), np.arange(12 * count))), shape=shape))
        return out


def _check_releases(plan: Plan) -> None:
    for name, member in plan.frame.members.items():
        for _, k in member.element.releases:
            if k in (1, 2):
                raise FrameError(
                    f"member {name!r} slides across itself at an end (release {'uy' if k == 1 else 'uz'}): for large "
                    "displacement put a joint there that is free in this component"
                )
