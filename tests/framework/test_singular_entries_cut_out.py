"""Entries that can move, taken out of a batch of which everything varies, are what they are alone."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle
from linkframe.framework import Frame
from linkframe.models import FourBar
from numpy.testing import assert_allclose

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3, density=7850.0))
# The second is a dead point, along which the loads act.
DEGREES = np.array([35.0, 180.0, 290.0])
SCALE = np.array([1.0, 1.7, 0.6])

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def varied(some: slice | int) -> Frame:
    """A four-bar with a rigid arm, a mass, weight, a screw and a bracket on two ideal joints, other at each pose."""
    scale = SCALE[some]
    motion = FourBar(beam=BAR, stiffness=dict.fromkeys("BDE", (2e8, 2e8, 2e8, 1e5, 1e5, 0.0))).move(
        np.radians(DEGREES[some])
    )
    frame, along = motion.frame(), np.multiply.outer(scale, [1.0, 0.0, 0.0])
    place = frame.position("P")
    frame.load("P", fx=100.0 * scale)
    frame.gravity(3.0 * along)
    frame.add("ball", PointMass(0.2 * scale), "P")
    frame.node("arm", place + 0.05 * along)
    frame.rigid("P", "arm")
    frame.load("arm", fx=7.0 * scale, fz=0.1 * scale)
    frame.node("nut", place)
    frame.add("screw", Joint((1e7,) * 6, pitch=0.01 * scale), "P", "nut")
    frame.load("nut", fz=2.0)
    frame.node("bracket", place)
    for name, base in (("near", "P"), ("far", "arm")):
        at = frame.position(base)
        frame.node(name, at)
        frame.add(f"{name} joint", Joint((np.inf,) * 6), base, name)
        frame.rigid("bracket", name)
    frame.load("bracket", fx=5.0, fz=0.3 * scale)
    return frame


def test_whatever_varies_beside_the_pose() -> None:
    whole = varied(slice(None)).solve()
    assert whole.status.tolist() == ["regular", "statically consistent mechanism", "regular"]
    for entry in range(3):
        alone = varied(entry).solve()
        assert alone.status == whole.status[entry]
        for name in ("P", "nut", "arm", "B.coupler"):
            found = whole.displacement(name)
            assert_allclose(found[entry], alone.displacement(name), rtol=0.0, atol=1e-11 * np.nanmax(np.abs(found)))
        for name in ("B", "screw", "near joint", "far joint"):
            found = whole.joint_force(name)[entry]
            assert_allclose(found, alone.joint_force(name), rtol=0.0, atol=1e-9 * np.abs(found).max())


ALONG = np.array([0.8, 0.6, 0.0])
# From so many entries on those that can move are held together, if no end of a member carries the other, as none does
# beside a body.
TOGETHER = pytest.mark.parametrize(("count", "body"), [(3, False), (200, False), (200, True)])


def hinged_rod(tail: np.ndarray | float, load: np.ndarray | float, imposed: float = 0.0, body: bool = False) -> Frame:
    """A rod on a hinge, pulled along itself, and behind it another one on springs, which may be none."""
    frame = Frame()
    if body:
        frame.body("table")
    for name, x in {"A": 0.0, "A1": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, x * ALONG)
    frame.add("hinge", Joint((1e8,) * 5 + (0.0,)), "A", "A1")
    frame.add("AB", BAR, "A1", "B")
    frame.add("springs", Joint(np.multiply.outer(tail, np.ones(6))), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.offset("hinge", ux=0.8 * imposed, uy=0.6 * imposed)
    frame.load("B", fx=0.8 * np.asarray(load), fy=0.6 * np.asarray(load))
    return frame


@TOGETHER
def test_what_the_loads_reach_is_told_by_the_springs_of_each_entry(count: int, body: bool) -> None:
    tail = np.where(np.arange(count) % 3 == 1, 0.0, 1e5)
    whole = hinged_rod(tail, np.ones(count), body=body).solve()
    for entry in (0, 1, count - 1):
        alone = hinged_rod(tail[entry], 1.0, body=body).solve()
        assert alone.status == whole.status[entry]
        for name in "BCD":
            assert_allclose(whole.displacement(name)[entry], alone.displacement(name), rtol=0.0, atol=1e-20)
        assert_allclose(whole.joint_force("hinge")[entry], alone.joint_force("hinge"), rtol=0.0, atol=1e-12)


@TOGETHER
def test_what_is_imposed_reaches_what_springs_join_to_it(count: int, body: bool) -> None:
    """Without any load the rods follow their support along themselves, and do not turn about it."""
    tail = np.linspace(1.0, 2.0, count)
    solution = hinged_rod(1e5 * tail, np.zeros(count), imposed=1e-3, body=body).solve()
    assert (solution.status == "statically consistent mechanism").all()
    start = solution.displacement("A1")
    assert_allclose(start[:, :3], np.broadcast_to(1e-3 * ALONG, (count, 3)), rtol=1e-14)
    assert_allclose(start[:, 5], 0.0, atol=1e-16)
    for name in "BCD":
        moved = solution.displacement(name)
        assert_allclose(moved[:, [0, 1, 5]], np.broadcast_to(1e-3 * ALONG, (count, 3)), rtol=0.0, atol=1e-15)
        assert not moved[:, 2:5].any()
    assert_allclose(solution.joint_force("springs"), 0.0, atol=1e-12)
