"""The four-bar as a linkage: placed by its closed form, with all results and figures of linkages."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import Array
from ..linkage.graphics.places import ReferencePoses
from ..linkage.linkage import Linkage
from .frame import POINTS, add_joints, add_links
from .kinematics import FourBarKinematics


def linkage(drawn: FourBarKinematics, clearance: Mapping[str, ArrayLike]) -> Linkage:
    """Describe the four-bar as a linkage; see `FourBar.linkage`.

    Parameters
    ----------
    drawn
        The four-bar where it is drawn, (...).
    clearance
        Radial clearance, (...), of some of the joints ``"B"``, ``"D"``, ``"E"``.
    """
    found = Linkage({point: drawn.position(point) for point in POINTS})
    add_links(found, drawn.four_bar)
    found.revolute("A", "ground", "crank", drive=True, reference=drawn.theta)
    add_joints(found, drawn.four_bar, clearance)
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
