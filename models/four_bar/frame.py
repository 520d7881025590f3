"""The four-bar's links and joints as those of a linkage, and its frame, which the builder of linkages makes of them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike

from ...elements.parameters import Real, shape_of
from ...framework.batch import Array
from ...framework.frame import Frame
from ..linkage.description.elastic_axis import Ends, neighbours
from ..linkage.description.linkage_description import LinkageDescription
from ..linkage.description.parts import GROUND, LinkageLink
from ..linkage.statics.link_builder import LinkBuilder, joint_element
from ..linkage.statics.nodes import Nodes
from ..planar import rotation, vector
from .description import LINKS, FourBarDescription, check_joints
from .kinematics import FourBarKinematics

POINTS = ("A", "B", "P", "D", "E")
# Links of each passive joint, along the chain.
JOINT_LINKS = {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}
ORIGIN = np.zeros(3)
ORIGIN.setflags(write=False)


def frame(motion: FourBarKinematics, clearance: Mapping[str, ArrayLike]) -> Frame:
    """Describe the linkage at every pose as a frame of beams and joints.

    Links are bodies, in whose own axes their nodes do not move, so that a link's stiffness is the same at all poses.
    The drive holds the crank at A (the accuracy paper's clamped active joint).

    Bodies ``crank``, ``coupler``, ``rocker``; nodes ``A`` (fixed), ``B.crank``, ``B.coupler``, ``P``, ``D.coupler``,
    ``D.rocker``, ``E.rocker``, ``E`` (fixed); joints ``B``, ``D``, ``E`` with global axes; members ``crank``,
    ``coupler.1``, ``coupler.2``, ``rocker``. The coupler is the bar B-P-D, bent at P; if P lies on the line of B and D,
    to 0.01 rad, beyond one of them, the bar runs through the three in their order; if P is B or D, ``coupler.1`` is all
    of it.
    """
    four_bar, places = motion.four_bar, _places(motion.four_bar)
    # of its points only the names are read: where they are is known in the axes of each link
    linkage = LinkageDescription(dict.fromkeys(POINTS, ORIGIN))
    add_links(linkage, four_bar)
    add_joints(linkage, four_bar, clearance)
    built = LinkBuilder(linkage, Frame(), _Names(linkage))
    for link in LINKS:
        built.add_link(link, vector(motion.origin(link)), rotation(motion.direction(link)), places[link])
    built.frame.fix("A")
    built.add_ground("E", places[GROUND]["E"])
    for pair in linkage.joints.values():
        ends = (built.nodes.of(link, pair.point) for link in (pair.first, pair.second))
        built.add_joint(pair.name, joint_element(pair, pair.full_stiffness, None, pair.clearance), *ends)
    return built.frame


def add_links(linkage: LinkageDescription, four_bar: FourBarDescription) -> None:
    """Add the links to a linkage that has the points."""
    linkage.link("crank", "A", "B", beam=four_bar.link_beam("crank"))
    linkage.link("coupler", "B", "P", "D", beam=four_bar.link_beam("coupler"), beams=coupler_ends(four_bar))
    linkage.link("rocker", "D", "E", beam=four_bar.link_beam("rocker"))


def add_joints(linkage: LinkageDescription, four_bar: FourBarDescription, clearance: Mapping[str, ArrayLike]) -> None:
    """Add the passive joints to a linkage that has the links."""
    check_joints(clearance, "clearance")
    for joint, links in JOINT_LINKS.items():
        stiffness = four_bar.joint_stiffness(joint)
        linkage.revolute(joint, *links, stiffness=stiffness, clearance=clearance.get(joint))


def coupler_ends(four_bar: FourBarDescription) -> list[Ends]:
    """Pairs of points between which the beams of the coupler run, as those of a link of any linkage, towards D."""
    (x, y), places = four_bar.point, _places(four_bar)["coupler"]
    if not np.any(y) and any(np.all(x == place) for place in (0.0, four_bar.coupler)):
        return [("B", "D")]
    ends = neighbours("coupler", list(places), places, None)
    return [(end, start) for start, end in reversed(ends)] if ends[0][0] == "D" else ends


def _places(four_bar: FourBarDescription) -> dict[str, dict[str, Array]]:
    """Positions of the points of each link in its axes, those of the coupler from B towards D."""
    crank, coupler, rocker, ground = four_bar.lengths
    x, y = (np.asarray(each, dtype=np.float64) for each in four_bar.point)
    return {
        "crank": {"A": ORIGIN, "B": _along(crank)},
        "coupler": {"B": ORIGIN, "P": _along(x, y), "D": _along(coupler)},
        "rocker": {"D": _along(rocker), "E": ORIGIN},
        GROUND: {"E": _along(ground)},
    }


def _along(x: Real, y: Real = 0.0) -> Array:
    place = np.zeros((*shape_of(x, y), 3))
    place[..., 0], place[..., 1] = x, y
    return place


class _Names(Nodes):
    """Names of the nodes and members of a four-bar's frame."""

    def of(self, link: str, point: str) -> str:
        """Node of a link's point; on the ground it has the name of the point."""
        return point if link == GROUND else super().of(link, point)

    def members(self, link: LinkageLink, count: int) -> list[str]:
        """Names of the members of a link; those of the coupler have a number also where it is one bar."""
        return ["coupler.1", "coupler.2"][:count] if link.name == "coupler" else super().members(link, count)
