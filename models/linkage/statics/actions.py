"""What acts on the links of a moving linkage: weight, loads, springs, and inertia forces."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....framework.arm import crossed
from ....framework.batch import Array, Shape, joined, rotated
from ...newton_euler import Action
from ..description.parts import GROUND, LinkageSpring
from ..poses.kinematics import Kinematics
from .inertia import inertia


def applied(motion: Kinematics) -> Iterator[tuple[str, Action]]:
    """Loads, torques and spring forces on the moving links, each with the point at which it acts."""
    for load in motion.linkage.loads:
        if load.link != GROUND:
            point = load.point or motion.linkage.links[load.link].points[0]
            value = rotated(motion.axes(load.link), load.value) if load.follower else load.value
            yield point, Action(load.link, motion.position(point, load.link), value)
    for spring in motion.linkage.springs:
        line, force = tension(motion, spring)
        for (link, point), signed in ((spring.first, force), (spring.second, -force)):
            if link != GROUND:
                exerted = signed[..., None] * line
                wrench = np.concatenate([exerted, np.zeros_like(exerted)], axis=-1)
                yield point, Action(link, motion.position(point, link), wrench)


def whole_shape(motion: Kinematics) -> Shape:
    """Broadcast shape of the motion with masses, beams, loads, springs and gravity.

    Raises
    ------
    FrameError
        If they do not broadcast; it names those that differ.
    """
    linkage = motion.linkage
    given = [(f"the load on {load.point or load.link!r}", load.value[..., 0]) for load in linkage.loads]
    for spring in linkage.springs:
        name = f"the spring {spring.first[1]}-{spring.second[1]}"
        given += [(name, number) for number in (spring.stiffness, spring.length, spring.damping)]
    shapes = [(what, number.shape) for what, number in (*given, ("gravity", linkage.weight[..., 0]))]
    for name, link in linkage.links.items():
        shapes += [(f"a beam of link {name!r}", beam.shape) for beam in link.beams.values()]
        parts = (("mass", link.mass, 0), ("centre", link.centre, 1), ("inertia", link.inertia, 2))
        for what, number, trailing in parts:
            if number is not None:
                shapes.append((f"{what} of link {name!r}", number.shape[: number.ndim - trailing]))
    known = {"the motion": motion.shape}
    for what, shape in shapes:
        if shape:
            joined(what, shape, known)
            known[what] = np.broadcast_shapes(shape, known.get(what, ()))
    return np.broadcast_shapes(*known.values())


def tension(motion: Kinematics, spring: LinkageSpring) -> tuple[Array, Array]:
    """Unit vector from the first to the second end of a spring (..., 3), and its tension, damper included (...)."""
    ends = [(point, link) for link, point in (spring.first, spring.second)]
    chord = motion.position(*ends[1]) - motion.position(*ends[0])
    length = np.linalg.norm(chord, axis=-1)
    line = chord / np.where(length > 0.0, length, 1.0)[..., None]
    force = spring.stiffness * (length - spring.length)
    if np.any(spring.damping):
        speed = motion.velocity(*ends[1]) - motion.velocity(*ends[0])
        force = force + spring.damping * np.sum(speed * line, axis=-1)
    return line, force


def centre_of(motion: Kinematics, link: str) -> Array:
    """Centre of mass of a link, global, (..., 3)."""
    return motion.position_on(link, inertia(motion.linkage, link).centre)


def weight(motion: Kinematics, link: str, centre: Array) -> Action:
    """Weight of a link, at its centre of mass (..., 3)."""
    own = inertia(motion.linkage, link)
    force = own.mass[..., None] * motion.linkage.weight
    return Action(link, centre, np.concatenate([force, np.zeros_like(force)], axis=-1))


def inertia_force(motion: Kinematics, link: str, centre: Array) -> Action:
    """Inertia force and torque of a link about its centre of mass (..., 3), Eq. (1) and (2) of the accuracy paper.

    ``F = -m a``, ``T = -(I alpha + omega x I omega)``.
    """
    own = inertia(motion.linkage, link)
    tensor = rotated_tensor(motion.axes(link), own.tensor)
    spin, gain = motion.angular_velocity(link), motion.angular_acceleration(link)
    torque = rotated(tensor, gain) + crossed(spin, rotated(tensor, spin))
    force = own.mass[..., None] * motion.acceleration_on(link, own.centre)
    force, torque = np.broadcast_arrays(force, torque)
    return Action(link, centre, -np.concatenate([force, torque], axis=-1))


def kinetic_energy(motion: Kinematics) -> Array:
    """Kinetic energy of all links, (...)."""
    whole_shape(motion)
    total: Array = np.zeros(motion.shape)
    for link in motion.linkage.links:
        own = inertia(motion.linkage, link)
        speed, spin = motion.velocity_on(link, own.centre), motion.angular_velocity(link)
        turning = rotated(rotated_tensor(motion.axes(link), own.tensor), spin)
        total = total + 0.5 * (own.mass * np.sum(speed**2, axis=-1) + np.sum(spin * turning, axis=-1))
    return total


def rotated_tensor(axes: Array, tensor: Array) -> Array:
    """Inertia tensor in global axes, (..., 3, 3), symmetric to the last bit, from `tensor` in the given `axes`."""
    out: Array = axes @ tensor @ np.swapaxes(axes, -1, -2)
    return 0.5 * (out + np.swapaxes(out, -1, -2))
