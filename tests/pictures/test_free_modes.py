"""Where nothing resists, figures show how it moves."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, MechanismWarning, Solution
from linkframe.framework.graphics.canvas import ARROW, FREE
from linkframe.framework.paraview.entries import series
from linkframe.framework.pictures.drawing import LONGEST, diagonal, drawing
from linkframe.framework.view import LOOKS
from linkframe.models import Linkage
from linkframe.models.linkage.graphics.bodies import MotionBodies
from numpy.testing import assert_allclose
from pictures.test_plots import artists

ROD = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3))
pytestmark = pytest.mark.filterwarnings(f"ignore::{MechanismWarning.__module__}.MechanismWarning")


def hinged() -> Solution:
    """A rod of 2 m with a point half way, on a hinge whose spring is there in the second entry alone."""
    frame = Frame()
    for name, x in {"O": 0.0, "A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    stiff = np.full((2, 6), 1e8)
    stiff[0, 5] = 0.0
    frame.fix("O")
    frame.add("hinge", Joint(stiffness=stiff), "O", "A")
    frame.add("AB", ROD, "A", "B")
    frame.add("BC", ROD, "B", "C")
    frame.load("C", fy=10.0)
    return frame.solve()


def test_a_mechanism_is_drawn_with_its_free_motion() -> None:
    axes: Any = hinged().plot(entry=0)
    assert axes.get_title(loc="left") == "mechanism: undeformed shape, no solution; arrows: free motion"
    arrows = artists(axes, "free motion")
    ways = np.array([np.subtract(each.xy, each.xyann) for each in arrows])
    begin = np.array([each.xyann for each in arrows])
    assert_allclose(begin, [[1.0, 0.0], [2.0, 0.0]], atol=1e-12)
    assert_allclose(ways[:, 0], 0.0, atol=1e-12)
    assert ways[1, 1] == pytest.approx(2.0 * ways[0, 1])
    assert not artists(hinged().plot(entry=1), "free motion")


def test_pictures_in_space_have_the_same_arrows_and_name_places() -> None:
    solution = hinged()
    shown = drawing(solution, series((2,), None, None, "test"), None, "von_mises")
    tips = shown.surfaces(0)["free"].points
    longest = LONGEST * diagonal(shown.rest)
    assert tips[:, 1].max() == pytest.approx(longest)
    assert np.ptp(shown.surfaces(1)["free"].points, axis=0).max() == 0.0 or shown.solved[1]
    assert [name for _, name in shown.told_names(0)] == ["O, A", "B", "C"]
    assert LOOKS["free"]["color"] == FREE


def test_no_picture_is_torn_where_no_load_works_on_the_free_motion() -> None:
    """A bent rod pulled through its hinge: how far it turns, nothing tells, and it is drawn as it is."""
    frame = Frame()
    for name, place in {"A": (0.0, 0.0, 0.0), "K": (3.0, 0.0, 0.0), "B": (3.0, 4.0, 0.0)}.items():
        frame.node(name, place)
    frame.add("AK", ROD, "A", "K")
    frame.add("KB", ROD, "K", "B")
    frame.fix("A", "ux", "uy", "uz", "rx", "ry")
    frame.load("B", fx=3.0, fy=4.0)
    solution = frame.solve()
    assert np.isnan(solution.displacement("B")).any()
    shown = drawing(solution, series((), None, None, "test"), 1e6, "von_mises")
    for surface in shown.surfaces(0).values():
        assert np.isfinite(surface.points).all()
    lines = [line.get_xydata() for line in solution.plot().lines]
    assert lines
    assert all(np.isfinite(line).all() for line in lines)


def test_a_linkage_at_a_dead_point_is_drawn_as_it_can_move() -> None:
    """Coupler and rocker in line, crank locked: the pin between them goes across them, the crank pin stands still."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
    links = ("ground", "AB", "BC", "CD", "ground")
    for link in links[1:-1]:
        linkage.link(link, *link)
    for k, pin in enumerate("ABCD"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    motion = linkage.move(A=[np.pi / 2, 0.3])
    axes: Any = motion.plot(pose=0)
    (arrow,) = artists(axes, "free motion")
    assert_allclose(arrow.xyann, (1.0, 0.0), atol=1e-9)
    assert arrow.xy[0] == pytest.approx(1.0)
    assert axes.get_title(loc="left") == "arrows: free motion, drives locked"
    assert_allclose(motion.free_velocity("C")[1], 0.0, atol=0.0)
    assert not artists(motion.plot(pose=1), "free motion")
    bodies = MotionBodies(motion, (0, 1))
    assert bodies.caption == "arrows: free motion, drives locked"
    long, none = (np.ptp(bodies.surfaces(k)["free"][0].points, axis=0).max() for k in (0, 1))
    assert long == pytest.approx(ARROW * bodies.scene(0).size)
    assert none == 0.0
