"""Outlines of the region that sampled paths of a point sweep."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

# Number of directions of tangents to a cloud of points, 4 degrees apart.
DIRECTIONS = 90


def swept(places: Array) -> list[Array]:
    """Outlines that together cover the sampled paths of a point.

    Each is convex and contains all samples at a pose and at the next one, with the straight lines between them. Its
    edges are tangents to the samples in `DIRECTIONS` directions.

    Parameters
    ----------
    places
        Positions (poses, n, 2); NaN where a sample has none at a pose.

    Returns
    -------
    list of ndarray
        Corners (k, 2) of each outline, in order; a pose without neighbours that have positions has its own outline.
    """
    there = np.asarray(np.isfinite(places).all(axis=-1).any(axis=-1))
    support_function = _support_function(places)
    pairs = np.flatnonzero(there[:-1] & there[1:])
    beside = np.append(False, there[:-1]) | np.append(there[1:], False)
    alone = np.flatnonzero(there & ~beside)
    return [
        *_corners(np.maximum(support_function[pairs], support_function[pairs + 1])),
        *_corners(support_function[alone]),
    ]


def _angles() -> Array:
    return np.asarray(2.0 * np.pi / DIRECTIONS * np.arange(DIRECTIONS))


def _support_function(places: Array) -> Array:
    """Support function of the samples in each direction, (poses, directions); -inf if there are none."""
    along = (places[..., 0] * np.cos(angle) + places[..., 1] * np.sin(angle) for angle in _angles())
    return np.stack([np.where(np.isnan(each), -np.inf, each).max(axis=1) for each in along], axis=1)


def _corners(support_function: Array) -> Array:
    """Intersections of each tangent with the next, (..., directions, 2)."""
    angles = _angles()
    cos, sin = np.cos(angles), np.sin(angles)
    after = np.roll(support_function, -1, axis=-1)
    x = support_function * np.roll(sin, -1) - after * sin
    y = after * cos - support_function * np.roll(cos, -1)
    return np.asarray(np.stack([x, y], axis=-1) / np.sin(2.0 * np.pi / DIRECTIONS))
