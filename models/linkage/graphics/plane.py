"""The plane in which a linkage moves."""

from __future__ import annotations

import numpy as np

from ....framework.graphics.scene import beside
from ..kinematics.extent import extent
from .places import DrawnPoses

# Motion out of the plane that counts as rounding, as a share of the linkage's size.
ROUNDING = 1e-9


def plane(motion: DrawnPoses) -> tuple[int, int] | None:
    """The two global axes of the plane in which all links move, x before y before z; None for motion in space.

    Over all poses, all points keep their distance from it and all links rotate about its normal only. If several planes
    are possible, that of x and y comes first.
    """
    size = extent(motion.linkage)
    there = motion.is_assembled
    for across in (2, 1, 0):
        turns = (motion.axes(link)[..., across] for link in motion.linkage.links)
        normal = np.eye(3)[across]
        if any(np.any(np.abs(turn - normal)[there] > ROUNDING) for turn in turns):
            continue
        moved = (motion.origin(link)[..., across] for link in motion.linkage.links)
        if all(np.all(np.abs(away)[there] <= ROUNDING * size) for away in moved):
            return beside(across)
    return None
