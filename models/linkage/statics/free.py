"""Accelerations of the drives of a linkage under given drive forces: forward dynamics."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, finite, join
from ....framework.errors import FrameError
from .actions import whole_shape
from .frame import FramedPoses
from .reactions import reactions


def free_accelerations(motion: FramedPoses, forces: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """See `Motion.free_accelerations`."""
    driven = motion.linkage.drives
    for joint in forces:
        if joint not in driven:
            raise FrameError(f"force on joint {joint!r}, which is not driven: the drives are {', '.join(driven)}")
    if not driven:
        raise FrameError("free_accelerations: nothing drives the linkage: drive a joint with drive=True")
    known = {"the motion, its masses and loads": whole_shape(motion)}
    each = [_given(joint, forces.get(joint, 0.0), len(names)) for joint, names in driven.items()]
    for joint, given in zip(driven, each, strict=True):
        join(known, f"force on joint {joint!r}", given.shape[:-1])
    # drive accelerations count lengths in units of the linkage's size
    size = motion.mechanism.size
    units = [size if name.startswith("u") else 1.0 for names in driven.values() for name in names]
    unit, count = np.stack(np.broadcast_arrays(*units), axis=-1), len(units)
    rest, *pushed = _forces(motion, np.vstack([np.zeros(count), np.eye(count)]))
    mass = np.stack([force - rest for force in pushed], axis=-1)
    shape = np.broadcast_shapes(*(given.shape[:-1] for given in each))
    push = np.concatenate([np.broadcast_to(given, (*shape, given.shape[-1])) for given in each], axis=-1)
    scale = np.sqrt(np.abs(np.diagonal(mass, axis1=-2, axis2=-1)))
    if np.any(scale == 0.0):
        raise FrameError("free_accelerations: a drive moves nothing that has inertia: give the links masses")
    like = mass / scale[..., :, None] / scale[..., None, :]
    try:
        found = unit * np.linalg.solve(like, ((push - rest) / scale)[..., None])[..., 0] / scale
    except np.linalg.LinAlgError:
        raise FrameError(
            "free_accelerations: the drives can move so that nothing with inertia moves: give more links masses"
        ) from None
    cuts = np.cumsum([len(names) for names in driven.values()])[:-1]
    return dict(zip(driven, np.split(found, cuts, axis=-1), strict=True))


def _forces(motion: FramedPoses, accelerations: Array) -> Array:
    """Drive forces (k, ..., drives) at k sets of drive accelerations (k, drives)."""
    # the axis of the sets comes before all axes of masses and loads as well
    count, axes = len(accelerations), (1,) * len(whole_shape(motion))
    columns = [column.reshape(count, *axes) for column in accelerations.T]
    shape = count, *axes[len(motion.shape) :], *motion.shape
    drives = motion.drives._replace(accelerations=columns, full_shape=shape)
    found = reactions(replace(motion, drives=drives))
    return np.concatenate([found.drives[joint] for joint in motion.linkage.drives], axis=-1)


def _given(joint: str, force: ArrayLike, count: int) -> Array:
    array = finite(force, f"force on joint {joint!r}")
    if count == 1:
        return array[..., None]
    if array.ndim and array.shape[-1] not in (1, count):
        raise FrameError(f"force on joint {joint!r} has shape {array.shape}: its last axis must hold {count} numbers")
    return np.broadcast_to(array, (*array.shape[:-1], count))
