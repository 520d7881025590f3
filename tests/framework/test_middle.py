"""Batches of matrices in bands: how wide these are, what tells a mechanism, and that entries know nothing of others."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.solvers.stacked import StackedSolver

E = 2e11
SECTION = Section(A=0.01, Iy=1e-5, Iz=2e-5, J=2e-5)


def portal(bays: int, storeys: int, modulus: np.ndarray) -> Frame:
    """Bays by storeys in the plane of x and z, pushed along all axes."""
    beam, frame = Beam(SECTION, Material(E=modulus, nu=0.3)), Frame()
    for s in range(storeys + 1):
        for k in range(bays + 1):
            frame.node(f"{k}.{s}", (4.0 * k, 0.0, 3.0 * s))
            if s:
                frame.add(f"column {k}.{s}", beam, f"{k}.{s - 1}", f"{k}.{s}")
            if s and k:
                frame.add(f"beam {k}.{s}", beam, f"{k - 1}.{s}", f"{k}.{s}")
    for k in range(bays + 1):
        frame.fix(f"{k}.0")
    frame.load(f"0.{storeys}", fx=1e3, fy=300.0, fz=-50.0)
    return frame


def arm(count: int, turning: np.ndarray, modulus: np.ndarray) -> Frame:
    """A clamped beam of so many members, and beyond a hinge another one, pulled along and across at its end."""
    beam, frame = Beam(SECTION, Material(E=modulus, nu=0.3)), Frame()
    for k in range(2 * count + 1):
        frame.node(f"{k}", (float(k), 0.0, 0.0))
    frame.node("hinge", (float(count), 0.0, 0.0))
    for k in range(2 * count):
        frame.add(f"m{k}", beam, "hinge" if k == count else f"{k}", f"{k + 1}")
    frame.fix("0")
    rigid = np.full_like(turning, np.inf)
    frame.add("joint", Joint(stiffness=np.stack([rigid] * 5 + [turning], axis=-1)), f"{count}", "hinge")
    frame.load(f"{2 * count}", fx=1.0, fy=1.0)
    return frame


def test_planes_are_taken_apart() -> None:
    """In the plane and across it nothing is coupled: a band is half as wide as six unknowns a node would make it."""
    solution = portal(4, 6, E * np.linspace(0.9, 1.1, 3)).solve("banded")
    solver = solution.solver
    assert isinstance(solver, StackedSolver)
    assert solver.bands(solver.loaded).width <= solution.plan.graph.width / 2


@pytest.mark.parametrize("count", [5, 60])
def test_an_arm_that_turns_is_told(count: int) -> None:
    """At the entry without a spring alone; a stiff one turns by ``F L / k`` more than the beam without a hinge."""
    turning, modulus = np.array([1e7, 0.0, 1e7, 1e8]), E * np.array([1.0, 1.1, 1.2, 0.9])
    solution = arm(count, turning, modulus).solve("banded")
    with pytest.warns(UserWarning, match="1 of 4 batch entries"):
        found = solution.displacement(f"{2 * count}")[:, 1]
    assert solution.status.tolist() == ["regular", "mechanism", "regular", "regular"]
    kept = turning > 0.0
    exact = (2.0 * count) ** 3 / (3.0 * modulus[kept] * 2e-5) + float(count) ** 2 / turning[kept]
    np.testing.assert_allclose(found[kept], exact, rtol=1e-12)


def test_few_unknowns_under_many_loads_go_in_bands() -> None:
    """One that does not vary, of which no joint or load along a member takes more to refine: as exact as broadcast."""
    shares = np.linspace(-1.0, 2.0, 7)
    frame = portal(2, 4, np.array(E))
    frame.load("1.4", fy=1e3 * shares)
    found, other = frame.solve(), frame.solve("broadcast")
    assert found.plan.method.name == "banded"
    one, two = found.displacement("1.4"), other.displacement("1.4")
    assert np.abs(one - two).max() <= 1e-15 * np.abs(two).max()
    frame.gravity((0.0, 0.0, -9.81))
    assert frame.solve().plan.method.name == "broadcast"
    assert portal(2, 4, np.array(E)).solve().plan.method.name == "broadcast"


@pytest.mark.parametrize("count", [3, 30])
def test_entries_know_nothing_of_others(count: int) -> None:
    """However soft the hinges of others are: the same bits, alone among others."""
    turning, modulus = np.array([1e7, 1e-3, 1e2, 1e8]), E * np.array([1.0, 1.1, 1.2, 0.9])
    whole = arm(count, turning, modulus).solve("banded").displacement(f"{2 * count}")
    some = arm(count, turning[[0, 3]], modulus[[0, 3]]).solve("banded").displacement(f"{2 * count}")
    np.testing.assert_array_equal(whole[[0, 3]], some)
