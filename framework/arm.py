"""Rigid arms: force and moment at the start from those at the end, and motion of the end from that of the start.

Vectors are (..., 3), forces with moments and displacements with rotations (..., 6), in any precision. In a plane
vectors are (..., 2), vectors normal to it (..., 1), and forces with moments (..., 3).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Real = NDArray[Any]


def crossed(one: Real, other: Real) -> Real:
    """Cross product of vectors (..., 3): the sums of NumPy's, which on one vector takes five times as long."""
    if one.shape[-1] == 2:
        return np.asarray(one[..., :1] * other[..., 1:] - one[..., 1:] * other[..., :1])
    out = np.empty(np.broadcast_shapes(one.shape, other.shape), np.result_type(one, other))
    for k in range(3):
        i, j = (k + 1) % 3, (k + 2) % 3
        out[..., k] = one[..., i] * other[..., j] - one[..., j] * other[..., i]
    return out


def cross_matrix(vector: Real) -> Real:
    """Matrices (..., 3, 3) of the cross product with vectors (..., 3) from the left."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    rows = ((zero, -z, y), (z, zero, -x), (-y, x, zero))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def transferred(wrench: Real, arm: Real) -> Real:
    """Force and moment (..., 6) at the start of an arm (..., 3) from those at its end, or those of a plane."""
    shape, d = np.broadcast_shapes(wrench.shape[:-1], arm.shape[:-1]), arm.shape[-1]
    out = np.empty((*shape, wrench.shape[-1]), np.result_type(wrench, arm))
    out[..., :d] = wrench[..., :d]
    np.add(wrench[..., d:], crossed(arm, wrench[..., :d]), out=out[..., d:])
    return out


def transferred_along_x(wrench: Real, arm: Real) -> Real:
    """Force and moment (..., 6) at the start of an arm along x, of length (...), from those at its end."""
    along = np.zeros((*np.shape(arm), 3), np.result_type(arm, np.float64))
    along[..., 0] = arm
    return transferred(wrench, along)


def carried(motion: Real, arm: Real) -> Real:
    """Displacement and rotation (..., 6) of the end of a rigid arm (..., 3), from those of its start."""
    out = np.empty((*np.broadcast_shapes(motion.shape[:-1], arm.shape[:-1]), 6), np.result_type(motion, arm))
    np.add(motion[..., :3], crossed(motion[..., 3:], arm), out=out[..., :3])
    out[..., 3:] = motion[..., 3:]
    return out


def carrying(arm: Real) -> Real:
    """Matrices (..., 6, 6) of `carried`."""
    out = np.zeros((*arm.shape[:-1], 6, 6), np.result_type(arm, np.float64))
    out[..., range(6), range(6)] = 1.0
    out[..., :3, 3:] = -cross_matrix(arm)
    return out
