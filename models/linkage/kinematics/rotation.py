"""Rotations of a ball: rotation vectors, unit quaternions (Euler parameters), matrices."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array


def quaternion(vector: Array) -> Array:
    """Unit quaternion (..., 4), scalar first, of a rotation vector (..., 3)."""
    angle = np.linalg.norm(vector, axis=-1, keepdims=True)
    # sin(x/2)/x, which np.sinc gives without dividing by zero
    return np.concatenate([np.cos(0.5 * angle), 0.5 * np.sinc(0.5 * angle / np.pi) * vector], axis=-1)


def quaternion_product(p: Array, q: Array) -> Array:
    """Product of quaternions (..., 4): first the rotation q, then p."""
    a, b, c, d = np.moveaxis(p, -1, 0)
    e, f, g, h = np.moveaxis(q, -1, 0)
    parts = (
        a * e - b * f - c * g - d * h,
        a * f + b * e + c * h - d * g,
        a * g - b * h + c * e + d * f,
        a * h + b * g - c * f + d * e,
    )
    return np.stack(parts, axis=-1)


def rotation_vector(matrix: Array) -> Array:
    """Rotation vector (..., 3), of an angle in [0, π], of a rotation matrix (..., 3, 3).

    By way of the quaternion, whose largest component is taken from the diagonal (Shepperd 1978).
    """
    m = matrix
    diagonal = np.stack([m[..., 0, 0], m[..., 1, 1], m[..., 2, 2]], axis=-1)
    trace = diagonal.sum(axis=-1, keepdims=True)
    four = np.concatenate([1.0 + trace, 1.0 - trace + 2.0 * diagonal], axis=-1)
    off = {
        (0, 1): m[..., 2, 1] - m[..., 1, 2],
        (0, 2): m[..., 0, 2] - m[..., 2, 0],
        (0, 3): m[..., 1, 0] - m[..., 0, 1],
        (1, 2): m[..., 0, 1] + m[..., 1, 0],
        (1, 3): m[..., 0, 2] + m[..., 2, 0],
        (2, 3): m[..., 1, 2] + m[..., 2, 1],
    }
    rows = [np.stack([four[..., i] if i == j else off[min(i, j), max(i, j)] for j in range(4)], -1) for i in range(4)]
    best = np.argmax(four, axis=-1)[..., None, None]
    q = np.take_along_axis(np.stack(rows, axis=-2), best, axis=-2)[..., 0, :]
    q = q / np.linalg.norm(q, axis=-1, keepdims=True)
    q = q * np.where(q[..., :1] < 0.0, -1.0, 1.0)
    sine = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    angle = 2.0 * np.arctan2(sine, q[..., :1])
    return np.asarray(q[..., 1:] * np.where(sine > 0.0, angle / np.where(sine > 0.0, sine, 1.0), 2.0))


def rotation_matrix(q: Array) -> Array:
    """Matrix (..., 3, 3) of a unit quaternion (..., 4)."""
    a, b, c, d = np.moveaxis(q, -1, 0)
    rows = (
        (a * a + b * b - c * c - d * d, 2.0 * (b * c - a * d), 2.0 * (b * d + a * c)),
        (2.0 * (b * c + a * d), a * a + c * c - b * b - d * d, 2.0 * (c * d - a * b)),
        (2.0 * (b * d - a * c), 2.0 * (c * d + a * b), a * a + d * d - b * b - c * c),
    )
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)
