"""Loads, weights and inertia forces of a moving linkage as loads on its frame."""

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
from .link_builder import Pieces
from .nodes import Nodes


class Rule(NamedTuple):
    """Integration rule along a member, for its inertia force per length.

    Attributes
    ----------
    shares
        Stations, as fractions ξ of the member's length.
    mean
        Weights of the values there in the integral over ξ.
    first
        Weights in the integral of the value times ξ.
    """

    shares: tuple[float, ...]
    mean: tuple[float, ...]
    first: tuple[float, ...]


# exact for forces that are linear and cubic along the member
LINEAR = Rule((0.0, 1.0), (1.0 / 2.0, 1.0 / 2.0), (1.0 / 6.0, 1.0 / 3.0))
CUBIC = Rule(
    (0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0),
    (1.0 / 8.0, 3.0 / 8.0, 3.0 / 8.0, 1.0 / 8.0),
    (1.0 / 60.0, 3.0 / 40.0, 3.0 / 10.0, 13.0 / 120.0),
)


def add_loads(frame: Frame, motion: Kinematics, nodes: Nodes) -> None:
    """Add loads, torques, forces of springs and dampers, and gravity."""
    for point, action in applied(motion):
        _put(frame, nodes.of(action.body, point), _there(motion, action.wrench))
    if np.any(motion.linkage.weight):
        frame.gravity(motion.linkage.weight)


def add_inertia_loads(frame: Frame, motion: Kinematics, nodes: Nodes, pieces: Pieces) -> None:
    """Add the inertia forces of the rigid motion (d'Alembert).

    Beams with mass carry ``-rho A a`` along their length: the acceleration varies linearly, so that with the area of a
    taper the product is cubic. The remainder of the link's inertia force and torque acts at the link's point nearest to
    its centre of mass: that of the rotary inertia of the sections, or of all of a given mass.
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
    """Add the inertia forces of rods that spin between two spherical joints, accelerated by the loads on them."""
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
    """Load a node with a force and moment (..., 6), without the components that are zero everywhere."""
    given = {name: wrench[..., k] for k, name in enumerate(FORCES) if np.any(wrench[..., k])}
    if given:
        frame.load(node, **given)


def _rule(beam: LineElement) -> Rule:
    """Integration rule for the inertia force of a beam, which is linear if the mass per length is uniform."""
    start, *others = (beam.mass_per_length(np.asarray(share)) for share in CUBIC.shares)
    return LINEAR if all(np.array_equal(start, other) for other in others) else CUBIC


def _along(frame: Frame, member: str, forces: Sequence[Array]) -> None:
    """Load a member with a force per length, given by its values at two or four stations, (..., 3) each."""
    names = [k for k in range(3) if any(np.any(force[..., k]) for force in forces)]
    if names and len(forces) == len(LINEAR.shares):
        start, end = forces
        given: dict[str, Any] = {FORCES[k]: (start[..., k], end[..., k]) for k in names}
        frame.line_load(member, **given)
    elif names:
        cubic_line_load(frame, member, forces)


def _force(motion: Kinematics, link: str, beam: LineElement, start: Array, end: Array, share: float) -> Array:
    """Inertia force per length at a fraction of a beam's length, (..., 3)."""
    place = start * (1.0 - share) + end * share
    per_length = beam.mass_per_length(np.asarray(share))[..., None]
    return _there(motion, -per_length * motion.acceleration_on(link, place))


def _there(motion: Kinematics, vectors: Array) -> Array:
    """Vectors (..., n), set to zero at poses that are not assembled, which have no results."""
    return vectors if motion.is_assembled.all() else np.where(motion.is_assembled[..., None], vectors, 0.0)


def _resultant(rule: Rule, places: tuple[Array, Array], forces: Sequence[Array], about: Array) -> Array:
    """Resultant force, and moment about `about`, of a force per length between two places, (..., 6).

    `forces` are its values (..., 3) at the stations of `rule`.
    """
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
    """Number of loads of a frame at nodes and on members, and its weight, to tell whether its loads have changed."""
    given = (frame.loads, frame.member_loads)
    weight = None if frame.weight is None else (frame.weight.shape, frame.weight.tobytes())
    return *(sum(map(len, loads.values())) for loads in given), weight
