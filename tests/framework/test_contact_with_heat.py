"""Heated members in frames whose joints have clearance: heat loads the frame once, and not each unit offset as well."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.composed import Unstrained
from skfem import LinearForm

LENGTH, DIAMETER, E, GROWTH, GAP = 1000.0, 20.0, 200e3, 0.3, 0.5  # mm, N/mm²
AREA = np.pi / 4.0 * DIAMETER**2
PIN, FREE = (np.inf,) * 5 + (0.0,), ("ux", "uy")


@LinearForm
def heat(v: Any, w: Any) -> Any:
    return w.force * v.grad[0]


def heated(clearance: float, directions: tuple[str, ...], growth: float) -> Frame:
    """A bar along x that would grow by `growth`, on a pin with clearance at its start."""
    frame = Frame()
    for name, x in {"ground": 0.0, "A": 0.0, "B": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("pin", Joint(PIN, clearance=clearance, clearance_directions=directions), "ground", "A")
    frame.add("bar", Beam(Circle(diameter=DIAMETER), Material(E=E, nu=0.3)), "A", "B")
    frame.fix("ground")
    frame.add_form(heat, on="bar", force=E * AREA * growth / LENGTH)
    return frame


@pytest.mark.parametrize(("growth", "force"), [(GROWTH, 0.0), (3.0 * GAP, 2.0 * GAP * E * AREA / LENGTH)])
def test_a_bar_grows_into_its_clearance_between_two_walls(growth: float, force: float) -> None:
    """It takes up the gap without force, and what it grows beyond the gap presses it together."""
    frame = heated(GAP, ("ux",), growth)
    frame.fix("B")
    solution = frame.solve()
    np.testing.assert_allclose(solution.displacement("A")[0], -min(growth, GAP), rtol=1e-12)
    np.testing.assert_allclose(solution.forces("bar", 0.5 * LENGTH)[..., 0], -force, rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(solution.contact("pin").gap, max(GAP - growth, 0.0), rtol=1e-12)


@pytest.mark.parametrize("growth", [0.0, GROWTH, np.array([GROWTH, -GROWTH])])
def test_heat_does_not_turn_the_contact_of_a_determinate_frame(growth: Any) -> None:
    """The pin bears what balances the loads, 400 N along and 300 N across, however long the bar is."""
    frame = heated(GAP, FREE, growth)
    frame.fix("B", "uy")
    frame.load("B", fx=400.0)
    frame.point_load("bar", at=0.5 * LENGTH, fy=-600.0)
    solution = frame.solve()
    expected = np.broadcast_to([0.8, -0.6, 0.0], (*frame.shape, 3))
    np.testing.assert_allclose(solution.contact("pin").normal, expected, rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(solution.joint_displacement("pin")[..., :2], GAP * expected[..., :2], rtol=1e-12)


def test_the_frame_of_a_unit_offset_has_no_heat_at_all() -> None:
    """Neither the strain nor what restrains it: an element tells one tale."""
    frame = heated(GAP, ("ux",), GROWTH)
    element = frame.solve().plan.frame.members["bar"].element
    fraction = np.array([0.25, 0.5])
    assert np.any(element.restrained_forces(fraction))
    assert Unstrained(element).free_strain(fraction) is None
    assert Unstrained(element).restrained_forces(fraction) is None
