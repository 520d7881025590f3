"""Use at the edges: other drives than drawn, none, no poses, jumps and returns, poses out of reach in between."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose

PLACES = {"A": (0.0, 0.0), "B": (1.0, 1.5), "C": (4.5, 3.0), "P": (2.5, 3.5), "D": (4.0, 0.0)}
PINS = {"A": ("ground", "crank"), "B": ("crank", "coupler"), "C": ("coupler", "rocker"), "D": ("ground", "rocker")}


def four_bar(drive: str | None = "A", size: float = 1.0) -> Linkage:
    linkage = Linkage({name: size * np.array(place) for name, place in PLACES.items()})
    for name, points in {"crank": "AB", "coupler": "BPC", "rocker": "CD"}.items():
        linkage.link(name, *points, mass=1.0)
    for joint, links in PINS.items():
        linkage.revolute(joint, *links, drive=joint == drive)
    linkage.gravity((0, -9.81))
    return linkage


def length(ends: str) -> float:
    return float(np.hypot(*np.subtract(PLACES[ends[0]], PLACES[ends[1]])))


def angle_at(one: float, other: float, opposite: np.ndarray | float) -> np.ndarray:
    return np.arccos((one**2 + other**2 - np.asarray(opposite) ** 2) / (2 * one * other))


def test_range_of_a_joint_that_does_not_drive():
    """The angle at C is greatest and least where crank and ground lie in line."""
    b, c = length("BC"), length("CD")
    ends = angle_at(b, c, [length("AD") - length("AB"), length("AD") + length("AB")])
    drawn = angle_at(b, c, length("BD"))
    for linkage in (four_bar("A"), four_bar("D"), four_bar("C")):
        limits = linkage.drive_range("C")
        assert_allclose((limits.lower, limits.upper), ends - drawn, atol=1e-10)
    assert four_bar("C").drive_range("A").upper == np.inf


def test_without_drives_everything_stands_as_drawn():
    motion = four_bar(None).move()
    assert motion.status == "regular"
    assert_allclose(motion.position("P")[:2], PLACES["P"])


def test_no_poses():
    motion = four_bar().move(A=np.zeros((3, 0)))
    assert motion.status.shape == (3, 0)
    assert motion.acceleration("P").shape == (3, 0, 3)
    assert motion.reactions().drive("A").shape == (3, 0, 1)
    with pytest.raises(FrameError, match="no poses"):
        motion.frame()


@pytest.mark.parametrize("size", [1e-9, 1.0, 1e9])
def test_jumps_returns_and_many_turns(size):
    """A crank that goes round closes to the same place however it is reached."""
    linkage = four_bar(size=size)
    values = np.array([0.0, 1.0, 0.3, 0.3, 200.0, -1.0, 4.0, 6.5, -700.0, 200 * np.pi])
    motion = linkage.move(A=values)
    for k, value in enumerate(values):
        place = linkage.move(A=np.remainder(value, 2 * np.pi)).position("P")
        assert_allclose(motion.position("P")[k], place, atol=1e-10 * size)
    assert_allclose(motion.coordinate("A")[:, 0], values, rtol=1e-15)


def test_out_of_reach_in_the_middle_and_back():
    linkage = four_bar("D")
    limits = linkage.drive_range("D")
    values = np.array([0.0, limits.upper + 0.4, 0.05, -0.3, limits.lower - 0.1, 0.09, 1.9, 0.0])
    motion = linkage.move(D=values)
    inside = (values > limits.lower) & (values < limits.upper)
    assert np.array_equal(motion.is_assembled, inside)
    for k in np.flatnonzero(inside):
        assert_allclose(motion.position("P")[k], linkage.move(D=values[k]).position("P"), atol=1e-13)
    assert np.isnan(motion.position("P")[~inside]).all()
    assert all("at joint" in status for status in motion.status[~inside])
    ends = linkage.move(D=[limits.lower, limits.upper])
    assert all(status.startswith("singular (direct-kinematic, type II") for status in ends.status)


def test_another_circuit_is_said_to_be_one():
    """Turned by 3 rad the rocker is in reach again, but only where the drawing does not lead."""
    told = "other assembly mode; not reachable from the reference configuration"
    assert str(four_bar("D").move(D=3.0).status) == told


def test_open_chain_with_a_wheel_that_nothing_drives():
    """No loop closes, and the wheel may turn as it likes: its hub goes with the arm."""
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("arm", "A", "B")
    linkage.link("wheel", "B", mass=2.0, inertia=0.1)
    linkage.revolute("A", "ground", "arm", drive=True)
    linkage.revolute("B", "arm", "wheel")
    linkage.gravity((0, -10.0))
    theta = np.linspace(0.0, 1.0, 5)
    motion = linkage.move(A=theta, accelerations={"A": 3.0})
    assert_allclose(motion.position("B", "wheel")[:, :2], np.stack([np.cos(theta), np.sin(theta)], -1), atol=1e-15)
    # nothing turns the wheel
    assert_allclose(motion.reactions().drive("A")[:, 0], 20.0 * np.cos(theta) + 6.0, rtol=1e-12)
    linkage.drives.clear()
    assert_allclose(linkage.move().position("B")[:2], (1.0, 0.0))
