"""Directions distributed all around, in a plane and in space."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError

LEAST = 4


def circle(count: int) -> Array:
    """Evenly spaced directions in a plane, (count, 2).

    Raises
    ------
    FrameError
        If there are fewer than four.
    """
    angles = 2.0 * np.pi * np.arange(_checked(count)) / count
    return np.stack([np.cos(angles), np.sin(angles)], axis=-1)


def sphere(count: int) -> Array:
    """Nearly evenly spaced directions in space, on a spiral with the golden angle, (count, 3).

    Raises
    ------
    FrameError
        If there are fewer than four.
    """
    k = np.arange(_checked(count))
    z = 1.0 - (2.0 * k + 1.0) / count
    angle, radius = np.pi * (3.0 - np.sqrt(5.0)) * k, np.sqrt(1.0 - z * z)
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), z], axis=-1)


def _checked(count: int) -> int:
    if count < LEAST:
        raise FrameError(f"{count} directions were asked for: give {LEAST} or more")
    return count
