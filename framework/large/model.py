"""A frame compiled for large displacement: coordinates that are unknown or prescribed, and which node follows which."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cached_property, reduce

import numpy as np
import scipy
from numpy.typing import NDArray

from ..batch import Array
from ..batched.plan import Plan
from ..errors import FrameError
from ..structure.assembly import component_loads
from ..structure.connections import TreeEdge
from ..structure.edge import GROUND, Edge
from ..structure.forest import rooted, spanning
from ..structure.parts import is_zero
from ..structure.topology import Index
from ..structure.tree import strongest_first
from .joints import TreeJoint, offsets
from .numbers import Loads, Numbers, Stack, Where
from .planes import EntryPlanes

CONSTRAINED = -1


class Model:
    """Coordinates of a frame at finite displacement.

    Nodes that are free, or constrained in a way that leaves all rotation or none, have displacements and spins of their
    own; every other node is attached to its parent in the tree of joints, rigid links, ties and supports by the edge's
    own six coordinates. Columns number the unknowns; those from `free` on are prescribed: known, but not zero.

    Parameters
    ----------
    plan
        The plan of the frame, its members cut into their segments.
    in_plane
        Whether a frame in a plane is kept to it.
    clearance
        Whether joints have their clearances.

    Attributes
    ----------
    planes
        To which plane each entry keeps, also alone.
    components
        Global displacement components in which nodes move: those of the plane of all entries, or all six.
    columns
        Number of each coordinate (6, nodes), `CONSTRAINED` where it stays zero.
    plain
        Nodes that have displacements and spins of their own (nodes,).
    joints
        Edges of the joint tree, parents first.
    loops
        Edges that close loops, from first to second node.
    multipliers
        Numbers of the forces in the ideal components of the loops (6, loops), among the unknowns.
    contacts
        Place among the rigid contacts of those joints and loops, counted on, that have one.
    """

    def __init__(self, plan: Plan, *, in_plane: bool = True, clearance: bool = True) -> None:
        self.plan, self.frame, self.topology = plan, plan.frame, plan.topology
        self.clearance = clearance
        self.ndim = len(plan.frame.shape)
        self.count = len(plan.topology.number)
        _check(plan)
        self.loads = Loads.of(plan.topology)
        self.stacks = [Stack.of(plan.topology, group) for group in plan.topology.groups]
        self.planes = EntryPlanes.of(plan.topology, plan.tree.edges, self.loads, in_plane=in_plane)
        self.components = self.planes.components
        edges = [edge for edge in plan.tree.edges if self._matters(edge)]
        # of equals the first is in the tree, where a turn has no end
        chosen, closing = spanning(strongest_first(sorted(edges, key=lambda edge: is_zero(edge.pitch))))
        self.loops = [TreeJoint.of(plan.topology, TreeEdge(e, e.first, e.second, 1.0), clearance) for e in closing]
        self.plain = np.ones(self.count, dtype=bool)
        self.joints: list[TreeJoint] = []
        self.prescribed_values: dict[tuple[int, int], Numbers] = {}
        columns = np.full((6, self.count), CONSTRAINED)
        columns[list(self.components)] = 0
        for branch in rooted(chosen, GROUND):
            self._attach(TreeJoint.of(plan.topology, branch, clearance), columns)
        self._number(columns)
        rigid = [number for number, joint in enumerate(self.edges) if joint.rigid]
        self.contacts = {number: place for place, number in enumerate(rigid)}

    def _matters(self, edge: Edge) -> bool:
        """Whether an edge constrains anything but motion out of the plane."""
        return edge.kind != "support" or any(k in self.components for k in edge.ideal)

    def _attach(self, joint: TreeJoint, columns: Index) -> None:
        edge, child = joint.edge, joint.child
        given = offsets(self.frame, edge)
        kept = joint.within(self.components)
        rotations = {k for k in joint.ideal if k >= 3 and k in kept}
        whole = rotations == {k for k in kept if k >= 3} and not rotations & set(given)
        columns[:, child] = [0 if k in kept and k not in joint.ideal else CONSTRAINED for k in range(6)]
        for k in set(joint.ideal) & set(given):
            self.prescribed_values[child, k] = Numbers.of(given[k], self.ndim, 0)
        if edge.kind != "support" or not (whole or not rotations):
            self.plain[child] = False
            self.joints.append(joint)

    def _number(self, columns: Index) -> None:
        touched = set(self.topology.ends.reshape(-1).tolist())
        touched |= {node for joint in self.joints + self.loops for node in (joint.parent, joint.child)}
        loads = self.loads.nodal.array
        touched |= set(np.flatnonzero(loads.any(axis=(0, *range(2, loads.ndim)))).tolist())
        columns[:, [node for node in range(self.count) if node not in touched]] = CONSTRAINED
        order = columns.T.reshape(-1)
        unknown = np.flatnonzero(order == 0)
        order[unknown] = np.arange(len(unknown))
        self.multipliers = np.full((6, len(self.loops)), CONSTRAINED)
        constrained = [
            (k, n) for n, loop in enumerate(self.loops) for k in loop.ideal if k in loop.within(self.components)
        ]
        for number, place in enumerate(constrained):
            self.multipliers[place] = len(unknown) + number
        self.free = len(unknown) + len(constrained)
        self.prescribed = list(self.prescribed_values)
        for number, (node, k) in enumerate(self.prescribed):
            order[6 * node + k] = self.free + number
        self.columns = order.reshape(self.count, 6).T.copy()
        self.size = self.free + len(self.prescribed)

    @cached_property
    def present(self) -> NDArray[np.bool_]:
        """Which entries were not left out, the batch flattened (entries,)."""
        absent = False if self.frame.absent is None else self.frame.absent
        return ~np.broadcast_to(absent, self.frame.shape).reshape(-1)

    def where(self, index: Index) -> Where:
        """Indices along each batch axis of entries of the flattened batch."""
        return tuple(np.unravel_index(index, self.frame.shape)) if self.frame.shape else ()

    @cached_property
    def length(self) -> float:
        """Length that displacements are compared with: the frame's size; of joints at the origin, what they can move.

        Where nothing is anywhere but there, that is what loads, one upon the other, leave of the softest springs.
        """
        if self.frame.size > 0.0:
            return self.frame.size
        given = [_largest(values.array) for (_, k), values in self.prescribed_values.items() if k < 3]
        given += [_largest(joint.offset.array[:3]) for joint in self.edges]
        given += [
            _largest(joint.clearance.array)
            for joint in self.edges
            if joint.clearance_directions and joint.clearance_directions[0] < 3
        ]
        springs = [joint.stiffness.array[:3] for joint in self.edges]
        springs = [each[(each > 0.0) & np.isfinite(each)] for each in springs]
        softest = min((float(each.min()) for each in springs if each.size), default=np.inf)
        deflection = sum(given) + float(np.abs(self.loads.nodal.array[:3]).sum(axis=(0, 1)).max(initial=0.0)) / softest
        return deflection if 0.0 < deflection < np.inf else 1.0

    @cached_property
    def lengths(self) -> Numbers:
        """Length that displacements are compared with, (...): of an entry alone, whatever its neighbours are."""
        if self.frame.size == 0.0 or self.topology.plain_positions is not None:
            return Numbers.of(np.full((1,) * self.ndim, self.length), self.ndim, 0)
        reach = [np.abs(self.frame.position(name)).max(axis=-1) for name in self.frame.nodes]
        found = reduce(np.maximum, reach)
        return Numbers.of(np.where(found > 0.0, found, self.length), self.ndim, 0)

    @cached_property
    def edges(self) -> list[TreeJoint]:
        """Joints, then loops."""
        return self.joints + self.loops

    @cached_property
    def link_of(self) -> dict[int, int]:
        """By node that a link carries, the link's number."""
        return {joint.child: number for number, joint in enumerate(self.joints)}

    @cached_property
    def has_clearance(self) -> bool:
        """Whether some joint moves in a clearance."""
        return any(joint.clearance_directions for joint in self.edges)

    @cached_property
    def constraints(self) -> int:
        """Number of multipliers: of ideal components of loops."""
        return int((self.multipliers >= 0).sum())

    @cached_property
    def units(self) -> Index:
        """By unknown the number of what it is measured in together with others (free,): with the other displacements,
        or rotations, of its node, where these are along global axes; what a link has of its own is by itself.

        So is all where journals move in clearances: forces far below the rounding of others decide there.
        """
        out = np.arange(self.free)
        if self.has_clearance:
            return out
        for kind in (self.columns[:3, self.plain], self.columns[3:, self.plain]):
            inside = (kind >= 0) & (kind < self.free)
            first = np.where(inside, kind, self.free).min(axis=0)
            out[kind[inside]] = np.broadcast_to(first, kind.shape)[inside]
        return out

    @cached_property
    def plain_members(self) -> bool:
        """Whether members have their stiffness alone, and all loads are on nodes."""
        return all(stack.plain for stack in self.stacks) and not self.loads.offset_forces

    @cached_property
    def chains(self) -> list[list[int]]:
        """For every node the column of each coordinate that moves it: its parent's, then its own."""
        return chained(self.columns, self.joints)

    @cached_property
    def symmetric(self) -> bool:
        """Whether the loads have a potential: no moments, or rotation about one fixed axis."""
        moments = any(k >= 3 for _, k, _ in component_loads(self.topology))
        return not moments or len(self.components) < 6

    @cached_property
    def linked(self) -> list[NDArray[np.bool_]]:
        """By stack, which pieces end at a node that is attached to others."""
        return [np.asarray(~self.plain[stack.ends].all(axis=1)) for stack in self.stacks]

    @cached_property
    def gather(self) -> list[scipy.sparse.csr_matrix]:
        """By stack, the sum of end forces (12 n) over the nodes' components (6 nodes)."""
        out = []
        for stack in self.stacks:
            count = len(stack.ends)
            component = np.arange(12)[:, None]
            rows = (component % 6) * self.count + stack.ends.T[component[:, 0] // 6]
            shape = (6 * self.count, 12 * count)
            out.append(
                scipy.sparse.csr_matrix((np.ones(12 * count), (rows.reshape(-1), np.arange(12 * count))), shape=shape)
            )
        return out

    @cached_property
    def pattern(self) -> tuple[scipy.sparse.csr_matrix, Index, Index]:
        """Sum of the entries of all tangents, in the order of `blocks`, over the entries of the matrix; their rows and
        columns."""
        rows, columns = [np.zeros(0, dtype=np.int64)], [np.zeros(0, dtype=np.int64)]
        for block in self._blocks():
            pair = np.broadcast_arrays(block[:, None], block[None, :])
            rows.append(pair[0].reshape(-1))
            columns.append(pair[1].reshape(-1))
        row, column = np.concatenate(rows), np.concatenate(columns)
        used = np.flatnonzero((row != CONSTRAINED) & (column != CONSTRAINED))
        keys, place = np.unique(row[used] * self.size + column[used], return_inverse=True)
        total = scipy.sparse.csr_matrix((np.ones(len(used)), (place, used)), shape=(len(keys), len(row)))
        return total, keys // self.size, keys % self.size

    def _blocks(self) -> list[Index]:
        """Columns of the coordinates of each tangent: pieces between plain nodes, other pieces, weights, joints."""
        chains = [np.array(chain, dtype=np.int64) for chain in self.chains]
        out = []
        for stack, linked in zip(self.stacks, self.linked, strict=True):
            if not linked.all():
                ends = stack.ends[~linked]
                out.append(np.concatenate([self.columns[:, ends[:, 0]], self.columns[:, ends[:, 1]]]))
            out += [np.concatenate([chains[first], chains[second]]) for first, second in stack.ends[linked].tolist()]
        out += [chains[each.node] for each in self.loads.offset_forces]
        for joint in self.joints:
            out.append(self.columns[:, joint.child] if joint.parent == GROUND else chains[joint.child])
        for loop, constrained in zip(self.loops, self.multipliers.T, strict=True):
            first = chains[loop.parent] if loop.parent != GROUND else constrained[:0]
            out.append(np.concatenate([first, chains[loop.child], constrained]))
        return out


def _largest(values: Array) -> float:
    return float(np.abs(values).max(initial=0.0))


def _check(plan: Plan) -> None:
    """Refuse what has no meaning here yet a user can change."""
    for name, member in plan.frame.members.items():
        for _, k in member.element.releases:
            if k in (1, 2):
                raise FrameError(
                    f"member {name!r} slides across itself at an end (release {'uy' if k == 1 else 'uz'}): for large "
                    "displacement put a joint there that is free in this component"
                )
    for group in plan.topology.groups:
        if group.resists:
            name = plan.topology.pieces[group.pieces[0]].member
            if group.has_foundation:
                kind = plan.frame.members[name].element.title
                raise FrameError(
                    f"member {name!r} ({kind}) resists rigid motion, as what stands on something outside the frame "
                    "does: large displacement follows members that only their own deformation stresses: put springs "
                    "between nodes in its place"
                )
            raise FrameError(
                f"member {name!r} carries a force at rest, which would turn with it: for large displacement give it no "
                "force at rest, and load the frame instead"
            )


def chained(columns: Index, joints: Iterable[TreeJoint]) -> list[list[int]]:
    """For every node which of the columns (k, nodes) move it, by way of the joints in the order of their tree."""
    out: list[list[int]] = columns.T.tolist()
    for joint in joints:
        above = [] if joint.parent == GROUND else out[joint.parent]
        out[joint.child] = above + out[joint.child]
    return out
