"""Sennett's support settlement and internal hinge."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose

INF = np.inf


def test_settlement_of_the_middle_support() -> None:
    """Sennett, Matrix Analysis of Structures, section 3.8: two spans of 120 in, EI = 2.9e6, settlement 0.25 in.

    Printed: 3.9558 and -1.7981 lb, 258.92857 and 215.7738 lb in; half a unit of the last digit, but
    one for the first, which is cut and not rounded (3.95585). By the three-moment
    equation the moment is 36 EI d/(7 L^2) at the wall and 30 EI d/(7 L^2) at the middle support.
    """
    length, rigidity, settlement = 120.0, 2.9e6, 0.25
    beam = Beam(Section(A=1.0, Iy=1.0, Iz=1.0, J=1.0), Material(E=rigidity, nu=0.3))
    frame = Frame()
    for i in range(3):
        frame.node(f"{i}", (i * length, 0.0, 0.0))
    frame.add("first", beam, "0", "1")
    frame.add("second", beam, "1", "2")
    frame.fix("0")
    frame.prescribe("1", uy=-settlement)
    frame.fix("2", "uy", "uz", "rx")
    solution = frame.solve()
    wall, end = solution.reaction("0"), solution.reaction("2")
    assert 3.9558 <= wall[1] < 3.9559
    assert_allclose(end[1], 1.7981, rtol=0, atol=0.5e-4)
    assert_allclose(wall[5], 258.92857, rtol=0, atol=0.5e-5)
    assert_allclose(solution.end_forces("first")[11], 215.7738, rtol=0, atol=0.5e-4)
    unit = rigidity * settlement / (7 * length**2)
    assert_allclose(solution.end_forces("first")[[5, 11]], [36 * unit, 30 * unit], rtol=1e-12)
    assert_allclose(solution.end_forces("second")[[5, 11]], [-30 * unit, 0.0], rtol=1e-12, atol=1e-10)


def hinged(hinge: str) -> Frame:
    """Portal on pinned feet, its girder hinged to the left column by a release or by a joint."""
    beam = Beam(Section(A=10.0, Iy=100.0, Iz=100.0, J=1.0), Material(E=29e6, nu=0.3))
    released = Beam(Section(A=10.0, Iy=100.0, Iz=100.0, J=1.0), Material(E=29e6, nu=0.3), release=("start rz",))
    frame = Frame()
    places = {"1": (0.0, 0.0, 0.0), "2": (0.0, 120.0, 0.0), "3": (120.0, 120.0, 0.0), "4": (120.0, 0.0, 0.0)}
    for name, place in places.items():
        frame.node(name, place)
    frame.add("left", beam, "1", "2")
    if hinge == "release":
        frame.add("girder", released, "2", "3")
    else:
        stiffness = {"ideal joint": INF, "stiff joint": 1e13}[hinge]
        frame.node("5", places["2"])
        frame.add("hinge", Joint(stiffness=(stiffness,) * 5 + (0.0,)), "2", "5")
        frame.add("girder", beam, "5", "3")
    frame.add("right", beam, "4", "3")
    for foot in ("1", "4"):
        frame.fix(foot, "ux", "uy", "uz", "rx", "ry")
    frame.load("2", fx=1000.0)
    return frame


@pytest.mark.parametrize("hinge", ["release", "ideal joint", "stiff joint"])
def test_hinge_in_a_portal(hinge: str) -> None:
    """Sennett, section 7.4: 0.3985 in and 0.00041 in at the loaded corner; half a unit of the last digit.

    The left column carries no moment, so the hinge is statically determinate: the right foot takes the whole thrust,
    1000 lb, and the corner moment is 1000 lb x 120 in.
    """
    solution = hinged(hinge).solve()
    assert np.all(np.abs(solution.displacement("2")[:2] - [0.3985, 0.00041]) < [0.5e-4, 0.5e-5])
    assert_allclose(solution.reaction("4")[:2], [-1000.0, 1000.0], rtol=1e-12)
    assert_allclose(solution.end_forces("girder")[[5, 11]], [0.0, -120e3], rtol=1e-12, atol=1e-7)


def test_a_release_equals_a_joint_without_stiffness() -> None:
    """The same hinge described both ways: equal to rounding; the joint's opening is the released rotation."""
    release, joint = hinged("release").solve(), hinged("ideal joint").solve()
    for node in "1234":
        assert_allclose(joint.displacement(node), release.displacement(node), rtol=1e-12, atol=1e-15)
    opening = joint.displacement("5")[5] - joint.displacement("2")[5]
    assert_allclose(joint.joint_displacement("hinge")[5], opening, rtol=1e-12)
    assert abs(opening) > 1e-3
