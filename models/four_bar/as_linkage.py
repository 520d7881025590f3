"""The four-bar as a linkage: placed by its closed form, with all results and figures of linkages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ..linkage.graphics.places import ReferencePoses
from ..linkage.linkage import Linkage
from .description import JOINTS, check_joints
from .frame import JOINT_LINKS, coupler_ends
from .kinematics import FourBarKinematics

POINTS = ("A", "B", "P", "D", "E")


def linkage(drawn: FourBarKinematics, clearance: Mapping[str, ArrayLike]) -> Linkage:
    """Describe the four-bar as a linkage; see `FourBar.linkage`.

    Parameters
    ----------
    drawn
        The four-bar where it is drawn, (...).
    clearance
        Radial clearance, (...), of some of the joints ``"B"``, ``"D"``, ``"E"``.
    """
    four_bar = drawn.four_bar
    check_joints(clearance, "clearance")
    found = Linkage({point: drawn.position(point) for point in POINTS})
    found.link("crank", "A", "B", beam=four_bar.link_beam("crank"))
    found.link("coupler", "B", "P", "D", beam=four_bar.link_beam("coupler"), beams=coupler_ends(four_bar))
    found.link("rocker", "D", "E", beam=four_bar.link_beam("rocker"))
    found.revolute("A", "ground", "crank", drive=True, reference=drawn.theta)
    for joint in JOINTS:
        stiffness = four_bar.joint_stiffness(joint)
        found.revolute(joint, *JOINT_LINKS[joint], stiffness=stiffness, clearance=clearance.get(joint))
    return found


@dataclass(frozen=True, eq=False)
class FourBarPoses(ReferencePoses):
    """The poses of a four-bar as those of a linkage, with what moves at its dead points.

    Attributes
    ----------
    motion
        The motion, (...).
    """

    motion: FourBarKinematics

    def free_velocity(self, point: str, link: str | None = None) -> Array:
        """See `DrawnPoses`."""
        return np.broadcast_to(self.motion.free_velocity(point), (*self.shape, 3))


def drawn(motion: FourBarKinematics) -> FourBarPoses:
    """The poses of a four-bar, singular ones as well, as figures of linkages take them.

    Parameters
    ----------
    motion
        The motion, (...).
    """
    return FourBarPoses(linkage(motion, {}), motion)
