"""The four-bar of the accuracy paper at and near its singular poses, against rods met by shooting."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import MechanismWarning
from linkframe.framework.large.solution import LargeSolution
from linkframe.models import FourBar
from reference.rod_four_bar import FORCE, PIN, E, Y, Z, shot

STEEL = Material(E=E, nu=0.3)
SECTION = Rectangle(y=Y, z=Z)


def large(theta: float | np.ndarray, segments: int = 2, pin: float = PIN) -> LargeSolution:
    beam = Beam(SECTION, STEEL, segments=segments)
    four_bar = FourBar(beam=beam, stiffness=(pin,) * 5 + (0.0,))
    frame = four_bar.move(np.radians(theta)).frame()
    frame.load("P", fy=FORCE)
    return frame.solve(large=True)


def exact(theta: float, near: LargeSolution, pin: float = PIN) -> np.ndarray:
    """Displacement of P by shooting; `near` gives the first guess."""
    reaction = -near.reaction("A")
    turns = near.displacement("B.coupler")[5], near.displacement("D.rocker")[5]
    return shot(theta, np.array([*reaction[:2], reaction[5], *turns]), pin=pin)


@pytest.mark.parametrize("theta", [0.0, 0.01, 0.1, 1.0, 5.0, 30.0, 180.0])
def test_against_shooting(theta: float) -> None:
    one, two = large(theta, 1), large(theta, 2)
    truth = exact(theta, two)
    size = np.abs(truth).max()
    error = [np.abs(solution.displacement("P")[:2] - truth).max() / size for solution in (one, two)]
    assert one.status == two.status == "stable"
    assert error[0] < 3e-6
    # the error falls with the fourth power of the pieces' length, down to that of the shooting
    assert error[1] < 0.1 * error[0] + 1e-9


def test_soft_pins() -> None:
    solution = large(1.0, 2, pin=1e6)
    truth = exact(1.0, solution, pin=1e6)
    assert solution.displacement("P")[:2] == pytest.approx(truth, abs=1e-7 * np.abs(truth).max())


def test_smooth_through_the_singularity() -> None:
    theta = np.linspace(-1.5, 2.0, 71)
    moved = large(theta, 2).displacement("P")[:, 1]
    assert np.isfinite(moved).all()
    assert np.abs(np.diff(moved, 3)).max() < 1e-4 * np.ptp(moved)
    assert moved.max() < 7e-3


def test_snaps_through_where_the_load_exceeds_the_limit() -> None:
    """Below the line of coupler and rocker the load pushes D towards it: the linkage resists at -3 degrees, and snaps
    through to the other side at -1."""
    moved = large(np.array([-3.0, -1.0]), 2).displacement("P")[:, 1]
    height = 0.1 * np.sin(np.radians([3.0, 1.0]))
    assert 2.0 * moved[0] < height[0]
    assert 2.0 * moved[1] > 2.0 * height[1]


def test_equals_the_linear_solution_where_that_is_valid() -> None:
    """At 90 degrees the loads stretch and bend little: what is left is of second order."""
    frame = FourBar(beam=Beam(SECTION, STEEL)).move(np.radians(90.0)).frame()
    ratio = []
    for force in (1.0, 1e-2):
        frame.loads.clear()
        frame.load("P", fx=force, fy=force)
        linear, nonlinear = frame.solve(), frame.solve(large=True)
        for node in ("P", "D.coupler", "E.rocker"):
            scale = np.abs(linear.displacement(node)).max()
            ratio.append(np.abs(nonlinear.displacement(node) - linear.displacement(node)).max() / scale)
        assert nonlinear.joint_force("D") == pytest.approx(linear.joint_force("D"), rel=1e-4 * force, abs=1e-4 * force)
        assert nonlinear.reaction("A") == pytest.approx(linear.reaction("A"), rel=1e-4 * force, abs=1e-4 * force)
    assert max(ratio[:3]) < 1e-4
    assert max(ratio[3:]) < 1.1e-2 * max(ratio[:3]) + 1e-13


def test_stiff_and_ideal_pins_agree_to_the_last_digits() -> None:
    """Joints are coordinates: springs of 1e20 beside beams of 1e3 cost nothing."""
    moved = [large(np.array([0.0, 2.0, 40.0]), 2, pin).displacement("P") for pin in (1e20, np.inf)]
    assert moved[0][:, :2] == pytest.approx(moved[1][:, :2], rel=1e-11)


def test_linear_solution_has_no_number_where_this_has() -> None:
    frame = FourBar(beam=Beam(SECTION, STEEL)).move(0.0).frame()
    frame.load("P", fy=FORCE)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        assert np.isnan(frame.solve().displacement("P")).all()
    assert frame.solve(large=True).displacement("P")[1] == pytest.approx(2.39e-3, rel=1e-2)
