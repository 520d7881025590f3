"""Transmission angle of a joint: the angle between the motion of its second link and the forces that can drive it."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.parts import GROUND
from ..poses.kinematics import Kinematics
from .equilibrium import Equilibrium

# Ratio to the largest singular value below which one counts as zero.
ZERO = 1e-9


def transmission_angle(motion: Kinematics, joint: str) -> Array:
    """Angle of transmission at a joint, (...); see `Motion.transmission_angle`.

    With the drives locked and the joint taken apart, its second link can move, which displaces its half of the joint in
    the directions V; and the links on the other side can take forces in the directions Y from the joint without moving.
    The angle µ is the complement of the smallest angle between V and Y,

        sin µ = max |v · y|   over unit v in V and y in Y

    For a coupler with pins at both ends Y is the line of the coupler; for a rocker V is perpendicular to the rocker.
    """
    pair = motion.linkage.joint(joint)
    if pair.second == GROUND:
        raise FrameError(f"joint {joint!r}: its second link is the ground, which it cannot move: choose another joint")
    equations = Equilibrium(motion)
    own_columns = equations.columns[list(equations.names).index(joint)]
    matrix = equations.matrix
    there = np.asarray(np.isfinite(matrix).all(axis=(-2, -1)))
    matrix = np.where(there[..., None, None], matrix, 0.0)
    driven = equations.rows[pair.second]
    joints = matrix[..., own_columns]
    rest = np.swapaxes(np.delete(matrix, own_columns, axis=-1), -1, -2)
    free = projector(rest)
    moving = np.swapaxes(joints[..., driven, :], -1, -2) @ free[..., driven, :]
    # forces of the joint that the other links can take do no work on their motions with the second link at rest
    stop = np.zeros((6, matrix.shape[-2]))
    stop[:, driven] = np.eye(6)
    others = projector(np.concatenate([rest, np.broadcast_to(stop, (*rest.shape[:-2], *stop.shape))], axis=-2))
    pushing = projector(others @ joints)
    # the direction of V nearest to Y, and its components in Y and perpendicular to it: accurate at 90 degrees as well
    # (Björck & Golub, Mathematics of Computation 27, 1973)
    nearest = np.linalg.svd(pushing @ column_space(moving))[2][..., 0, :, None]
    along = pushing @ nearest
    sine, cosine = (np.linalg.norm(each[..., 0], axis=-1) for each in (along, nearest - along))
    return np.where(there, np.arctan2(sine, cosine), np.nan)


def projector(matrix: Array) -> Array:
    """Projector (..., n, n) on the null space of matrices (..., m, n)."""
    return np.eye(matrix.shape[-1]) - np.linalg.pinv(matrix, rcond=ZERO) @ matrix


def column_space(matrix: Array) -> Array:
    """Projector (..., m, m) on the column space of matrices (..., m, n)."""
    return matrix @ np.linalg.pinv(matrix, rcond=ZERO)
