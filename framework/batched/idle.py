"""Idle rotations of bodies, such as of a link about the line between two ball joints.

A joint constrains them as long as that changes no result; they are set free where a load does work on them or something
else resists them.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from ..arm import carried
from ..batch import Array, rotated
from ..described.parts import IdleRotation
from ..description import Description
from ..errors import FrameError
from ..structure.assembly import nodal_loads
from ..structure.member_loads import applied_forces, equivalent, weight_forces
from ..structure.topology import Topology

# Work is rounding below _SUM times its summands, plus _PLACE times the largest coordinate times the forces.
_SUM, _PLACE = 1e-12, 8.0 * float(np.finfo(np.float64).eps)
# A moment of inertia about the idle axis is zero below this share of that about an axis across it.
_MASSLESS = 1e-16


def released(frame: Description, topology: Topology | None = None) -> Description:
    """Set free the idle rotations that something resists or on which a load does work: a copy, or the frame itself.

    Parameters
    ----------
    frame
        The description.
    topology
        The numbered frame, its members not divided; found anew where None.
    """
    if not frame.idle:
        return frame
    known = topology or Topology.of(frame.copy(), cut=False)
    return with_free(
        frame,
        [name for name, idle in frame.idle.items() if _is_resisted(frame, idle) or np.any(work_of_loads(known, name))],
    )


def released_at_rest(frame: Description, what: str) -> Description:
    """Set free the idle rotations that something resists: a copy, or the frame itself.

    Raises
    ------
    FrameError
        Where loads do work on an idle rotation that nothing resists, so that `what` has no equilibrium to start from.
    """
    free = with_free(frame, [name for name, idle in frame.idle.items() if _is_resisted(frame, idle)])
    if free.idle:
        known = Topology.of(free.copy(), cut=False)
        for name, idle in free.idle.items():
            moment = float(np.abs(work_of_loads(known, name)).max(initial=0.0))
            if moment > 0.0:
                raise FrameError(
                    f"{what}: the loads turn {idle.body!r} about the line between {' and '.join(idle.joints[:2])} with "
                    f"a moment of up to {moment:.6g}, which nothing resists: leave that moment out, or give one of "
                    "these joints a stiffness against turning"
                )
    return free


def released_masses(frame: Description) -> Description:
    """Set free the idle rotations that have inertia or that something resists: a copy, or the frame itself."""
    if not frame.idle:
        return frame
    known = Topology.of(frame.copy(), cut=False)
    return with_free(
        frame, [name for name, idle in frame.idle.items() if _is_resisted(frame, idle) or _has_inertia(known, name)]
    )


def with_free(frame: Description, joints: list[str]) -> Description:
    """A copy in which the idle rotations that these joints constrain are free; the frame itself for no joints."""
    if not joints:
        return frame
    clone = frame.copy()
    for name in joints:
        idle, joint = clone.idle.pop(name), clone.joints[name]
        if joint.element is not idle.constrained:
            continue  # the joint was changed since
        if idle.free is None:
            del clone.joints[name]
        else:
            clone.joints[name] = joint._replace(element=idle.free)
    return clone


def work_of_loads(topology: Topology, joint: str) -> Array:
    """Work of the loads on a unit idle rotation, the one that a joint constrains, (...); zero where it is rounding."""
    moved = _rotation(topology, joint)
    work: Array = np.zeros(())
    rounding: Array = np.zeros(())
    for node, wrench in _loads(topology, moved):
        work = work + np.sum(moved[node] * wrench, axis=-1)
        force, moment = (np.linalg.norm(part, axis=-1) for part in np.split(wrench, 2, axis=-1))
        reach = np.linalg.norm(moved[node][..., :3], axis=-1)
        rounding = rounding + _SUM * (reach * force + moment) + _PLACE * topology.frame.size * force
    return np.where(np.abs(work) > rounding, work, 0.0)


def _rotation(topology: Topology, joint: str) -> dict[int, Array]:
    """Displacements (..., 6) of a body's nodes, by number, in a unit idle rotation, the one that a joint constrains."""
    frame, idle = topology.frame, topology.frame.idle[joint]
    axes = frame.bodies[idle.body].axes
    own = {name: node.coordinates for name, node in frame.nodes.items() if node.body == idle.body}
    pivot = next(own[node] for node in (frame.joints[joint].first, frame.joints[joint].second) if node in own)
    spin = np.concatenate([np.zeros_like(idle.axis), idle.axis], axis=-1)
    return {topology.number[name]: carried(spin, rotated(axes, place - pivot)) for name, place in own.items()}


def _is_resisted(frame: Description, idle: IdleRotation) -> bool:
    """Whether anything besides the joints between which a body rotates connects it: supports, ties, members, joints."""

    def parted(first: str, second: str) -> bool:
        return (frame.nodes[first].body == idle.body) != (frame.nodes[second].body == idle.body)

    return (
        any(frame.nodes[node].body == idle.body for node in frame.supports)
        or any(parted(tie.master, tie.slave) for tie in frame.ties)
        or any(parted(member.start, member.end) for member in frame.members.values())
        or any(parted(*joint[1:]) for name, joint in frame.joints.items() if name not in idle.joints)
    )


def _loads(topology: Topology, moved: Mapping[int, Array]) -> Iterator[tuple[int, Array]]:
    """Forces and moments (..., 6) in global axes on the nodes in `moved`, those of member loads and weight included.

    Members between two nodes on the axis are skipped unless they are loaded: their weight does no work.
    """
    yield from ((node, wrench) for node, wrench in nodal_loads(topology) if node in moved)
    frame = topology.frame
    if frame.weight is None and not frame.member_loads:
        return
    away = {node for node, motion in moved.items() if np.abs(motion[..., :3]).max() > _PLACE * frame.size}
    for group in topology.groups:
        for position, number in enumerate(group.pieces.tolist()):
            piece, at = topology.pieces[number], np.array([position])
            if piece.nodes[0] in moved and (piece.member in frame.member_loads or not away.isdisjoint(piece.nodes)):
                forces = [*weight_forces(topology, group, at), *applied_forces(topology, group, position)]
                local = equivalent(group, at, iter(forces))[0]
                back = np.swapaxes(group.local_axes[position], -1, -2)
                yield from zip(piece.nodes, np.split(rotated(back, local), 2, axis=-1), strict=True)


def _has_inertia(topology: Topology, joint: str) -> bool:
    """Whether a body has a moment of inertia about its idle rotation, throughout the batch."""
    moved = _rotation(topology, joint)
    about: Array = np.zeros(())
    size: Array = np.zeros(())
    for matrix, motion in _masses(topology, moved):
        about = about + np.einsum("...i,...ij,...j->...", motion, matrix, motion)
        reach = np.linalg.norm(motion[..., :3], axis=-1)
        size = size + matrix[..., 0, 0] * (topology.frame.size + reach) ** 2
    return bool(np.all(about > _MASSLESS * size))


def _masses(topology: Topology, moved: Mapping[int, Array]) -> Iterator[tuple[Array, Array]]:
    """Mass matrices of what is on the nodes in `moved`, each with the displacements of its nodes in its own axes."""
    for point in topology.frame.masses.values():
        if (node := topology.number[point.node]) in moved:
            yield point.element.mass_matrix(), moved[node]
    for group in topology.groups:
        matrices = group.element.mass_matrix(group.length)
        for position, number in enumerate(group.pieces.tolist()):
            ends = topology.pieces[number].nodes
            if ends[0] in moved:
                local = [rotated(group.local_axes[position], moved[node]) for node in ends]
                yield matrices[position], np.concatenate(np.broadcast_arrays(*local), axis=-1)
