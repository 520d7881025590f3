"""Equilibrium paths of frames that give way at rest: journals in their clearances, and free hinges."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.large.path import EquilibriumPath
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
GAPS = np.array([1e-4, 1e-2])


def chain(force: ArrayLike, clearance: ArrayLike = GAPS, turning: float = 5.0) -> Frame:
    """A cantilever AB, and a bar CD that hangs on it by a spring against turning and a journal with play."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(2e8, 2e8, 2e8, 2e5, 2e5, turning), clearance=clearance), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.load("D", fy=force)
    return frame


@pytest.fixture(scope="module")
def path() -> EquilibriumPath:
    return chain(10.0).path("D", "uy", 1.2)


def test_a_path_begins_across_the_clearances(path: EquilibriumPath) -> None:
    """Every point is the equilibrium that load stepping finds under its share of the load."""
    assert len(path.factor) > 4
    assert_allclose(path.factor[:2], [[0.0, 0.0], [0.05, 0.05]])
    assert path.stable[1:][np.isfinite(path.factor[1:])].all()
    assert np.nanmax(path.displacement("D")[..., 1], axis=0).min() > 1.2
    for point, factor in zip(path.displacement("D")[1::3], path.factor[1::3], strict=True):
        there = np.isfinite(factor)
        found = chain(10.0 * np.where(there, factor, 0.1)).solve(large=True).displacement("D")
        assert_allclose(point[there], found[there], rtol=1e-7, atol=1e-10)


def test_the_journal_rests_where_the_load_pulls_it(path: EquilibriumPath) -> None:
    """The bar hangs lower in the wide bearing by the difference of the clearances."""
    first = path.displacement("D")[1]
    assert_allclose(first[1] - first[0], [0.0, GAPS[1] - GAPS[0], 0.0, 0.0, 0.0, 0.0], atol=1e-9)


def test_a_path_of_what_is_free_to_turn() -> None:
    """A bar on a free hinge stands in the direction of the load at once."""
    end = chain(10.0, 0.0, turning=0.0).path("D", "rz", 1.0).displacement("D")[-1]
    assert_allclose(end[5], np.pi / 2.0, rtol=1e-9)


def test_what_is_printed_of_a_path_is_a_line(path: EquilibriumPath) -> None:
    frame = "<Frame of shape (2,): 4 nodes, 2 members, 1 joint>"
    assert repr(path) == f"<EquilibriumPath of {len(path.factor)} points of {frame}>"
