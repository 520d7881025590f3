"""What acts on the linkage of a page, and what it does, in parts between which a factor on the loads moves."""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from ....framework.batch import Array, rotated
from ..description.parts import GROUND
from ..statics.accuracy import accuracy
from ..statics.frame import FramedPoses
from ..statics.reactions import reactions
from ..statics.tangent import is_loaded as is_loaded_at_rest

# By quantity its values at all poses, (poses, 6) each.
Found = dict[str, Array]
# A quantity under all that acts, ``whole``, and under what acts beside the loads, ``beside``, where anything does.
Parts = dict[str, Array]


def moving(motion: FramedPoses) -> bool:
    """Whether inertia acts: a drive has a rate or an acceleration."""
    return any(np.any(each) for each in (*motion.drives.rates, *motion.drives.accelerations))


def is_loaded(motion: FramedPoses) -> bool:
    """Whether anything acts on the linkage."""
    return is_loaded_at_rest(motion) or moving(motion)


def without_loads(motion: FramedPoses) -> FramedPoses | None:
    """The same poses without the linkage's loads; None where nothing acts beside them, or there are none."""
    if not motion.linkage.loads:
        return None
    bare = copy(motion.linkage)
    bare.loads = []
    found = replace(motion, linkage=bare)
    return found if is_loaded(found) else None


def in_parts(motion: FramedPoses, found: Callable[[FramedPoses], Found]) -> dict[str, Parts]:
    """Quantities under all that acts, and under what acts beside the loads, between which they are linear.

    With the loads times a factor f a quantity is ``(1 - f) beside + f whole``; without `beside` it is zero there.
    """
    shape, other = motion.shape, without_loads(motion)
    beside = {} if other is None else found(other)
    parts: dict[str, Parts] = {}
    for name, value in found(motion).items():
        parts[name] = {"whole": np.broadcast_to(value, (*shape, 6))}
        if name in beside:
            parts[name]["beside"] = np.broadcast_to(beside[name], (*shape, 6))
    return parts


def displacement(motion: FramedPoses, point: str, link: str | None) -> dict[str, Parts] | None:
    """Displacement of the point by compliance, with the bound of its error; None where nothing deflects."""
    elastic = any(each.beams for each in motion.linkage.links.values()) or any(
        pair.stiffness is not None for pair in motion.linkage.joints.values()
    )
    if not elastic or not is_loaded(motion):
        return None

    def found(poses: FramedPoses) -> Found:
        solved = accuracy(poses, point, link, {}, inertia=moving(motion))
        return {"displacement": solved.compliance, "bound": solved.closed.error_bound(solved.point)}

    return in_parts(motion, found)


def joint_forces(motion: FramedPoses) -> dict[str, Parts]:
    """Forces of the joints on their second links."""
    if not is_loaded(motion):
        return {}

    def found(poses: FramedPoses) -> Found:
        return dict(reactions(poses).wrenches)

    return in_parts(motion, found)


def drive_forces(motion: FramedPoses) -> dict[str, dict[str, Any]]:
    """Forces and moments of the drives, one for each driven coordinate."""
    if not is_loaded(motion):
        return {}
    shape, other = motion.shape, without_loads(motion)
    whole, beside = reactions(motion).drives, {} if other is None else reactions(other).drives
    parts: dict[str, dict[str, Any]] = {}
    for joint, coordinates in motion.linkage.drives.items():
        for k, coordinate in enumerate(coordinates):
            name = joint if len(coordinates) == 1 else f"{joint}.{coordinate}"
            part = parts[name] = {
                "turns": coordinate[0] == "r",
                "whole": np.broadcast_to(whole[joint][..., k : k + 1], (*shape, 1)),
            }
            if beside:
                part["beside"] = np.broadcast_to(beside[joint][..., k : k + 1], (*shape, 1))
    return parts


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
    """Both ends of each spring."""
    ends = ((spring.first, spring.second) for spring in motion.linkage.springs)
    return [
        [np.broadcast_to(motion.position(point, link), (*motion.shape, 3))[..., axes] for link, point in both]
        for both in ends
    ]
