"""Contact where rods lie in one line, which rounding of their places bends: the same in every direction and place."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.models import FourBar
from numpy.testing import assert_allclose

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
PIN = 2e8 * np.array([1.0, 1.0, 1.0, 1e-3, 1e-3, 0.0])
ROD = 200e9 * 12.7e-3 * 6.35e-3 / 0.1  # of the first rod along itself, N/m
CLEARANCE, FORCE = 1e-4, 10.0

pytestmark = pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")


def folded(degrees: float, place: tuple[float, float]) -> Frame:
    """A crank, a coupler of twice its length and a rocker folded back, pinned with clearance, pushed along the line."""
    along, frame = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0]), Frame()
    for name, x in {"A": 0.0, "B": 0.1, "B2": 0.1, "D": 0.3, "D2": 0.3, "E": 0.2, "E2": 0.2}.items():
        frame.node(name, np.array([*place, 0.0]) + x * along)
    for start, end in (("A", "B"), ("B2", "D"), ("D2", "E")):
        frame.add(start + end, BAR, start, end)
    for first in "BDE":
        frame.add(f"pin {first}", Joint(stiffness=PIN, clearance=CLEARANCE), first, f"{first}2")
    frame.fix("A")
    frame.fix("E2")
    frame.load("B2", fx=FORCE * along[0], fy=FORCE * along[1])
    return frame


@pytest.mark.parametrize("place", [(0.0, 0.0), (3.0, -7.0)])
@pytest.mark.parametrize("degrees", [0.0, 10.0, 45.0, 180.0])
def test_the_nearest_bearing_takes_the_force_and_the_others_float(degrees: float, place: tuple[float, float]) -> None:
    """ε + F/k + F L/EA: the rocker is pushed back within its clearances."""
    solution = folded(degrees, place).solve()
    contacts = [solution.contact(f"pin {name}") for name in "BDE"]
    assert [str(contact.status) for contact in contacts] == ["closed", "free", "free"]
    assert solution.status == "free"
    assert_allclose([contact.force for contact in contacts], [FORCE, 0.0, 0.0], rtol=1e-9)
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    exact = CLEARANCE + FORCE / PIN[0] + FORCE / ROD
    assert_allclose(contacts[0].normal[:2], along, atol=1e-9)
    assert_allclose(solution.displacement("B2")[:2] @ along, exact, rtol=1e-9)


@pytest.mark.parametrize("degrees", [0.0, 10.0, 45.0])
def test_what_is_imposed_along_the_line_drives_no_motion_across_it(degrees: float) -> None:
    """The force of springs in series for a unit between them; work of 10⁷ N on a rounding of the line is none."""
    frame = folded(degrees, (3.0, -7.0))
    along = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees))])
    frame.offset("pin B", ux=along[0], uy=along[1])
    solution = frame.solve(clearance=False)
    assert solution.status == "statically consistent mechanism"
    series = 1.0 / (3.0 / PIN[0] + 4.0 / ROD)  # three pins, and rods of four times the length of the first
    back = FORCE * (1.0 / PIN[0] + 1.0 / ROD) * series
    assert_allclose(solution.joint_force("pin D")[:2] @ along, -series - back, rtol=1e-9)


def test_a_parallelogram_is_at_180_degrees_as_at_0() -> None:
    """The sine of 180 degrees is 1.2e-16 to a computer."""
    motion = FourBar(beam=BAR, stiffness=dict.fromkeys("BDE", PIN)).move(np.radians([0.0, 180.0]))
    frame = motion.frame(dict.fromkeys("BDE", CLEARANCE))
    frame.load("P", fx=FORCE)
    solution = frame.solve()
    assert solution.status.tolist() == ["free", "free"]
    assert [solution.contact(name).status.tolist() for name in "BDE"] == [["closed"] * 2, ["free"] * 2, ["free"] * 2]
    assert_allclose(solution.contact("B").force, FORCE, rtol=1e-9)
