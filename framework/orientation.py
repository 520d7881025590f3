"""Local axes of a member."""

from __future__ import annotations

from typing import Any

import numpy as np

from .batch import Array
from .errors import FrameError

PARALLEL = 1e-8
# Of more numbers the first is looked at before all others.
_FEW = 2**10


def default_axes(chord: Array) -> Array:
    """Axes with z as near to global z as can be; rows x, y, z, (..., 3, 3).

    A member along global z has its local y along global y. Local y is always level, so that a
    member in a plane of constant global z has exact zeros out of that plane.
    """
    numbers = default_axis_numbers(chord)
    first = np.asarray(numbers[0])
    shape = first.shape
    axes = np.empty((*shape, 9), first.dtype)
    for k, number in enumerate(numbers):
        axes[..., k] = number
    return axes.reshape(*shape, 3, 3)


def default_axis_numbers(chord: Array) -> list[Array | float]:
    """The nine numbers of `default_axes`, row by row, each (...); that which is zero for every member is a float."""
    chord = np.asarray(chord)
    if chord.dtype != np.float64:
        chord = chord.astype(np.result_type(chord, np.float64), copy=False)
    x, y, z = chord[..., 0], chord[..., 1], chord[..., 2]
    horizontal = np.hypot(x, y)
    # in a plane of constant z the length is the former to the last bit, and took a third of the time
    plane = (z.size < _FEW or z.flat[0] == 0.0) and not np.count_nonzero(z)
    length = horizontal if plane else np.hypot(horizontal, z)
    if np.count_nonzero(horizontal) == horizontal.size:
        return level_axis_numbers(x, y, z, horizontal, length)
    upright = horizontal == 0.0
    found = level_axis_numbers(x, y, z, np.where(upright, 1.0, horizontal), length)
    found[4], found[6] = np.where(upright, 1.0, found[4]), np.where(upright, -np.sign(z), found[6])
    found[8] = horizontal / length
    return found


def level_axis_numbers(x: Any, y: Any, z: Any, horizontal: Any, length: Any) -> list[Any]:
    """The nine numbers of `default_axes` of members none of which is along global z.

    Parameters
    ----------
    x, y, z
        Components of the chord: arrays (...), or terms of a recording, 0.0 for one that is zero for every member.
    horizontal, length
        Length of the chord's projection on the plane of x and y, and of the chord; one object where they are the same.
    """
    forwards, across = x / horizontal, y / horizontal
    if length is horizontal:
        upwards = 1.0 if type(z) is float else horizontal / length
        return [forwards, across, z, -across, forwards, 0.0, z, z, upwards]
    climb, sideways = z / length, -across
    along = [x / length, y / length, climb]
    return [*along, sideways, forwards, 0.0, -climb * forwards, climb * sideways, horizontal / length]


def axes_towards(chord: Array, up: Array) -> Array:
    """Axes with z as near to `up` (..., 3) as can be; rows x, y, z, (..., 3, 3).

    Raises
    ------
    FrameError
        If `up` is parallel to the member.
    """
    x = chord / np.linalg.norm(chord, axis=-1, keepdims=True)
    across = np.cross(up, x)
    size = np.linalg.norm(across, axis=-1, keepdims=True)
    if np.any(size <= PARALLEL * np.linalg.norm(up, axis=-1, keepdims=True)):
        given = tuple(float(part) for part in np.reshape(up, (-1, 3))[0])
        raise FrameError(f"Beam: up = {given} is parallel to the member; give a direction across it")
    # rounding leaves a part along x, which matters most if `up` is almost parallel to it
    across = across - np.sum(across * x, axis=-1, keepdims=True) * x
    y = across / np.linalg.norm(across, axis=-1, keepdims=True)
    return np.stack(np.broadcast_arrays(x, y, np.cross(x, y)), axis=-2)
