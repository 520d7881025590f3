"""What acts on a moving linkage, as loads on its frame."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from ....framework.arm import crossed, transferred
from ....framework.batch import Array, rotated
from ....framework.batched.idle import work_of_loads
from ....framework.described.loads import cubic_line_load
from ....framework.dofs import FORCES
from ....framework.frame import Frame
from ....framework.protocol import LineElement
from ....framework.structure.topology import Topology
from ..poses.kinematics import Kinematics
from .actions import applied, centre_of, inertia_force, rotated_tensor
from .inertia import inertia, is_massive
from .nodes import Nodes

# By link: member, beam, start and end in the link's axes.
Pieces = dict[str, list[tuple[str, LineElement, Array, Array]]]


class Rule(NamedTuple):
    """Shares of a member's length at which its inertia force is taken, and what follows from its values there.

    The weights of the values in the mean along the member, and in that of their product with the share.
    """

    shares: tuple[float, ...]
    mean: tuple[float, ...]
    first: tuple[float, ...]


# Exact for a force that is linear along the member, and for a cubic.
LINEAR = Rule((0.0, 1.0), (1.0 / 2.0, 1.0 / 2.0), (1.0 / 6.0, 1.0 / 3.0))
CUBIC = Rule(
    (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0),
    (1.0 / 8.0, 3.0 / 8.0, 3.0 / 8.0, 1.0 / 8.0),
    (1.0 / 60.0, 3.0 / 40.0, 3.0 / 10.0, 13.0 / 120.0),
)


def add_loads(frame: Frame, motion: Kinematics, nodes: Nodes) -> None:
    """Loads, torques, forces of springs and dampers, and gravity."""
    for point, action in applied(motion):
        _put(frame, nodes.of(action.body, point), _there(motion, action.wrench))
    if np.any(motion.linkage.weight):
        frame.gravity(motion.linkage.weight)


def add_inertia_loads(frame: Frame, motion: Kinematics, nodes: Nodes, pieces: Pieces) -> None:
    """Inertia forces of the rigid motion (d'Alembert).

    Beams with a mass of their own carry ``-rho A a`` along their length: the acceleration varies linearly there, and
    with the area of a taper the product is a cubic. What this leaves of the link's inertia force and torque acts at the
    link's point nearest to its centre of mass: the rotary inertia of the sections, or the whole of a mass that was
    given.
    """
    for link in motion.linkage.links:
        whole = inertia_force(motion, link, centre_of(motion, link))
        rest = whole.wrench
        for member, beam, start, end in pieces.get(link, []):
            if is_massive(beam):
                rule = _rule(beam)
                forces = [_force(motion, link, beam, start, end, share) for share in rule.shares]
                _along(frame, member, forces)
                places = motion.position_on(link, start), motion.position_on(link, end)
                rest = rest - _resultant(rule, places, forces, whole.place)
        point = nodes.centre_node(motion.linkage, link, inertia(motion.linkage, link).centre)
        at = motion.position(point, link)
        _put(frame, nodes.of(link, point), _there(motion, transferred(rest, whole.place - at)))


def accelerate_idle(frame: Frame, motion: Kinematics, nodes: Nodes) -> None:
    """Let rods that can spin between two balls accelerate as all that they are loaded with makes them."""
    if not frame.idle:
        return
    topology = Topology.of(frame.copy(), cut=False)
    for joint, idle in frame.idle.items():
        own, link, axis = inertia(motion.linkage, idle.body), idle.body, idle.axis
        centre, on_axis = centre_of(motion, link), motion.linkage.joints[idle.joints[0]].point
        turning = crossed(axis, centre - motion.position(on_axis, link))
        moment = rotated(rotated_tensor(motion.axes(link), own.tensor), axis)
        about = own.mass * np.sum(turning**2, axis=-1) + np.sum(axis * moment, axis=-1)
        work, about = np.broadcast_arrays(work_of_loads(topology, joint), about)
        gain = np.divide(work, about, out=np.zeros(work.shape), where=about > 0.0)[..., None]
        push, twist = np.broadcast_arrays(own.mass[..., None] * gain * turning, gain * moment)
        point = nodes.centre_node(motion.linkage, link, own.centre)
        wrench = transferred(-np.concatenate([push, twist], axis=-1), centre - motion.position(point, link))
        _put(frame, nodes.of(link, point), _there(motion, wrench))


def _put(frame: Frame, node: str, wrench: Array) -> None:
    """Load a node with a force and moment (..., 6), but for components that are zero throughout."""
    given = {name: wrench[..., k] for k, name in enumerate(FORCES) if np.any(wrench[..., k])}
    if given:
        frame.load(node, **given)


def _rule(beam: LineElement) -> Rule:
    """Where the inertia force of a beam is to be taken; it is linear where the mass per length is even."""
    start, *others = (beam.mass_per_length(np.asarray(share)) for share in CUBIC.shares)
    return LINEAR if all(np.array_equal(start, other) for other in others) else CUBIC


def _along(frame: Frame, member: str, forces: Sequence[Array]) -> None:
    """Load a member with a force per length by its values at two stations or at four."""
    names = [k for k in range(3) if any(np.any(force[..., k]) for force in forces)]
    if names and len(forces) == len(LINEAR.shares):
        start, end = forces
        given: dict[str, Any] = {FORCES[k]: (start[..., k], end[..., k]) for k in names}
        frame.line_load(member, **given)
    elif names:
        cubic_line_load(frame, member, forces)


def _force(motion: Kinematics, link: str, beam: LineElement, start: Array, end: Array, share: float) -> Array:
    """Inertia force per length at a share of a beam's length, (..., 3)."""
    place = start * (1.0 - share) + end * share
    per_length = beam.mass_per_length(np.asarray(share))[..., None]
    return _there(motion, -per_length * motion.acceleration_on(link, place))


def _there(motion: Kinematics, vectors: Array) -> Array:
    """Vectors (..., n), zero where the pose is not assembled and has no results."""
    return vectors if motion.is_assembled.all() else np.where(motion.is_assembled[..., None], vectors, 0.0)


def _resultant(rule: Rule, places: tuple[Array, Array], forces: Sequence[Array], about: Array) -> Array:
    """Force and moment of a force per length between two places, by its values at the stations of a rule, (..., 6)."""
    start, end = places
    chord = end - start
    length = np.linalg.norm(chord, axis=-1)[..., None]
    mean, first = _weighted(rule.mean, forces), _weighted(rule.first, forces)
    moment = crossed(start - about, mean) + crossed(chord, first)
    force, moment = np.broadcast_arrays(length * mean, length * moment)
    return np.concatenate([force, moment], axis=-1)


def _weighted(weights: Sequence[float], forces: Sequence[Array]) -> Array:
    """Sum of forces, (..., 3)."""
    return np.asarray(sum(weight * force for weight, force in zip(weights, forces, strict=True)))


def loads_of(frame: Frame) -> tuple[object, ...]:
    """How many loads a frame has at nodes and on members, and which weight."""
    given = (frame.loads, frame.member_loads)
    weight = None if frame.weight is None else (frame.weight.shape, frame.weight.tobytes())
    return *(sum(map(len, loads.values())) for loads in given), weight
