"""The four-bar as a frame: three bars and three joints, clamped at the drive."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...elements import Joint
from ...framework.frame import Frame
from ..linkage.description.elastic_axis import neighbours
from ..planar import rotation, vector
from .description import LINKS, FourBarDescription, check_joints
from .kinematics import FourBarKinematics

# Links of each joint, along the chain.
JOINT_LINKS = {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}
# Nodes of each joint, along the chain crank, coupler, rocker, ground.
JOINT_NODES = {"B": ("B.crank", "B.coupler"), "D": ("D.coupler", "D.rocker"), "E": ("E.rocker", "E")}
# Nodes at the points of the coupler.
COUPLER_NODES = {"B": "B.coupler", "P": "P", "D": "D.coupler"}


def frame(motion: FourBarKinematics, clearance: Mapping[str, ArrayLike] | None = None) -> Frame:
    """Describe the linkage at every pose as a frame of beams and joints.

    Links are bodies, in whose own axes their nodes do not move, so that a link's stiffness is the same at all poses.
    The drive holds the crank at A (the accuracy paper's clamped active joint).

    Bodies ``crank``, ``coupler``, ``rocker``; nodes ``A`` (fixed), ``B.crank``, ``B.coupler``, ``P``, ``D.coupler``,
    ``D.rocker``, ``E.rocker``, ``E`` (fixed); joints ``B``, ``D``, ``E`` with global axes; members ``crank``,
    ``coupler.1``, ``coupler.2``, ``rocker``. The coupler is the bar B-P-D, bent at P; if P lies on the line of B and D,
    to 0.01 rad, beyond one of them, the bar runs through the three in their order; if P is B or D, ``coupler.1`` is all
    of it.
    """
    gaps = clearance or {}
    check_joints(gaps, "clearance")
    built, four_bar = Frame(), motion.four_bar
    crank, _, rocker, ground = four_bar.lengths
    for link in LINKS:
        built.body(link, origin=vector(motion.origin(link)), axes=rotation(motion.direction(link)))
    built.node("A", _local(0.0), body="crank")
    built.node("B.crank", _local(crank), body="crank")
    places = _coupler_points(four_bar)
    for point, node in COUPLER_NODES.items():
        built.node(node, places[point], body="coupler")
    built.node("D.rocker", _local(rocker), body="rocker")
    built.node("E.rocker", _local(0.0), body="rocker")
    built.node("E", _local(ground))
    built.add("crank", four_bar.link_beam("crank"), "A", "B.crank")
    pieces = _pieces(four_bar, places)
    for index, ends in enumerate(pieces, start=1):
        built.add(f"coupler.{index}", four_bar.link_beam("coupler"), *(COUPLER_NODES[end] for end in ends))
    if len(pieces) == 1:
        built.rigid("D.coupler" if np.any(four_bar.point[0]) else "B.coupler", "P")
    built.add("rocker", four_bar.link_beam("rocker"), "D.rocker", "E.rocker")
    for joint, nodes in JOINT_NODES.items():
        stiffness, across = four_bar.joint_stiffness(joint), ("ux", "uy") if joint in gaps else None
        built.add(joint, Joint(stiffness, clearance=gaps.get(joint, 0.0), clearance_directions=across), *nodes)
    built.fix("A")
    built.fix("E")
    return built


def coupler_ends(four_bar: FourBarDescription) -> list[tuple[str, str]]:
    """Pairs of points between which the beams of the coupler run, as those of a link of any linkage, towards D."""
    return _pieces(four_bar, _coupler_points(four_bar))


def _coupler_points(four_bar: FourBarDescription) -> dict[str, NDArray[np.float64]]:
    """Points of the coupler in its own axes."""
    return {"B": _local(0.0), "P": _local(*four_bar.point), "D": _local(four_bar.lengths[1])}


def _pieces(four_bar: FourBarDescription, places: Mapping[str, NDArray[np.float64]]) -> list[tuple[str, str]]:
    (x, y), length = four_bar.point, four_bar.lengths[1]
    if not np.any(y) and any(np.all(x == place) for place in (0.0, length)):
        return [("B", "D")]
    ends = neighbours("coupler", list(places), places, None)
    return [(end, start) for start, end in reversed(ends)] if ends[0][0] == "D" else ends


def _local(x: ArrayLike, y: ArrayLike = 0.0) -> NDArray[np.float64]:
    return vector(np.asarray(x) + 1j * np.asarray(y))
