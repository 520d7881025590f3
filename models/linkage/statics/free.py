"""Accelerations of a linkage whose drives push with given forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, finite
from ....framework.errors import FrameError
from .reactions import reactions

if TYPE_CHECKING:
    from ..motion import Motion


def free_accelerations(motion: Motion, forces: Mapping[str, ArrayLike]) -> dict[str, Array]:
    """See `Motion.free_accelerations`."""
    driven = motion.linkage.drives
    for joint in forces:
        if joint not in driven:
            raise FrameError(f"force on joint {joint!r}, which is not driven: the drives are {', '.join(driven)}")
    # The motion counts lengths in units of the linkage's size.
    size = motion.mechanism.size
    unit = np.array([size if name.startswith("u") else 1.0 for names in driven.values() for name in names])
    rest, *pushed = _forces(motion, np.vstack([np.zeros(len(unit)), np.eye(len(unit))]))
    mass = np.stack([force - rest for force in pushed], axis=-1)
    each = [_given(joint, forces.get(joint, 0.0), len(names)) for joint, names in driven.items()]
    shape = np.broadcast_shapes(*(given.shape[:-1] for given in each))
    push = np.concatenate([np.broadcast_to(given, (*shape, given.shape[-1])) for given in each], axis=-1)
    scale = np.sqrt(np.abs(np.diagonal(mass, axis1=-2, axis2=-1)))
    if np.any(scale == 0.0):
        raise FrameError("free_accelerations: a drive moves nothing that has inertia: give the links masses")
    like = mass / scale[..., :, None] / scale[..., None, :]
    found = unit * np.linalg.solve(like, ((push - rest) / scale)[..., None])[..., 0] / scale
    cuts = np.cumsum([len(names) for names in driven.values()])[:-1]
    return dict(zip(driven, np.split(found, cuts, axis=-1), strict=True))


def _forces(motion: Motion, accelerations: Array) -> Array:
    """Drive forces at other accelerations of the drives (k, drives), (k, ..., drives)."""
    count, axes = len(accelerations), (1,) * len(motion.shape)
    columns = [column.reshape(count, *axes) for column in accelerations.T]
    drives = replace(motion.drives, accelerations=columns, full_shape=(count, *motion.shape))
    found = reactions(replace(motion, drives=drives))
    return np.concatenate([found.drives[joint] for joint in motion.linkage.drives], axis=-1)


def _given(joint: str, force: ArrayLike, count: int) -> Array:
    array = finite(force, f"force on joint {joint!r}")
    if count == 1:
        return array[..., None]
    return np.broadcast_to(array, (*array.shape[:-1], count))
