"""The page of a motion in a real browser: its numbers are Python's, and nothing leaves it."""

from __future__ import annotations

import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage.browser import SET, Browser
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import FrameError
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose
from reference.linkages import limited_four_bar

ROD = Beam(Rectangle(y=0.01, z=0.006), Material(E=2e11, nu=0.3))
TOLERANCES: dict[str, Any] = {"lengths": {"crank": 2e-5}, "drives": {"A": 1e-4}}


def four_bar() -> Motion:
    linkage = Linkage(A=(0, 0), B=(0, 0.1), C=(0.3, 0.25), D=(0.3, 0), P=(0.2, 0.3))
    linkage.link("crank", "A", "B", beam=ROD)
    linkage.link("coupler", "B", "C", "P", beam=ROD)
    linkage.link("rocker", "C", "D", beam=ROD)
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "coupler", clearance=5e-5)
    linkage.revolute("C", "coupler", "rocker", clearance=8e-5)
    linkage.revolute("D", "rocker", "ground", clearance=5e-5)
    linkage.load("P", fy=-50.0)
    return linkage.move(A=np.radians(np.arange(0.0, 360.0, 5.0)))


def arm_in_space() -> Motion:
    """A turning column with an arm on it that a ball and a slider carry: worst cases in all three directions."""
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 0.4), C=(0.5, 0, 0.4))
    linkage.link("column", "A", "B")
    linkage.link("arm", "B", "C")
    linkage.revolute("A", "ground", "column", axis=(0, 0, 1), drive=True, clearance=4e-5)
    linkage.revolute("B", "column", "arm", axis=(0, 1, 0), drive=True, clearance=3e-5)
    turn = np.linspace(0.0, 2.0, 21)
    return linkage.move(A=turn, B=0.4 * np.sin(turn))


def test_numbers_are_pythons(browser: Browser, tmp_path: Path) -> None:
    """At twenty settings of all sliders: position, compliance, worst case with its shares, forces in joints."""
    motion = four_bar()
    motion.page(tmp_path / "four.html", "P", **TOLERANCES)
    assert (tmp_path / "four.html").stat().st_size < 300_000
    browser.open(tmp_path / "four.html")
    rng = np.random.default_rng(0)
    compliance, forces = motion.accuracy("P").compliance, motion.reactions()
    for _ in range(20):
        pose, load, radii = int(rng.integers(72)), rng.integers(-200, 201) / 100, rng.integers(0, 301, size=5) / 100
        sliders = {"pose": pose, "load": load} | {f"limit-{k}": value for k, value in enumerate(radii)}
        found = browser.run(SET, {key: str(value) for key, value in sliders.items()})
        given = {
            "clearances": dict(zip("BCD", np.array([5e-5, 8e-5, 5e-5]) * radii[:3], strict=True)),
            "lengths": {"crank": 2e-5 * radii[3]},
            "drives": {"A": 1e-4 * radii[4]},
        }
        worst = motion.worst_case("P", **given)
        place = motion.position("P")[pose]
        assert_allclose([float(found["place-x"]), float(found["place-y"])], place[:2], rtol=1e-11)
        moved = load * compliance[pose, :2]
        assert_allclose([float(found["loaded-x"]), float(found["loaded-y"])], moved, rtol=1e-11)
        assert_allclose(float(found["worst"]), worst.greatest[pose], rtol=1e-9)
        for joint in "ABCD":
            size = np.linalg.norm(forces.force(joint)[pose, :2]) * abs(load)
            assert_allclose(float(found[f"force-{joint}"]), size, rtol=1e-9)
        shares = worst.contributors()
        for k, name in enumerate(["joint B", "joint C", "joint D", "length crank", "drive A"]):
            share = shares.worst[pose, shares.names.index(name)]
            assert abs(float(found[f"share-{k}"].removesuffix(" %")) - share) <= 0.051


def test_a_motion_in_space(browser: Browser, tmp_path: Path) -> None:
    motion = arm_in_space()
    motion.page(tmp_path / "arm.html", "C", drives={"A": 1e-4, "B": 2e-4})
    browser.open(tmp_path / "arm.html")
    worst = motion.worst_case("C", drives={"A": 1e-4, "B": 2e-4})
    for pose in (0, 7, 20):
        found = browser.run(SET, {"pose": str(pose)})
        assert_allclose([float(found[f"place-{axis}"]) for axis in "xyz"], motion.position("C")[pose], atol=1e-12)
        assert_allclose(float(found["worst"]), worst.greatest[pose], rtol=1e-9)


def test_dragging_follows_the_pointer(browser: Browser, tmp_path: Path) -> None:
    """A joint that is dragged takes the drive along; nothing is asked of anybody."""
    motion = four_bar()
    motion.page(tmp_path / "four.html", "P")
    browser.open(tmp_path / "four.html")
    found = browser.run(
        """
        const view = document.getElementById("view"), box = view.getBoundingClientRect();
        const at = (p) => ({
          clientX: box.left + place(p)[0] * box.width / WIDTH,
          clientY: box.top + place(p)[1] * box.height / HEIGHT,
          pointerId: 1,
        });
        const move = (pose) => view.dispatchEvent(new PointerEvent("pointermove", at(data.points.B[pose])));
        view.setPointerCapture = () => {};
        view.dispatchEvent(new PointerEvent("pointerdown", at(data.points.B[0])));
        for (let pose = 1; pose <= 12; pose += 1) move(pose);
        view.dispatchEvent(new PointerEvent("pointerup", {}));
        return [state.pose, performance.getEntriesByType("resource").length];
        """
    )
    assert found == [12, 0]


def test_the_page_stands_alone(tmp_path: Path) -> None:
    motion = four_bar()
    motion.page(tmp_path / "four.html", "P", title="</script> & <b>", command="as by hand")
    text = (tmp_path / "four.html").read_text(encoding="utf-8")
    assert not re.search(r"""(src|href)\s*=|@import|url\(|fetch\(|XMLHttpRequest""", text)
    assert text.count("</script>") == 2
    data = json.loads(re.search(r'type="application/json">(.*?)</script>', text, re.S)[1])  # type: ignore[index]
    assert data["title"] == "</script> & <b>"
    assert data["command"] == "as by hand"
    assert "NumPy" in data["versions"]
    assert_allclose(data["points"]["P"], motion.position("P")[:, :2], rtol=1e-11)


def chain(turns: object) -> Motion:
    """A four-bar whose crank cannot turn fully."""
    return limited_four_bar().move(A=turns)


def test_poses_that_cannot_be_assembled_are_empty(browser: Browser, tmp_path: Path) -> None:
    motion = chain(np.linspace(0.0, 3.0, 31))
    lost = ~motion.is_assembled
    assert lost.any()
    motion.page(tmp_path / "chain.html", "C")
    browser.open(tmp_path / "chain.html")
    browser.run(SET, {"pose": "3"})
    found = browser.run(SET, {"pose": str(int(np.flatnonzero(lost)[0]))})
    assert_allclose(float(found["place-x"]), motion.position("C")[3, 0], rtol=1e-11)


@pytest.mark.parametrize("turns", [True, False])
def test_a_linkage_shows_its_whole_range(tmp_path: Path, turns: bool) -> None:
    linkage = (four_bar() if turns else chain([0.0])).linkage
    linkage.page(tmp_path / "all.html", "C")
    text = (tmp_path / "all.html").read_text(encoding="utf-8")
    data = json.loads(re.search(r'type="application/json">(.*?)</script>', text, re.S)[1])  # type: ignore[index]
    values = np.array(data["drive"]["values"])
    ends = linkage.drive_range("A")
    span = 360.0 if turns else np.degrees(ends.upper - ends.lower)
    assert_allclose(np.ptp(values), span, rtol=3e-3)
    assert all(place[0] is not None for place in data["points"]["C"])
    assert len(text) < 300_000


def test_what_is_refused(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match="a page of a linkage with 2 drives: give their values"):
        arm_in_space().linkage.page(tmp_path / "arm.html", "C")
    with pytest.raises(FrameError, match=r"does not end in \.html"):
        chain([0.0, 0.1]).page(tmp_path / "four.pdf", "C")
    with pytest.raises(FrameError, match="give one axis of poses"):
        chain(0.0).page(tmp_path / "four.html", "C")
    with pytest.raises(FrameError, match="joint 'B' is no drive"):
        chain([0.0, 0.1]).page(tmp_path / "four.html", "C", drive="B")
