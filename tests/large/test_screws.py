"""Screws at finite turns: advance, balance of push and torque, the same in every direction, in trees and loops."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, rotation
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
INF = float("inf")
PITCH = 0.05
LEAD = PITCH / (2.0 * np.pi)
BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3))
TURNED = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])


def spindle(screw: Joint, axes: Array = TURNED, *, guided: bool = False) -> Frame:
    """A screw on the ground at A that carries a rod along it to D; `guided` lets D turn and slide along the screw."""
    frame = Frame()
    for name, place in {"A": 0.0, "C": 0.0, "D": 0.4}.items():
        frame.node(name, place * axes[:, 2])
    frame.fix("A")
    frame.add("screw", screw, "A", "C")
    frame.add("rod", BEAM, "C", "D")
    if guided:
        frame.node("E", 0.4 * axes[:, 2])
        frame.fix("E")
        frame.add("guide", Joint((INF, INF, 0.0, 0.0, 0.0, 0.0), axes=axes), "E", "D")
    return frame


def push(frame: Frame, node: str, force: object, moment: object, axis: Array) -> None:
    """A force and a moment along an axis."""
    for names, size in ((("fx", "fy", "fz"), force), (("mx", "my", "mz"), moment)):
        frame.load(node, **{name: np.multiply(size, part) for name, part in zip(names, axis, strict=True)})  # type: ignore[arg-type]


@pytest.mark.parametrize("axes", [np.eye(3), TURNED], ids=["global", "turned"])
def test_a_prescribed_turn_advances(axes: Array) -> None:
    """Any number of turns: the rod's end moves by the pitch for each, along the screw, and nothing is strained."""
    turns = np.array([-7.25, -0.5, 0.1, 1.0, 20.5])
    frame = spindle(Joint((INF,) * 6, axes=axes, pitch=PITCH), axes)
    frame.offset("screw", rz=2.0 * np.pi * turns)
    solution = frame.solve(large=True)
    assert (solution.status == "stable").all()
    assert_allclose(solution.displacement("D")[:, :3], PITCH * turns[:, None] * axes[:, 2], rtol=1e-12, atol=1e-15)
    moved = solution.joint_displacement("screw")
    assert_allclose(moved[:, 5], 2.0 * np.pi * turns, rtol=1e-15)
    assert_allclose(moved[:, 2], PITCH * turns, rtol=1e-15)
    assert np.abs(solution.joint_force("screw")).max() < 1e-6


@pytest.mark.parametrize("held", [INF, 1e6], ids=["ideal", "stiff"])
def test_a_push_turns_a_nut_against_a_spring(held: float) -> None:
    """A torsion spring k about the screw: F turns it by F p / 2 pi k, through many turns, and pushes with a torque."""
    force, torsion = np.array([1.0, 300.0, 2e3]), 0.5
    frame = spindle(Joint((held,) * 5 + (torsion,), axes=TURNED, pitch=PITCH))
    push(frame, "D", force, 0.0, TURNED[:, 2])
    solution = frame.solve(large=True)
    moved, acting = solution.joint_displacement("screw"), solution.joint_force("screw")
    turn = LEAD * force / torsion
    assert turn[-1] > 4.0 * np.pi
    assert (solution.status == "stable").all()
    assert_allclose(moved[:, 5], turn, rtol=1e-11)
    assert_allclose(moved[:, 2], LEAD * turn + (0.0 if np.isinf(held) else force / held), rtol=1e-11)
    assert_allclose(acting[:, 2], force, rtol=1e-10)
    # The spring's torque and that of the thread cancel: nothing turns the rod from outside.
    assert_allclose(acting[:, 5], 0.0, atol=1e-10 * force[-1])


@settings(max_examples=10, deadline=None)
@given(st.tuples(*(st.floats(-3.0, 3.0),) * 3), st.floats(-0.3, 0.3), st.floats(-200.0, 200.0), st.floats(-5.0, 5.0))
def test_it_is_the_same_in_every_direction(
    vector: tuple[float, ...], pitch: float, force: float, torque: float
) -> None:
    """Push and torque on an elastic screw, turned in space: a rigid rotation of everything. Work balances."""
    turn = rotation.matrix(rotation.exponential(np.array(vector)))
    torsion, spring = 20.0, 1e4
    found = []
    for axes in (np.eye(3), turn):
        frame = spindle(Joint((spring, spring, spring, 1e3, 1e3, torsion), axes=axes, pitch=pitch), axes)
        push(frame, "D", force, torque, axes[:, 2])
        found.append(frame.solve(large=True))
    straight, turned = found
    assert straight.status == turned.status == "stable"
    assert_allclose(turned.displacement("D")[:3], turn @ straight.displacement("D")[:3], rtol=1e-9, atol=1e-12)
    assert_allclose(turned.joint_displacement("screw"), straight.joint_displacement("screw"), rtol=1e-9, atol=1e-12)
    # Equilibrium about the axis: k rz = torque + lead force.
    about = (torque + pitch / (2.0 * np.pi) * force) / torsion
    assert straight.joint_displacement("screw")[5] == pytest.approx(about, rel=1e-9, abs=1e-12)
    assert straight.joint_force("screw")[5] == pytest.approx(torque, rel=1e-9, abs=1e-9)


@pytest.mark.parametrize("held", [INF, 1e8], ids=["ideal", "stiff"])
def test_small_turns_are_linear(held: float) -> None:
    """The difference from the linear solution falls as the square of the load."""
    off = []
    for size in (1.0, 0.5):
        frame = spindle(Joint((held,) * 5 + (40.0,), axes=TURNED, pitch=PITCH), guided=True)
        push(frame, "D", 0.3 * size, 0.05 * size, TURNED[:, 0])
        push(frame, "D", 8.0 * size, 1.0 * size, TURNED[:, 2])
        frame.offset("screw", rz=0.01 * size, uz=1e-5 * size)
        large, linear = frame.solve(large=True), frame.solve()
        results = (("displacement", "D"), ("joint_displacement", "screw"), ("joint_force", "screw"), ("reaction", "A"))
        for kind, name in results:
            expected = getattr(linear, kind)(name)
            assert_allclose(getattr(large, kind)(name), expected, atol=0.02 * np.abs(expected).max())
        off.append(np.abs(large.displacement("D") - linear.displacement("D")).max() / size)
    assert off[1] == pytest.approx(0.5 * off[0], rel=0.1)


def test_a_screw_jack() -> None:
    """A driven spindle, its nut held from turning: the nut rises by the pitch a turn, at the torque F p / 2 pi."""
    turns, load = np.array([0.25, 1.0, 6.0]), 500.0
    frame = Frame()
    for name in ("A", "S", "N", "G"):
        frame.node(name, (0.0, 0.0, 0.0))
    frame.node("T", (0.2, 0.0, 0.0))
    frame.fix("A")
    frame.fix("G")
    frame.add("bearing", Joint((INF,) * 6), "A", "S")
    frame.offset("bearing", rz=2.0 * np.pi * turns)
    frame.add("screw", Joint((INF, INF, INF, INF, INF, 0.0), pitch=-PITCH), "S", "N")
    frame.add("arm", BEAM, "N", "T")
    # It holds the arm's end at its place in the plane and lets it slide up.
    frame.node("H", (0.2, 0.0, 0.0))
    frame.fix("H")
    frame.add("slide", Joint((1e9, 1e9, 0.0, 0.0, 0.0, 0.0)), "H", "T")
    frame.load("N", fz=-load)
    solution = frame.solve(large=True, steps=24)
    assert (solution.status == "stable").all()
    # A left-handed screw: the nut stays behind by as much as the spindle turns, and rises.
    assert_allclose(solution.displacement("N")[:, 2], PITCH * turns, rtol=1e-4)
    assert_allclose(solution.joint_displacement("screw")[:, 5], -2.0 * np.pi * turns, rtol=1e-4)
    assert_allclose(solution.joint_force("screw")[:, 5], LEAD * solution.joint_force("screw")[:, 2], rtol=1e-9)
    assert_allclose(solution.joint_force("screw")[:, 2], -load, rtol=1e-2)


@pytest.mark.parametrize("turning", [20.0, INF], ids=["slide closes the loop", "screw closes the loop"])
def test_a_screw_in_a_loop_of_rigid_links(turning: float) -> None:
    """Two bearings of one rod, a screw and a slide with a spring: a push turns nothing, as both axes hold the rod."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 0, 0), "D": (0, 0, 0)}.items():
        frame.node(name, place)
    frame.fix("A")
    frame.rigid("A", "B")
    frame.add("screw", Joint((INF,) * 5 + (0.0,), pitch=PITCH), "B", "C")
    frame.add("slide", Joint((INF, INF, 1e4, INF, INF, turning)), "A", "D")
    frame.rigid("D", "C")
    frame.load("C", fy=3.0, fz=10.0)
    linear, large = frame.solve(), frame.solve(large=True)
    assert large.converged
    for joint in ("screw", "slide"):
        assert_allclose(large.joint_displacement(joint), 0.0, atol=1e-12)
    assert large.joint_force("screw")[2] == pytest.approx(linear.joint_force("screw")[2], rel=1e-9)
    assert large.joint_force("screw")[5] == pytest.approx(-LEAD * 10.0, rel=1e-9)
