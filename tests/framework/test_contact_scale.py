"""Contact in clearances does not depend on the units: loads and clearances of any size, nodes at any place."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle, Section
from linkframe.framework import Frame, MechanismWarning
from linkframe.framework.dofs import DISPLACEMENTS, FORCES
from numpy.testing import assert_allclose

INF = float("inf")
BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
BENDING = 3.0 * 200e9 * 0.01 * 0.02**3 / 12.0  # of a cantilever one metre long, N/m


def bearing(stiffness: tuple[float, ...], clearance: object, play: tuple[str, ...], place: float) -> Frame:
    """A node held by a joint with play alone."""
    frame = Frame()
    for name in ("ground", "journal"):
        frame.node(name, (place, 0.0, 0.0))
    frame.add("pin", Joint(stiffness=stiffness, clearance=clearance, clearance_directions=play), "ground", "journal")  # type: ignore[arg-type]
    frame.fix("ground")
    return frame


@pytest.mark.parametrize("place", [0.0, 1e-13, 1e-3, 1.0, 1e3])
@pytest.mark.parametrize("stiffness", [50.0, INF])
@pytest.mark.parametrize("play", ["ux", "uz", "rx", "rz"])
def test_a_journal_goes_through_its_clearance_wherever_it_is(place: float, stiffness: float, play: str) -> None:
    """ε + F/k, all nodes at the origin included, where the frame has no size."""
    component = DISPLACEMENTS.index(play)
    springs = [INF] * 6
    springs[component] = stiffness
    frame = bearing(tuple(springs), 0.02, (play,), place)
    frame.load("journal", **{FORCES[component]: [1.0, -2.0]})
    solution = frame.solve()
    expected = np.array([0.02 + 1.0 / stiffness, -0.02 - 2.0 / stiffness])
    assert_allclose(solution.displacement("journal")[:, component], expected, rtol=1e-15)
    assert_allclose(solution.contact("pin").force, [1.0, 2.0], rtol=1e-15)
    assert solution.status.tolist() == ["regular", "regular"]


@pytest.mark.parametrize("size", [1e-290, 1e-200, 1e-100, 1.0, 1e100, 1e200, 1e300])
def test_loads_of_any_size_close_a_clearance(size: float) -> None:
    frame = bearing((1e9, 1e9, INF, INF, INF, INF), 1e-4, ("ux", "uy"), 1.0)
    frame.load("journal", fx=3.0 * size, fy=-4.0 * size)
    solution = frame.solve()
    contact = solution.contact("pin")
    assert contact.status == "closed"
    assert_allclose(contact.force, 5.0 * size, rtol=1e-14)
    assert_allclose(contact.normal, [0.6, -0.8, 0.0], rtol=1e-14)
    reach = 1e-4 + 5.0 * size / 1e9
    assert_allclose(solution.displacement("journal")[:2], [0.6 * reach, -0.8 * reach], rtol=1e-14)


@pytest.mark.parametrize("size", [1e-290, 1e-160, 1e-20, 1.0, 1e20, 1e160, 1e290])
def test_a_stop_that_takes_part_of_the_load_scales_with_it(size: float) -> None:
    """A cantilever against a stop of stiffness k at ε: the tip goes to (F + k ε)/(k + 3EI/L³), load by load."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("stop", Joint(stiffness=(0.0, 1e5, 0.0, 0.0, 0.0, 0.0), clearance=1e-3 * size), "B", "C")
    frame.fix("A")
    frame.fix("C")
    frame.load("B", fy=np.array([1.0, 100.0, -100.0]) * size)
    contact = frame.solve().contact("stop")
    assert contact.status.tolist() == ["open", "closed", "closed"]
    tip = (100.0 + 1e5 * 1e-3) / (1e5 + BENDING)
    assert_allclose(contact.force / size, [0.0, 1e5 * (tip - 1e-3), 1e5 * (tip - 1e-3)], rtol=1e-12)
    assert_allclose(contact.gap[0] / size, 1e-3 - 1.0 / BENDING, rtol=1e-12)


@pytest.mark.parametrize("held", [(), ("uz",), ("uz", "rx", "ry"), ("rz",)])
def test_nothing_loaded_rests_anywhere(held: tuple[str, ...]) -> None:
    """No force tells where in its clearance the node beyond the joint is."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e9, 1e9, INF, INF, INF, 0.0), clearance=1e-3), "B", "C")
    frame.fix("A")
    if held:
        frame.fix("C", *held)
    solution = frame.solve()
    assert solution.contact("pin").status == "free"
    assert solution.status == "free"
    assert not solution.contact("pin").force


@pytest.mark.parametrize("unit", [1e-6, 1e-3, 1e3, 1e6])
def test_a_moment_that_is_rounding_closes_no_clearance_in_rotations_in_any_unit_of_length(unit: float) -> None:
    """A rod pulled along itself, in which a joint has clearance in all rotations; lengths in units of 1 / `unit`."""
    found = []
    for size in (1.0, unit):
        rng = np.random.default_rng(1)
        along = rng.normal(size=3)
        along /= np.linalg.norm(along)
        axes = np.linalg.qr(rng.normal(size=(3, 3)))[0]
        axes *= np.sign(np.linalg.det(axes))
        frame = Frame()
        for name, distance in {"A": 0.0, "B": 0.7, "T": 0.7, "C": 1.2}.items():
            frame.node(name, size * (np.array([0.1, 0.2, 0.3]) + distance * along))
        section = Section(A=1e-4 * size**2, Iy=1e-9 * size**4, Iz=2e-9 * size**4, J=1e-9 * size**4)
        frame.add("AB", Beam(section, Material(E=2e11 / size**2, nu=0.3)), "A", "B")
        frame.add("TC", Beam(section, Material(E=2e11 / size**2, nu=0.3)), "T", "C")
        springs = (1e8 / size,) * 3 + (1e4 * size,) * 3
        joint = Joint(springs, axes=axes, clearance=1e-3, clearance_directions=("rx", "ry", "rz"))
        frame.add("joint", joint, "B", "T")
        frame.fix("A")
        frame.load("C", **dict(zip(("fx", "fy", "fz"), along[:, None] * [1.0, 10.0, 100.0, 1e3], strict=True)))
        solution = frame.solve()
        with pytest.warns(MechanismWarning):
            moved = solution.displacement("C")
        found.append(moved[:, :3] / size)
        assert solution.contact("joint").status.tolist() == ["free"] * 4
        assert solution.status.tolist() == ["free"] * 4
    assert_allclose(found[1], found[0], rtol=1e-9)
