"""Ranges and dead points of linkages that screws drive: many turns to one stroke, in closed form."""

import numpy as np
import pytest
from linkframe import Linkage
from linkframe.framework import FrameError
from linkframe.models.linkage.poses.configuration import Configurations
from linkframe.models.linkage.poses.motion_path import MotionPath
from numpy.testing import assert_allclose

TURN = 2.0 * np.pi


def rotation(seed: int) -> np.ndarray:
    vectors = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]
    return vectors * np.linalg.det(vectors)


def toggle(pitch: float, axes: np.ndarray) -> Linkage:
    """Two bars of sqrt(2), whose far end a screw pulls along x: at 2 in the reference configuration."""
    x, z = axes[:, 0], axes[:, 2]
    linkage = Linkage(A=(0, 0, 0), B=axes @ (1, 1, 0), C=2.0 * x)
    for link, points in {"ab": "AB", "bc": "BC", "nut": "C", "spindle": "C"}.items():
        linkage.link(link, *points)
    linkage.revolute("A", "ground", "ab", axis=z)
    linkage.revolute("B", "ab", "bc", axis=z)
    linkage.revolute("C", "bc", "nut", axis=z)
    linkage.prismatic("C", "ground", "nut", axis=x, name="slide")
    linkage.screw("C", "ground", "spindle", axis=x, pitch=pitch, name="screw", drive=True)
    linkage.revolute("C", "spindle", "nut", axis=x, name="bearing")
    return linkage


@pytest.mark.parametrize("pitch", [0.1, -0.02, 0.002])
@pytest.mark.parametrize("seed", [None, 1])
def test_a_toggle_that_a_screw_drives(pitch, seed):
    """The bars are stretched at ±2 sqrt(2), and lie on each other where C meets A."""
    linkage = toggle(pitch, np.eye(3) if seed is None else rotation(seed))
    places = np.array([-2.0 * np.sqrt(2.0), 0.0, 2.0 * np.sqrt(2.0)])
    turns = np.sort((places - 2.0) / pitch * TURN)
    found = linkage.dead_points("screw")
    assert_allclose([point.value for point in found], turns, rtol=1e-10)
    assert [point.change_point for point in found] == [False, True, False]
    reach = linkage.drive_range("screw")
    assert_allclose([reach.lower, reach.upper], turns[[0, 2]], rtol=1e-10)


@pytest.mark.parametrize("pitch", [0.05, 0.002])
def test_an_actuator_that_tilts(pitch):
    """A spindle between a motor at D and a nut on the arm: 1.5 - 1 to 1.5 + 1 long."""
    b = np.array([np.cos(1.2), np.sin(1.2), 0.0])
    span = b - (1.5, 0.0, 0.0)
    linkage = Linkage(A=(0, 0), B=b, D=(1.5, 0))
    for link, points in {"arm": "AB", "motor": "D", "spindle": "DB", "nut": "B"}.items():
        linkage.link(link, *points)
    linkage.revolute("A", "ground", "arm")
    linkage.revolute("D", "ground", "motor")
    linkage.revolute("D", "motor", "spindle", axis=span, name="drive", drive=True)
    linkage.screw("B", "spindle", "nut", axis=span, pitch=pitch, name="thread")
    linkage.revolute("B", "nut", "arm", name="pin")
    reach = linkage.drive_range("drive")
    lengths = np.linalg.norm(span) - np.array([reach.upper, reach.lower]) * pitch / TURN
    assert_allclose(lengths, (0.5, 2.5), rtol=1e-9)


RADIUS, HIGH, AHEAD = 0.3, 0.55, 0.66


def climbing(pitch: float) -> Linkage:
    """A crank on a screw, whose end moves a block by a rod."""
    radius, high, ahead = RADIUS, HIGH, AHEAD
    linkage = Linkage(A=(0, 0), B=(radius, 0), C=(radius + ahead, high))
    for link, points in {"crank": "AB", "rod": "BC", "block": "C"}.items():
        linkage.link(link, *points)
    linkage.screw("A", "ground", "crank", axis=(0, 0, 1), pitch=pitch, drive=True)
    linkage.spherical("B", "crank", "rod")
    linkage.spherical("C", "rod", "block")
    linkage.prismatic("C", "ground", "block", axis=(1, 0), name="slide")
    return linkage


def test_a_crank_on_a_screw_does_not_return_after_a_turn():
    """Its end climbs by the pitch at each turn, until the rod no longer reaches the block's line."""
    pitch, radius, high, ahead = 0.03, RADIUS, HIGH, AHEAD
    angle = np.linspace(0.0, 20.0 * TURN, 2_000_001)
    left = ahead**2 + high**2 - (high - radius * np.sin(angle)) ** 2 - (pitch * angle / TURN) ** 2
    assert_allclose(climbing(pitch).drive_range("A").upper, angle[np.argmax(left < 0.0)], rtol=1e-5)


def test_a_crank_that_climbs_too_slowly_is_not_told_to_go_on_for_ever(monkeypatch):
    """The rod stops it after thousands of turns, more than are followed."""
    monkeypatch.setattr("linkframe.models.linkage.poses.motion_path.LONGEST_WAY", 600)
    linkage = climbing(1e-4)
    for ask in (linkage.drive_range, linkage.dead_points):
        with pytest.raises(FrameError, match=r"'A' neither stops nor comes back in \+3\.\d+ turns, the 600 steps"):
            ask("A")


@pytest.mark.parametrize("reference", [0.0, 0.3])
def test_a_straight_way_is_not_followed_to_its_end(reference):
    linkage = Linkage(A=(0, 0), P=(1, 0))
    linkage.link("slider", "A", "P")
    linkage.prismatic("A", "ground", "slider", axis=(1, 0), reference=reference, drive=True)
    reach = linkage.drive_range("A")
    assert (reach.lower, reach.upper) == (-np.inf, np.inf)
    assert linkage.dead_points("A") == ()
    curve = MotionPath(Configurations(linkage, by_travel=True), ("A", linkage.joint("A").kind.coordinates[0]))
    assert len(curve.trace(curve.start).places) < 300


@pytest.mark.parametrize("pitch", [0.1, 1e-3, 1e-6, np.array([1e-2, 1e-6, -1e-4])])
def test_a_spindle_that_is_turned_by_its_nut_is_near_no_dead_point(pitch):
    """However fine its screw is: at bars of equal length, only where they lie on each other does C stand on A."""
    angles = np.array([-0.9, -0.3, 0.3, 0.25 * np.pi])

    def states(spindle: bool) -> list[str]:
        linkage = Linkage(A=(0, 0), B=(1, 1), C=(2, 0))
        for link, points in {"ab": "AB", "bc": "BC", "nut": "C"}.items():
            linkage.link(link, *points)
        linkage.revolute("A", "ground", "ab", drive=True)
        linkage.revolute("B", "ab", "bc")
        linkage.revolute("C", "bc", "nut")
        linkage.prismatic("C", "ground", "nut", axis=(1, 0), name="slide")
        if spindle:
            linkage.link("spindle", "C")
            linkage.screw("C", "ground", "spindle", axis=(1, 0, 0), pitch=pitch, name="screw")
            linkage.revolute("C", "spindle", "nut", axis=(1, 0, 0), name="bearing")
        found = linkage.move(A=angles.reshape(-1, *(1,) * len(linkage.shape))).status
        return np.array([text.partition(";")[0] for text in found.ravel()]).reshape(found.shape).T.tolist()

    alone = states(spindle=False)
    assert alone == ["regular", "regular", "regular", "singular (direct-kinematic, type II"]
    assert states(spindle=True) == (alone if np.ndim(pitch) == 0 else [alone] * 3)


@pytest.mark.parametrize("spline", [False, True])
def test_a_crank_that_turns_as_a_screw_does_is_followed_by_its_angle(spline):
    """On the screw itself, or on a spline of its spindle: until the rod, shorter than the crank, stands across."""
    radius, rod, high = 1.0, 0.6, 0.1
    linkage = Linkage(A=(0, 0), B=(radius, 0), C=(radius + np.sqrt(rod**2 - high**2), high))
    for link, points in {"crank": "AB", "rod": "BC", "block": "C", "spindle": "A"}.items():
        if spline or link != "spindle":
            linkage.link(link, *points)
    z = {"axis": (0, 0, 1)}
    linkage.screw("A", "ground", "spindle" if spline else "crank", pitch=1e-3, name="screw", drive=True, **z)
    if spline:
        linkage.prismatic("A", "spindle", "crank", name="spline", **z)
        linkage.revolute("A", "ground", "crank", name="bearing")
    linkage.cylindrical("B", "crank", "rod", **z)
    linkage.revolute("C", "rod", "block")
    linkage.prismatic("C", "ground", "block", axis=(1, 0), name="slide")
    reach = linkage.drive_range("screw")
    assert_allclose([reach.lower, reach.upper], np.arcsin([high - rod, high + rod]), rtol=1e-9)


@pytest.mark.parametrize("pitch", [1e-3, 1e-6, 3e-7, 1e-7])
@pytest.mark.parametrize("batch", [(), (1,), (2,)])
def test_a_screw_far_finer_than_the_linkage_only_follows(pitch, batch):
    """Two bars of sqrt(2) push a nut along x, whose screw turns millions of times: C is at twice their cosine."""
    pitches = np.full(batch, pitch)
    pitches = pitches if not batch else np.where(np.arange(batch[0]) > 0, 0.5, pitches)
    linkage = toggle(pitches, np.eye(3))
    linkage.screw("C", "ground", "spindle", axis=(1, 0, 0), pitch=pitches, name="screw", replace=True)
    linkage.revolute("A", "ground", "ab", drive=True, replace=True)
    angles = np.array([1e-3, 0.1, 0.5]).reshape(3, *(1,) * len(batch))
    motion = linkage.move(A=angles)
    assert (motion.status == "regular").all()
    wanted = np.broadcast_to(2.0 * np.sqrt(2.0) * np.cos(np.pi / 4.0 + angles), motion.shape)
    assert_allclose(motion.position("C")[..., 0], wanted, rtol=0.0, atol=1e-13)
    assert linkage.mobility().actual == 1
