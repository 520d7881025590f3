"""The four-bar as a linkage: drawn by its closed form, with all that can be asked of one."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import ArrayLike

from ...framework.errors import FrameError
from .description import JOINTS
from .frame import JOINT_LINKS
from .kinematics import FourBarKinematics

if TYPE_CHECKING:
    from ..linkage.linkage import Linkage

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
    from ..linkage.linkage import Linkage  # with all the kinematics that the closed form has no use for

    four_bar = drawn.four_bar
    for joint in clearance:
        if joint not in JOINTS:
            raise FrameError(f"clearance of joint {joint!r}: the four-bar's passive joints are {', '.join(JOINTS)}")
    found = Linkage({point: drawn.position(point) for point in POINTS})
    pins = ("B", "D")
    x, y = (np.asarray(component) for component in four_bar.point)
    on_pin = not np.any(y) and any(np.all(x == place) for place in (0.0, four_bar.lengths[1]))
    found.link("crank", "A", "B", beam=four_bar.link_beam("crank"))
    parts = [pins] if on_pin else None
    found.link("coupler", "B", "P", "D", beam=four_bar.link_beam("coupler"), beams=parts)
    found.link("rocker", "D", "E", beam=four_bar.link_beam("rocker"))
    found.revolute("A", "ground", "crank", drive=True, reference=drawn.theta)
    for joint in JOINTS:
        stiffness = four_bar.joint_stiffness(joint)
        found.revolute(joint, *JOINT_LINKS[joint], stiffness=stiffness, clearance=clearance.get(joint))
    return found
