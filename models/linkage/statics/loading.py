"""What acts on a moving linkage, as loads on its frame."""

from __future__ import annotations

from typing import Any

import numpy as np

from ....framework.arm import crossed, transferred
from ....framework.batch import Array
from ....framework.dofs import FORCES
from ....framework.frame import Frame
from ....framework.protocol import LineElement
from ..poses.kinematics import Kinematics
from .actions import applied, inertia_force
from .inertia import inertia, is_massive
from .nodes import Nodes

# By link: member, beam, start and end in the link's axes.
Pieces = dict[str, list[tuple[str, LineElement, Array, Array]]]


def add_loads(frame: Frame, motion: Kinematics, nodes: Nodes) -> None:
    """Loads, torques, forces of springs and dampers, and gravity."""
    for action in applied(motion):
        assert action.point is not None
        _put(frame, nodes.of(action.link, action.point), _there(motion, action.wrench))
    if np.any(motion.linkage.weight):
        frame.gravity(motion.linkage.weight)


def add_inertia_loads(frame: Frame, motion: Kinematics, nodes: Nodes, pieces: Pieces) -> None:
    """Inertia forces of the rigid motion (d'Alembert).

    Beams with a mass of their own carry ``-rho A a`` along their length, taken to vary linearly. What this leaves of
    the link's inertia force and torque acts at the link's point nearest to its centre of mass: the rotary inertia of
    the sections, the curvature of ``rho A a`` in a taper, or the whole of a mass that was given.
    """
    for link in motion.linkage.links:
        whole = inertia_force(motion, link)
        rest = whole.wrench
        for member, beam, start, end in pieces.get(link, []):
            if is_massive(beam):
                forces = _force(motion, link, beam, start, 0.0), _force(motion, link, beam, end, 1.0)
                names = [k for k in range(3) if any(np.any(force[..., k]) for force in forces)]
                if names:
                    given: dict[str, Any] = {FORCES[k]: (forces[0][..., k], forces[1][..., k]) for k in names}
                    frame.line_load(member, **given)
                places = motion.position_on(link, start), motion.position_on(link, end)
                rest = rest - _resultant(places, forces, whole.place)
        point = nodes.centre_node(motion.linkage, link, inertia(motion.linkage, link).centre)
        at = motion.position(point, link)
        _put(frame, nodes.of(link, point), _there(motion, transferred(rest, whole.place - at)))


def _put(frame: Frame, node: str, wrench: Array) -> None:
    """Load a node with a force and moment (..., 6), but for components that are zero throughout."""
    given = {name: wrench[..., k] for k, name in enumerate(FORCES) if np.any(wrench[..., k])}
    if given:
        frame.load(node, **given)


def _force(motion: Kinematics, link: str, beam: LineElement, place: Array, fraction: float) -> Array:
    """Inertia force per length at one end of a beam, (..., 3)."""
    return _there(motion, -beam.mass_per_length(np.asarray(fraction))[..., None] * motion.acceleration_on(link, place))


def _there(motion: Kinematics, vectors: Array) -> Array:
    """Vectors (..., n), zero where the pose is not assembled and has no results."""
    return vectors if motion.is_assembled.all() else np.where(motion.is_assembled[..., None], vectors, 0.0)


def _resultant(places: tuple[Array, Array], forces: tuple[Array, Array], about: Array) -> Array:
    """Force and moment of a force per length that varies linearly from end to end, (..., 6)."""
    (start, end), (first, last) = places, forces
    chord, change, arm = end - start, last - first, start - about
    length = np.linalg.norm(chord, axis=-1)[..., None]
    moment = crossed(arm, first + change / 2.0) + crossed(chord, first / 2.0 + change / 3.0)
    force, moment = np.broadcast_arrays(length * (first + last) / 2.0, length * moment)
    return np.concatenate([force, moment], axis=-1)
