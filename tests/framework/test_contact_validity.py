"""Displacement by clearance beyond the range of linear mechanics is marked, as that by load is.

A rod of length L leans from a journal bearing with clearance ε to a vertical guide at the distance b. A load there
presses the journal along the rod, and its far end goes down to ``sqrt((L - ε)^2 - b^2)``: exactly, however flat it is.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose

INF = float("inf")
BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))


def leaning(rise: float, clearance: object, force: float) -> Frame:
    frame = Frame()
    for name, place in {"bearing": (0, 0, 0), "foot": (0, 0, 0), "top": (1.0, rise, 0)}.items():
        frame.node(name, place)
    pin = Joint(stiffness=(INF,) * 5 + (0.0,), clearance=clearance, clearance_directions=("ux", "uy"))  # type: ignore[arg-type]
    frame.add("pin", pin, "bearing", "foot")
    frame.add("rod", BAR, "foot", "top")
    frame.fix("bearing")
    frame.fix("top", "ux")
    frame.load("top", fy=-force)
    return frame


@pytest.mark.parametrize("force", [1e-12, 1e-6, 1e-3])
@pytest.mark.parametrize("rise", [0.1, 0.3, 1.0])
def test_the_estimate_follows_the_true_error(rise: float, force: float) -> None:
    """Within a factor of four below and eight above it, where that is 0.1 to 50 %."""
    length = np.hypot(1.0, rise)
    clearance = (length - 1.0) * np.array([1e-3, 1e-2, 3e-2, 0.1, 0.3, 0.6])
    solution = leaning(rise, clearance, force).solve()
    exact = np.sqrt((length - clearance) ** 2 - 1.0) - rise
    off = np.abs(solution.displacement("top")[:, 1] - exact) / np.abs(exact)
    assert solution.status.tolist() == ["regular"] * 6
    ratio = solution.nonlinearity() / off
    assert np.all((ratio > 0.25) & (ratio < 8.0))
    assert not solution.linear[off > 0.06].any()
    assert solution.linear[off < 0.005].all()


def test_clearances_larger_than_the_linkage_are_marked() -> None:
    """A four-bar of 0.3 m with 1e-6 to 1e5 m of play."""
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    linkage.link("crank", "A", "B", beam=BAR)
    linkage.link("coupler", "B", "P", "D", beam=BAR)
    linkage.link("rocker", "D", "E", beam=BAR)
    linkage.revolute("A", "ground", "crank", drive=True)
    size = np.array([1e-6, 1e-5, 1e-1, 1.0, 1e5])[:, None]
    for name, first, second in (("B", "crank", "coupler"), ("D", "coupler", "rocker"), ("E", "rocker", "ground")):
        linkage.revolute(name, first, second, stiffness=(1e9, 1e9, INF, INF, INF, 0.0), clearance=size)
    frame = linkage.move(A=np.radians([40.0, 130.0, 250.0])).frame()
    frame.load("P", fy=1.0)
    solution = frame.solve()
    assert solution.status.tolist() == [["regular"] * 3] * 5
    assert solution.linear.tolist() == [[True] * 3] * 2 + [[False] * 3] * 3


def test_without_clearance_the_estimate_is_that_of_the_load() -> None:
    """Below the load of 35 N at which the rod buckles across the plane."""
    solution, tight = leaning(0.3, 0.0, 10.0).solve(), leaning(0.3, [0.0, 1e-3], 10.0).solve()
    assert_allclose(tight.nonlinearity()[0], solution.nonlinearity(), rtol=1e-12)
    assert tight.nonlinearity()[1] > 2.0 * tight.nonlinearity()[0]


@pytest.mark.parametrize("asked", ["error_bound", "refined"])
def test_bounds_are_those_of_linear_solutions(asked: str) -> None:
    solution = leaning(0.3, 1e-3, 1.0).solve()
    with pytest.raises(FrameError, match=r"contacts.*clearance=False"):
        getattr(solution, asked)("top")
    with pytest.raises(FrameError, match=r"contacts.*clearance=False"):
        solution.sensitivity("top", "uy")
