"""Loads on the linkage of a page and their effects, in two parts by which the page scales the loads."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, rotated
from ..description.joints import driven_name
from ..description.parts import GROUND
from ..statics.accuracy import accuracy, marked_status
from ..statics.frame import FramedPoses
from ..statics.reactions import Reactions, reactions
from ..statics.tangent import is_loaded as is_loaded_at_rest

# Values of quantities at all poses, (poses, n) each, by joint and coordinate or another pair of names.
Found = dict[tuple[str, str], Array]
# A quantity under all actions, ``whole``, and under all but the loads, ``beside``, if there are other actions.
Parts = dict[str, Array]


def moving(motion: FramedPoses) -> bool:
    """Whether inertia forces act, as a drive has a rate or an acceleration."""
    return any(np.any(each) for each in (*motion.drives.rates, *motion.drives.accelerations))


def is_loaded(motion: FramedPoses) -> bool:
    """Whether loads, springs, weight or inertia forces act on the linkage."""
    return is_loaded_at_rest(motion) or moving(motion)


def without_loads(motion: FramedPoses) -> FramedPoses | None:
    """The same poses without the linkage's loads; None if it has no loads, or nothing but loads acts on it."""
    if not motion.linkage.loads:
        return None
    bare = copy(motion.linkage)
    bare.loads = []
    found = replace(motion, linkage=bare)
    return found if is_loaded(found) else None


def in_parts(motion: FramedPoses, found: Callable[[FramedPoses], Found]) -> dict[tuple[str, str], Parts]:
    """Quantities under all actions, and under all but the loads.

    With the loads multiplied by f a quantity is ``(1 - f) beside + f whole``, where a missing `beside` is zero.
    """
    shape, other = motion.shape, without_loads(motion)
    beside = {} if other is None else found(other)
    parts: dict[tuple[str, str], Parts] = {}
    for name, value in found(motion).items():
        parts[name] = {"whole": np.broadcast_to(value, (*shape, value.shape[-1]))}
        if name in beside:
            parts[name]["beside"] = np.broadcast_to(beside[name], (*shape, value.shape[-1]))
    return parts


def deflects(motion: FramedPoses) -> bool:
    """Whether something is elastic, and something acts on it."""
    elastic = any(each.beams for each in motion.linkage.links.values()) or any(
        pair.stiffness is not None for pair in motion.linkage.joints.values()
    )
    return elastic and is_loaded(motion)


def status(motion: FramedPoses, point: str, link: str | None) -> NDArray[np.str_]:
    """Status of the poses, marked where the displacement by compliance under all that acts is not linear, (poses,)."""
    if not deflects(motion):
        return np.broadcast_to(motion.status, motion.shape)
    return marked_status(motion, accuracy(motion, point, link, {}, inertia=moving(motion)).closed)


def displacement(motion: FramedPoses, point: str, link: str | None) -> dict[str, Parts] | None:
    """Displacement of the point by compliance, with the bound of its error; None where nothing deflects."""
    if not deflects(motion):
        return None

    def found(poses: FramedPoses) -> Found:
        solved = accuracy(poses, point, link, {}, inertia=moving(motion))
        return {("displacement", ""): solved.compliance, ("bound", ""): solved.closed.error_bound(solved.point)}

    return {name: part for (name, _), part in in_parts(motion, found).items()}


def forces_of_joints_and_drives(motion: FramedPoses) -> tuple[dict[str, Parts], dict[str, dict[str, Any]]]:
    """Forces of the joints on their second links; forces and moments of the drives, by driven coordinate."""
    if not is_loaded(motion):
        return {}, {}
    joints, drives = dict[str, Parts](), dict[str, dict[str, Any]]()
    parts = in_parts(motion, lambda poses: _forces(reactions(poses)))
    for joint in motion.linkage.joints:
        joints[joint] = parts[joint, ""]
    for joint, driven in motion.linkage.drives.items():
        for coordinate in driven:
            name = driven_name(joint, coordinate, driven)
            drives[name] = {"turns": coordinate[0] == "r", **parts[joint, coordinate]}
    return joints, drives


def _forces(found: Reactions) -> Found:
    """Wrenches of joints, and the force on each driven coordinate."""
    forces: Found = {(joint, ""): wrench for joint, wrench in found.wrenches.items()}
    for joint, pushes in found.drives.items():
        for k, coordinate in enumerate(found.motion.linkage.drives[joint]):
            forces[joint, coordinate] = pushes[..., k : k + 1]
    return forces


def drawn_loads(motion: FramedPoses, axes: list[int]) -> list[dict[str, Any]]:
    """Forces at points of links, to be drawn as arrows."""
    found = []
    for load in motion.linkage.loads:
        if load.link == GROUND or load.point is None:
            continue
        value = rotated(motion.axes(load.link), load.value) if load.follower else load.value
        force = np.broadcast_to(value[..., :3], (*motion.shape, 3))[..., axes]
        if np.any(force):
            found.append({"place": motion.position(load.point, load.link)[..., axes], "force": force})
    return found


def drawn_springs(motion: FramedPoses, axes: list[int]) -> list[list[Array]]:
    """Positions of both ends of each spring, (poses, axes) each."""
    ends = ((spring.first, spring.second) for spring in motion.linkage.springs)
    return [
        [np.broadcast_to(motion.position(point, link), (*motion.shape, 3))[..., axes] for link, point in both]
        for both in ends
    ]
