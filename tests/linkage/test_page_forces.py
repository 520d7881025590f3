"""The page of a linkage with springs, gravity and inertia: what its numbers are at any factor on the loads."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage.browser import SET, Browser
from linkage.test_page import four_bar
from linkframe.elements import Beam, Material, Rectangle
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose

HEAVY = Beam(Rectangle(y=0.01, z=0.006), Material(E=2e11, nu=0.3, density=7850.0))
POSES = np.radians(np.arange(10.0, 350.0, 20.0))


def slider_crank(factor: float = 1.0, *, rate: float = 0.0, spring: bool = True) -> Motion:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), C=(0.4, 0), P=(0.2, 0.15), H=(0.7, 0))
    linkage.link("crank", "A", "B", beam=HEAVY)
    linkage.link("rod", "B", "P", "C", beam=HEAVY)
    linkage.link("piston", "C", mass=1.0)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "rod", clearance=5e-5)
    linkage.revolute("C", "rod", "piston", clearance=8e-5)
    linkage.prismatic("C", "ground", "piston", axis=(1, 0), name="slide")
    if spring:
        linkage.spring(("piston", "C"), ("ground", "H"), stiffness=2000.0, length=0.3)
    linkage.gravity((0, -9.81))
    if factor:
        linkage.load("C", fx=-200.0 * factor)
        linkage.load("P", fy=-40.0 * factor, link="rod")
    return linkage.move(A=POSES, rates={"A": rate})


def data_of(page: Path) -> dict[str, Any]:
    text = page.read_text(encoding="utf-8")
    found = re.search(r'type="application/json">(.*?)</script>', text, re.S)
    assert found is not None
    data: dict[str, Any] = json.loads(found[1])
    return data


def test_loads_scale_and_the_rest_stays(browser: Browser, tmp_path: Path) -> None:
    """Against the linkage with loads that many times as large, which Python solves anew."""
    slider_crank(rate=40.0).page(tmp_path / "crank.html", "P")
    browser.open(tmp_path / "crank.html")
    rng = np.random.default_rng(2)
    for factor in (-1.5, 0.0, 0.37, 2.0):
        motion = slider_crank(factor, rate=40.0)
        deflection = motion.accuracy("P", inertia=True).compliance
        forces, worst = motion.reactions(), motion.worst_case("P")
        for pose in rng.integers(len(POSES), size=5):
            found = browser.run(SET, {"pose": str(pose), "load": str(factor)})
            size = np.linalg.norm(deflection[pose, :2])
            shown = [float(found["loaded-x"]), float(found["loaded-y"])]
            assert_allclose(shown, deflection[pose, :2], rtol=1e-9, atol=1e-9 * size)
            for joint in motion.linkage.joints:
                size = np.linalg.norm(forces.force(joint)[pose, :2])
                assert_allclose(float(found[f"force-{joint}"]), size, rtol=1e-9)
            assert_allclose(float(found["drive-A"]), forces.drive("A")[pose, 0], rtol=1e-9, atol=1e-8)
            assert_allclose(float(found["angle"]), worst.angle[pose], rtol=1e-9)


def test_the_bound_holds_at_any_factor(browser: Browser, tmp_path: Path) -> None:
    """The bound on the page is no less than that of what it is combined from."""
    motion = slider_crank()
    motion.page(tmp_path / "crank.html", "P")
    browser.open(tmp_path / "crank.html")
    found = browser.run(SET, {"pose": "3", "load": "1"})
    solved = motion.accuracy("P")
    bound = np.broadcast_to(solved.closed.error_bound(solved.point), (len(POSES), 6))[3, :2].max()
    assert_allclose(float(found["bound"]), bound, rtol=1e-9)


@pytest.mark.parametrize("spring", [True, False])
def test_without_loads_the_rest_acts_alone(tmp_path: Path, spring: bool) -> None:
    """Nothing can be scaled then; springs are drawn from end to end."""
    motion = slider_crank(0.0, spring=spring)
    motion.page(tmp_path / "crank.html", "P")
    data = data_of(tmp_path / "crank.html")
    assert not data["scalable"]
    assert_allclose(data["loaded"]["displacement"]["whole"], motion.accuracy("P").compliance[:, :2], rtol=1e-11)
    assert len(data["springs"]) == spring
    for first, second in data["springs"]:
        assert_allclose(first, motion.position("C")[:, :2], rtol=1e-11, atol=1e-15)
        assert_allclose(second, np.broadcast_to([0.7, 0.0], (len(POSES), 2)))


def test_a_slider_is_drawn_along_its_slide(tmp_path: Path) -> None:
    slider_crank().page(tmp_path / "crank.html", "P")
    (slide,) = (joint for joint in data_of(tmp_path / "crank.html")["joints"] if joint["kind"] == "prismatic")
    assert_allclose(np.abs(slide["axis"]), np.broadcast_to([1.0, 0.0], (len(POSES), 2)), atol=1e-12)


def test_many_poses_are_thinned(tmp_path: Path) -> None:
    linkage = four_bar().linkage
    linkage.move(A=np.linspace(0.0, 6.0, 761)).page(tmp_path / "many.html", "P")
    data = data_of(tmp_path / "many.html")
    assert (tmp_path / "many.html").stat().st_size < 300_000
    assert len(data["status"]) == len(data["points"]["P"]) == -(-761 // data["every"])
    assert_allclose(data["drive"]["values"][1], np.degrees(6.0 * data["every"] / 760), rtol=1e-11)


def test_a_notebook_shows_the_page_where_the_point_is_clear() -> None:
    motion = four_bar()
    shown = motion._repr_html_()
    assert shown is not None
    assert "srcdoc=" in shown
    assert "Where P goes" in shown
    assert len(shown) < 300_000
    several = slider_crank()
    assert several._repr_html_() is None
    assert motion.linkage.move(A=0.1)._repr_html_() is None


def test_what_leaves_the_plane_is_shown_in_space(tmp_path: Path) -> None:
    """A plane linkage under a force across its plane deflects out of it."""
    motion = four_bar()
    motion.linkage.load("P", fz=5.0)
    loaded = motion.linkage.move(A=POSES)
    loaded.page(tmp_path / "across.html", "P")
    data = data_of(tmp_path / "across.html")
    assert data["dimensions"] == 3
    shown = np.array(data["loaded"]["displacement"]["whole"], dtype=float)
    assert_allclose(shown, loaded.accuracy("P").compliance[:, :3], rtol=1e-9, atol=1e-15)
    assert np.abs(shown[:, 2]).max() > 1e-6


def test_redundant_constraints_are_told(tmp_path: Path) -> None:
    """Bearings that tilt in an overconstrained linkage cannot do so each by itself: no wrong number is shown."""
    motion = four_bar().linkage.move(A=POSES)
    motion.page(tmp_path / "tilt.html", "P", journals=dict.fromkeys("BCD", 0.02))
    data = data_of(tmp_path / "tilt.html")
    assert data["limits"] == []
    assert "redundant constraints" in data["notes"][0]
