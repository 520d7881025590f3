"""Pictures of solutions: bearings about journals with clearance, and colours of members that tell little."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, Solution
from linkframe.framework.paraview.entries import series
from linkframe.framework.pictures.drawing import Drawing, drawing
from numpy.testing import assert_allclose
from skfem import BilinearForm

ROD = Beam(Circle(diameter=0.02), Material(E=210e9, nu=0.3), segments=4)
GAP = 1e-3


@BilinearForm
def foundation(u, v, w):  # type: ignore[no-untyped-def]
    return 1e4 * u[1] * v[1]


def hinged(directions: tuple[str, ...] = ("ux", "uy")) -> Solution:
    """An angle of two rods on a foundation, with clearance between them; pushed either way along x."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (0.4, 0, 0), "C": (0.4, 0, 0), "D": (0.4, 0.3, 0)}.items():
        frame.node(name, place)
    frame.add("AB", ROD, "A", "B")
    frame.add("CD", ROD, "C", "D")
    springs = np.array([1e9, 1e9, 1e9, 1e6, 1e6, 50.0])
    frame.add("hinge", Joint(stiffness=springs, clearance=GAP, clearance_directions=directions), "B", "C")
    frame.fix("A")
    frame.load("D", fx=[20.0, -20.0])
    frame.add_form(foundation, on="AB")
    return frame.solve()


def shown(solution: Solution) -> Drawing:
    return drawing(solution, series((2,), None, None, "test"), None, "von_mises")


def test_a_journal_lies_in_its_bearing_to_the_scale_of_the_displacements() -> None:
    solution = hinged()
    found = shown(solution)
    for pose in (0, 1):
        surfaces = found.surfaces(pose)
        bearing, journal = surfaces["bearings"].points, surfaces["joints"].points
        middle, inside = (0.5 * (points.min(axis=0) + points.max(axis=0)) for points in (bearing, journal))
        apart = (solution.displacement("C") - solution.displacement("B"))[pose, :3]
        assert_allclose(middle - inside, found.scale * apart, atol=1e-9)
        inner = np.linalg.norm((bearing - middle)[:, :2], axis=-1).min()
        assert inner == pytest.approx(np.ptp(journal[:, 2]) / 2 + found.scale * GAP, rel=5e-3)
        # It touches on the side on which it is pushed: beyond the clearance only its spring is pressed together.
        assert abs(apart[0]) == pytest.approx(GAP, rel=1e-3)
    assert len(found.surfaces(0)["bearings"].points) == len(found.surfaces(1)["bearings"].points)


def test_bearings_of_one_direction_are_stops_and_without_clearance_there_are_none() -> None:
    solution = hinged(("ux",))
    found = shown(solution)
    points = found.surfaces(0)["bearings"].points
    middle = 0.5 * (points.min(axis=0) + points.max(axis=0))
    assert np.abs(points - middle)[:, 0].min() > found.scale * GAP
    assert "bearings" not in shown(solution.frame.solve(clearance=False)).surfaces(0)


def test_colours_of_a_member_with_a_form_go_straight_from_segment_to_segment() -> None:
    solution = hinged()
    values = shown(solution).values[:, 0]
    ends = solution.stress("AB", np.linspace(0.0, 0.4, 5))[..., 2]
    along = [np.interp(np.linspace(0.0, 1.0, 25), np.linspace(0.0, 1.0, 5), row) for row in ends]
    assert_allclose(values, np.array(along) * values[0, 0] / ends[0, 0], rtol=1e-12)
