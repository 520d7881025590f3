"""Contact in clearances at large displacement: the law of a joint, and what it tends to as displacements get small."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.models import FourBar
from numpy.testing import assert_allclose

INF = float("inf")
BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3), segments=4)
EA = 200e9 * 0.02 * 0.01


def rows(array: np.ndarray, trailing: int) -> np.ndarray:
    """The parameters of one joint for any number of displacements."""
    return array.reshape(1, *array.shape[array.ndim - trailing :])


@settings(max_examples=50)
@given(st.lists(st.floats(-2.0, 2.0), min_size=6, max_size=6), st.floats(0.1, 1.0))
def test_resistance_derives_from_its_energy(displacement: list[float], clearance: float) -> None:
    joint = Joint((3.0, 3.0, INF, 2.0, 0.0, 5.0), clearance=clearance, clearance_directions=("ux", "uy"))
    x = np.array([displacement])
    if abs(np.hypot(x[0, 0], x[0, 1]) - clearance) < 1e-3:
        return
    step = 1e-6 * np.eye(6)
    _, force, tangent = joint.resistance(x, rows)
    up, down = joint.resistance(x + step, rows), joint.resistance(x - step, rows)
    assert_allclose(force[0], (up[0] - down[0]) / 2e-6, atol=1e-7)
    assert_allclose(tangent[0], (up[1] - down[1]) / 2e-6, atol=1e-5)


def hung(force: np.ndarray, clearance: float, stiffness: float) -> Frame:
    """A bar along x on a loose pin at A, which a force on its end B turns; a soft spring tells where it starts."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("A1", (0.0, 0.0, 0.0))
    frame.node("B", (0.5, 0.0, 0.0))
    frame.add(
        "pin", Joint((stiffness,) * 5 + (1e-3,), clearance=clearance, clearance_directions=("ux", "uy")), "A", "A1"
    )
    frame.add("bar", BAR, "A1", "B")
    frame.fix("A")
    frame.load("B", fx=force[0], fy=force[1])
    return frame


@pytest.mark.parametrize("degrees", [5.0, 60.0, 120.0])
def test_a_loose_bar_turns_into_the_force(degrees: float) -> None:
    """B ends in the direction n of the force, at ε + F/k + L + F L/EA from A."""
    n = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    solution = hung(1000.0 * n, 2e-3, 1e8).solve(large=True, steps=4)
    far = 2e-3 + 1000.0 / 1e8 + 0.5 + 1000.0 * 0.5 / EA
    assert solution.status == "stable"
    assert_allclose(solution.displacement("B")[:2] + np.array([0.5, 0.0]), far * n, atol=2e-6)


def test_small_displacements_are_those_of_the_linear_contact() -> None:
    """The difference from the linear solution falls with load and clearance together, as their square."""
    four_bar = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open", stiffness=(1e8,) * 5 + (0.0,))
    motion, off = four_bar.move(np.radians([30.0, 60.0, 200.0])), []
    for size in (1.0, 0.5):
        frame = motion.frame(dict.fromkeys("BDE", 1e-4 * size))
        frame.load("P", fy=10.0 * size)
        large, linear = frame.solve(large=True), frame.solve()
        assert large.status.tolist() == ["stable"] * 3
        off.append(np.abs(large.displacement("P") - linear.displacement("P"))[:, :2].max() / size)
        assert off[-1] < 0.02 * np.abs(linear.displacement("P")).max() / size
    assert off[1] == pytest.approx(0.5 * off[0], rel=0.1)


def test_clearance_is_left_out_when_asked() -> None:
    frame = hung(np.array([1000.0, 10.0]), 2e-3, 1e8)
    loose, tight = frame.solve(large=True), frame.solve(large=True, clearance=False)
    assert_allclose(np.hypot(*(loose.displacement("B") - tight.displacement("B"))[:2]), 2e-3, rtol=1e-3)
