"""Area and volume of Minkowski sums of convex bodies, and of hulls of points."""

from __future__ import annotations

from itertools import accumulate

import numpy as np

from ....framework.batch import Array
from .starts import sphere

# Number of segments whose sum stands for a disc, and for a ball, in volumes.
IN_DISC, IN_BALL = 16, 96
# Ratio of smallest to largest extent below which points lie in a plane.
FLAT = 1e-12


def area_of_sum(columns: Array, sizes: tuple[int, ...]) -> Array:
    """Area of the Minkowski sum of segments, ellipses and projected ellipsoids in a plane, (...).

    Parameters
    ----------
    columns
        Semi-axes of all bodies one after the other, (..., 2, n): images of the axes of intervals, discs and balls.
    sizes
        Number of semi-axes of each body.
    """
    bodies = _in_two(columns, sizes)
    (a, b), (c, d) = np.moveaxis(bodies, (-2, -1), (0, 1))
    adjugate = np.stack([np.stack([d, -b], axis=-1), np.stack([-c, a], axis=-1)], axis=-2)
    total = np.zeros(columns.shape[:-2])
    for own in range(len(sizes)):
        total = total + np.sum(_perimeter(adjugate[..., own, None, :, :] @ bodies[..., own:, :, :])[..., 1:], axis=-1)
        total = total + np.pi * np.abs(a * d - b * c)[..., own]
    return total


def _in_two(columns: Array, sizes: tuple[int, ...]) -> Array:
    """Bodies as images (..., bodies, 2, 2) of the unit disc."""
    out, start = np.zeros((*columns.shape[:-2], len(sizes), 2, 2)), 0
    for k, size in enumerate(sizes):
        own, start = columns[..., start : start + size], start + size
        if size > 2:
            own = np.swapaxes(np.linalg.qr(np.swapaxes(own, -1, -2), mode="r"), -1, -2)
        out[..., k, :, : own.shape[-1]] = own
    return out


def _perimeter(image: Array) -> Array:
    """Perimeter ``4 a E(1 - b^2 / a^2)`` of ellipses, images (..., 2, 2) of the unit disc; twice a segment's length."""
    from scipy.special import ellipe

    (p, q), (r, s) = np.moveaxis(image, (-2, -1), (0, 1))
    half, other = 0.5 * np.hypot(p + s, q - r), 0.5 * np.hypot(p - s, q + r)
    a, b = half + other, np.abs(half - other)
    ratio = b / np.where(a > 0.0, a, 1.0)
    return np.asarray(4.0 * a * ellipe(1.0 - ratio * ratio))


def volume_of_sum(columns: Array, sizes: tuple[int, ...]) -> Array:
    """Volume of the Minkowski sum of segments, ellipses and ellipsoids in space, (m,).

    Discs and balls are themselves sums of infinitely many segments. The volume of a sum of segments x is
    ``4/3 sum sum h(x_a x x_b)`` over all pairs, with the support function h of the whole (Schneider 2014, Eq. 5.82
    and section 3.5). Discs and balls are approximated by a finite number of segments, with an error of some 1e-4 of the
    volume, and of half a per cent if ellipses are slender.

    Parameters
    ----------
    columns
        Semi-axes of all bodies one after the other, (m, 3, n): images of the axes of intervals, discs and balls.
    sizes
        Number of semi-axes of each body.
    """
    starts = [0, *accumulate(sizes)]
    segments, owners = [], []
    for body, size in enumerate(sizes):
        segments.append(columns[..., starts[body] : starts[body + 1]] @ GENERATORS[size].T)
        owners += [body] * len(GENERATORS[size])
    x, owner = np.concatenate(segments, axis=-1), np.array(owners)
    first, second = np.triu_indices(len(owner), 1)
    pairs = np.cross(x[..., first], x[..., second], axis=-2)
    along = np.swapaxes(pairs, -1, -2) @ columns
    reach = np.sqrt(np.add.reduceat(along * along, starts[:-1], axis=-1)).sum(axis=-1)
    weight = np.where(owner[first] == owner[second], SAME[np.array(sizes)[owner[first]]], 1.0)
    return np.asarray(8.0 / 3.0 * (reach @ weight))


def area_within(points: Array) -> Array:
    """Area of convex polygons, (m,), whose corners (m, d, 2) are in counter-clockwise order."""
    x, y = np.moveaxis(points - points.mean(axis=-2, keepdims=True), -1, 0)
    return np.asarray(0.5 * np.sum(x * np.roll(y, -1, axis=-1) - y * np.roll(x, -1, axis=-1), axis=-1))


def volume_within(points: Array) -> Array:
    """Volume of the convex hulls of points (m, d, 3), (m,); 0 if they lie in a plane."""
    from scipy.spatial import ConvexHull

    out = np.zeros(len(points))
    for k, own in enumerate(points - points.mean(axis=-2, keepdims=True)):
        thick = np.linalg.svd(own, compute_uv=False)
        if thick[2] > FLAT * thick[0]:
            out[k] = thick[0] ** 3 * ConvexHull(own / thick[0]).volume
    return out


def _generators() -> dict[int, Array]:
    """By number of axes: segments, (k, axes), whose sum is an interval, or approximately a disc or a ball."""
    angles = np.pi * np.arange(IN_DISC) / IN_DISC
    disc = np.pi / (2.0 * IN_DISC) * np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    ball = 2.0 / IN_BALL * sphere(2 * IN_BALL)[:IN_BALL]
    return {1: np.ones((1, 1)), 2: disc, 3: ball}


def _same() -> Array:
    """By number of axes: factor on pairs of segments of one body, which makes their sum exact if h is isotropic."""
    out = np.ones(4)
    out[2] = np.pi / 2.0 / _crossed(GENERATORS[2])
    # the mean sine of the angle between two random directions in space is pi / 4
    out[3] = np.pi / _crossed(GENERATORS[3])
    return out


def _crossed(segments: Array) -> float:
    """Sum of the areas of the parallelograms of all ordered pairs."""
    flat = np.pad(segments, ((0, 0), (0, 3 - segments.shape[1])))
    return float(np.linalg.norm(np.cross(flat[:, None], flat[None, :]), axis=-1).sum())


GENERATORS = _generators()
SAME = _same()
