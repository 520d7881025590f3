"""Joint coordinates and their time derivatives, from the state or from the motion of a joint's links."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....framework import rotation
from ....framework.batch import Array
from ..description.parts import Pair
from .kinematics import Kinematics


def coordinate_of(motion: Kinematics, pair: Pair) -> Array:
    """Coordinates (..., f) of a joint."""
    shape, kind = motion.shape, pair.kind
    if pair.name in motion.mechanism.states and kind.name != "spherical":
        own = motion.assembly.state[motion.mechanism.states[pair.name]]
        moved = [np.broadcast_to(x, shape) for x in own]
        scales = [motion.mechanism.size if name[0] == "u" else 1.0 for name in kind.coordinates]
        columns = [np.where(motion.is_assembled, x * scale, np.nan) for x, scale in zip(moved, scales, strict=True)]
        return np.stack(columns, axis=-1) + pair.reference if columns else np.zeros((*shape, 0))
    first, second = (_product(motion.axes(link), pair.axes) for link in (pair.first, pair.second))
    rotated = _product(np.swapaxes(first, -1, -2), second)
    if kind.name == "spherical":
        before = rotation.exponential(_first(pair.reference, 1))
        turned = _product(rotated, np.moveaxis(rotation.matrix(before), (0, 1), (-2, -1)))
        # with an axis in front, so that sums of a single pose are those of a batch
        now = rotation.logarithm(rotation.of_matrix(_first(turned[None], 2)))
        return np.asarray(np.moveaxis(now, 0, -1)[0])
    difference = motion.position(pair.point, pair.second) - motion.position(pair.point, pair.first)
    shift = _product(difference[..., None, :], first)[..., 0, :]
    out = []
    for offset, name in enumerate(kind.coordinates):
        if name[0] == "u":
            out.append(shift[..., "xyz".index(name[1])])
        elif name == "rx":
            # about the second axis of a universal joint, in the axes of its second link
            out.append(_continued(motion, pair, offset, np.arctan2(rotated[..., 2, 1], rotated[..., 2, 2])))
        else:
            out.append(_continued(motion, pair, offset, np.arctan2(rotated[..., 1, 0], rotated[..., 0, 0])))
    return np.stack(out, axis=-1) + pair.reference if out else np.zeros((*shape, 0))


def some_coordinates(motion: Kinematics, joint: str, components: Sequence[str]) -> Array:
    """Those coordinates (..., f) of a joint that are named, such as the driven ones."""
    pair = motion.linkage.joint(joint)
    return np.asarray(coordinate_of(motion, pair)[..., pair.kind.places_of(components)])


def _product(a: Array, b: Array) -> Array:
    """Matrix product summed term by term, so that the result of a pose has the same bits in any batch."""
    return np.asarray(sum(a[..., k, None] * b[..., None, k, :] for k in range(3)))


def _first(array: Array, trailing: int) -> Array:
    """An array (..., components) as (components, ...)."""
    return np.moveaxis(array, range(-trailing, 0), range(trailing))


def _continued(motion: Kinematics, pair: Pair, offset: int, angle: Array) -> Array:
    """Angles (...) of a joint that closes a loop, given in [-π, π], with the whole turns made on the way to each pose.

    The turns are counted by the same linkage with the joint's coordinates in its state, in which each pose is reached
    on the same path. An angle that no path reaches is returned unchanged.
    """
    found = motion.counted(pair.name)
    counted = np.broadcast_to(found.state[found.loops.mechanism.states[pair.name].start + offset], motion.shape)
    turns = np.where(np.broadcast_to(found.reached, motion.shape), counted - angle, 0.0) / (2.0 * np.pi)
    return np.asarray(angle + 2.0 * np.pi * np.round(np.where(np.isfinite(turns), turns, 0.0)))


def rates_of_coordinate(motion: Kinematics, pair: Pair, order: int) -> Array:
    """First (order 0) or second (order 1) time derivative of a joint's coordinates, (..., f)."""
    kind, mechanism = pair.kind, motion.mechanism
    scales = [mechanism.size if name[0] == "u" else 1.0 for name in kind.coordinates]
    if pair.name in mechanism.velocities:
        own = motion.velocities[order][mechanism.velocities[pair.name]]
        columns = [np.where(motion.is_assembled, x * scale, np.nan) for x, scale in zip(own, scales, strict=True)]
        return np.stack(columns, axis=-1) if columns else np.zeros((*motion.shape, 0))
    return np.stack(_relative(motion, pair, order), axis=-1) if kind.coordinates else np.zeros((*motion.shape, 0))


def _relative(motion: Kinematics, pair: Pair, order: int) -> list[Array]:
    """Rates of a joint that closes a loop, from the relative motion of its links."""
    first = motion.axes(pair.first) @ pair.axes
    carrier, spin = motion.angular_velocity(pair.first), motion.angular_velocity(pair.second)
    omega = spin - carrier
    here = motion.position(pair.point, pair.second)
    base = _inverse(motion, pair.first, here)
    slide = motion.velocity(pair.point, pair.second) - motion._velocity_at(pair.first, base)
    if order:
        omega_up = motion.angular_acceleration(pair.second) - motion.angular_acceleration(pair.first)
        slide_up = motion.acceleration(pair.point, pair.second) - motion._acceleration_at(pair.first, base)
        slide = slide_up - 2.0 * np.cross(carrier, slide)
    out = []
    second_x = (motion.axes(pair.second) @ pair.axes)[..., 0]
    for name in pair.kind.coordinates:
        axis = first[..., "xyz".index(name[1])]
        moves = carrier
        if pair.kind.name == "universal" and name == "rx":
            axis, moves = second_x, spin
        if name[0] == "u":
            out.append(np.sum(axis * slide, axis=-1))
        elif order:
            out.append(np.sum(axis * omega_up + np.cross(moves, axis) * omega, axis=-1))
        else:
            out.append(np.sum(axis * omega, axis=-1))
    return out


def _inverse(motion: Kinematics, link: str, place: Array) -> Array:
    """Reference position of the point of a link that is now at the global position `place`."""
    return np.asarray(np.einsum("...ji,...j->...i", motion.axes(link), place - motion.origin(link)))
