"""The joint that is at its dead point, found from the motions that remain with the drives locked."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.arm import transferred
from ....framework.batch import Array
from ....framework.program.source import Function
from ..description.parts import GROUND
from ..kinematics.mechanism import Mechanism
from ..kinematics.terms import Value

# Ratio to the largest speed above which a link or joint counts as moving.
MOVES = 1e-6


def moving_joints(
    mechanism: Mechanism, state: Sequence[Value], parameters: Sequence[Value], velocities: Sequence[Value]
) -> NDArray[np.str_]:
    """Name of the joint that is at its dead point, for each pose, (k,).

    It is the fastest of the moving joints both of whose links move; if there is none, the fastest of all joints. For a
    four-bar with its crank locked it is the joint between coupler and rocker. If several motions are possible, speeds
    are taken over all of them.

    Parameters
    ----------
    mechanism
        The linkage.
    state, parameters
        Entries of its state and dimensions, (k,) or for all the same.
    velocities
        Entries of its velocity coordinates in each possible motion, orthonormal, (k, motions).
    """
    shape = np.broadcast_shapes(*(np.shape(x) for x in velocities))
    state, parameters = (
        [np.asarray(x)[:, None] if np.ndim(x) else x for x in entries] for entries in (state, parameters)
    )

    def rows(program: Function, each: int, *inputs: Sequence[Value]) -> list[Array]:
        found = [np.broadcast_to(x, shape) for x in program(*inputs)]
        return [np.stack(found[k : k + each], axis=-1) for k in range(0, len(found), each)]

    still = [0.0] * len(velocities)
    at = {GROUND: (np.zeros((*shape, 3)), np.zeros((*shape, 6)))}
    places = rows(mechanism.poses[1], 12, state, parameters)
    speeds = rows(mechanism.rates[1], 12, state, parameters, velocities, still)
    for link, place, speed in zip(mechanism.linkage.links, places, speeds, strict=True):
        at[link] = place[..., :3], speed[..., :6]
    least = MOVES * np.max([_size(speed) for _, speed in at.values()], axis=0)
    rates, holds = [], []
    names = sorted(mechanism.linkage.joints)
    for name, point in zip(names, rows(mechanism.joint_points[1], 3, state, parameters), strict=True):
        joint = mechanism.linkage.joints[name]
        first, second = (_velocity(*at[link], point) for link in (joint.first, joint.second))
        released = [_size(at[link][1]) > least for link in (joint.first, joint.second)]
        rates.append(_size(second - first))
        holds.append(~(released[0] & released[1] & (rates[-1] > least)))
    rate = np.array(rates) * np.where(holds, MOVES, 1.0)
    # among joints that are equally fast within rounding, the first by name
    best = np.argmax(rate >= (1.0 - MOVES) * rate.max(axis=0), axis=0)
    return np.asarray(np.array(names)[best])


def _size(speed: Array) -> Array:
    """Norm (k,) of speeds (k, motions, 6) over all motions; it does not depend on the basis of the motions."""
    return np.asarray(np.sqrt((speed**2).sum(axis=(-2, -1))))


def _velocity(origin: Array, speed: Array, point: Array) -> Array:
    """Angular velocity and velocity (..., 6) of a link at a point."""
    return transferred(speed, origin - point)
