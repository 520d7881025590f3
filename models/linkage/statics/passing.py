"""Whether large displacement takes a linkage through a singular configuration, towards another assembly mode."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework import rotation
from ....framework.batch import Array
from ....framework.large.solution import LargeSolution
from ..kinematics.linear import matrices
from ..kinematics.terms import Value
from ..poses.singular import SINGULAR
from .frame import FramedPoses
from .past import past

Bools = NDArray[np.bool_]
# Entries of a joint's rotation matrix whose ratio is the tangent of its angle about z, and of that about x.
ANGLES = {"rz": ((1, 0), (0, 0)), "rx": ((2, 1), (2, 2))}


def passes(motion: FramedPoses, found: LargeSolution) -> Bools:
    """Poses where the linkage passes a singular configuration on the way to its large displacement, (...).

    There the Jacobian determinant of the closing equations by the coordinates that are not driven, for one set of loops
    that close together, changes its sign. The deflected linkage enters through the angles and displacements in its
    joints.

    Parameters
    ----------
    motion
        The poses.
    found
        Their frame at large displacement.

    Returns
    -------
    ndarray
        (...), False at poses that are singular themselves, not assembled, or without an equilibrium.
    """
    linear = motion.assembly.loops.linear
    there = np.asarray((motion.conditioning >= SINGULAR) & found.converged)
    here, moved = (_entries(motion, state) for state in (motion.assembly.state, _displaced(motion, found)))
    if linear.signs or not linear.rank:
        return past(linear.determinants(here), linear.determinants(moved), there)
    n = linear.columns
    first, last = (matrices([each[i * n : i * n + n] for i in range(linear.rows)]) for each in (here, moved))
    known = [np.isfinite(each).all(axis=(-2, -1), keepdims=True) for each in (first, last)]
    left, _, right = np.linalg.svd(np.where(known[0], first, 0.0), full_matrices=False)
    left, right = left[..., : linear.rank], right[..., : linear.rank, :]
    inner = np.swapaxes(left, -1, -2) @ np.where(known[1], last, 0.0) @ np.swapaxes(right, -1, -2)
    return past([np.ones(())], [np.linalg.det(inner)], there)


def _entries(motion: FramedPoses, state: Sequence[Value]) -> list[Value]:
    """Jacobian of the closing equations by the coordinates that are not driven, row by row."""
    with np.errstate(all="ignore"):
        found = motion.mechanism.newton[1](state, motion.mechanism.parameters)
    return list(found[motion.assembly.loops.rows :])


def _displaced(motion: FramedPoses, found: LargeSolution) -> list[Value]:
    """State of the mechanism with the joints as they are at large displacement."""
    state, mechanism, nodes = list(motion.assembly.state), motion.mechanism, motion.bare.nodes
    for name, own in mechanism.states.items():
        pair = motion.linkage.joints[name]
        first = _turn(found, nodes.guide(pair)) @ motion.axes(pair.first) @ pair.axes
        second = _turn(found, nodes.on[pair.second][pair.point]) @ motion.axes(pair.second) @ pair.axes
        between = np.moveaxis(np.swapaxes(first, -1, -2) @ second, (-2, -1), (0, 1))
        if pair.kind.name == "spherical":
            state[own] = list(rotation.of_matrix(between))
            continue
        for place, component in enumerate(pair.kind.coordinates, start=own.start):
            if component in ANGLES:
                turn = np.arctan2(*(between[entry] for entry in ANGLES[component])) - state[place]
                state[place] = state[place] + np.arctan2(np.sin(turn), np.cos(turn))  # a screw counts its turns
            else:
                shift = found.joint_displacement(name)[..., "xyz".index(component[1])]
                state[place] = state[place] + shift / mechanism.size
    return state


def _turn(found: LargeSolution, node: str) -> Array:
    """Rotation matrix of a node's large rotation, (..., 3, 3)."""
    vector = np.moveaxis(found.displacement(node)[..., 3:], -1, 0)
    return np.moveaxis(rotation.matrix(rotation.exponential(vector)), (0, 1), (-2, -1))
