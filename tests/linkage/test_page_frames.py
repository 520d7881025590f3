"""What pages do to follow real input, and the view in space: turned, enlarged, at the keyboard and by two fingers."""

from __future__ import annotations

import importlib.util
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkage.browser import SET, Browser
from linkage.test_page import TOLERANCES, arm_in_space, four_bar
from linkframe.framework import FrameError
from linkframe.models import Linkage, Motion
from numpy.testing import assert_allclose

EXAMPLES = Path(__file__).parents[2] / "examples"


def stewart_platform() -> Motion:
    """The platform of the example, under a load."""
    spec = importlib.util.spec_from_file_location("stewart_platform_of_page", EXAMPLES / "stewart_platform.py")
    assert spec is not None
    assert spec.loader is not None
    example = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(example)
    linkage = example.linkage
    linkage.load("P", fx=100.0, fz=-2000.0)
    motion: Motion = linkage.move({f"leg {k}": example.lengths[:, k] for k in range(6)})
    return motion


@pytest.fixture(scope="module")
def platform() -> Motion:
    return stewart_platform()


@pytest.fixture(scope="module")
def stewart(platform: Motion, tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("stewart") / "stewart.html"
    legs = range(6)
    gaps = {f"C{k}": 2e-5 for k in legs}
    platform.page(path, "P", drives={f"leg {k}": 1e-4 for k in legs}, clearances=gaps)
    return path


def followed(browser: Browser, what: str, by: tuple[float, float]) -> dict[str, int]:
    """What is done while something is dragged by the mouse: frames that are shown, how often the page is drawn anew
    and asks for that, and most displacements that are looked for in one drawing."""
    browser.run(
        """
        window.scrollTo(0, 0);
        Object.assign(window, { shown: 0, asked: 0, drawn: 0, found: 0, most: 0 });
        if (!window.plain) {
          window.plain = [refresh, redraw, outermost];
          refresh = (key) => { asked += 1; plain[0](key); };
          redraw = () => { drawn += 1; found = 0; plain[1](); most = Math.max(most, found); };
          outermost = (...words) => { found += 1; return plain[2](...words); };
        }
        window.tick = () => { shown += 1; window.counting = requestAnimationFrame(tick); };
        requestAnimationFrame(tick);
        """
    )
    start = browser.run(f"const box = ({what}); return box;")
    browser.drag(start, by, steps=16)
    found: dict[str, int] = browser.run(
        "cancelAnimationFrame(counting); return { frames: shown, asked, drawn, displacements: most };"
    )
    return found


SLIDER = """(() => {
  const input = document.getElementById(KEY);
  input.scrollIntoView({ block: "center" });
  const box = input.getBoundingClientRect();
  const share = (input.value - input.min) / (input.max - input.min);
  return [box.left + 8 + share * (box.width - 16), box.top + box.height / 2];
})()"""


VIEW = "(() => { const box = view.getBoundingClientRect(); return [box.left + 20, box.top + 20]; })()"


def slider(key: str) -> str:
    return SLIDER.replace("KEY", f"'{key}'")


def follows(browser: Browser, where: str, what: str, displacements: int) -> None:
    """Whether a value follows what is dragged, drawn once a frame at most and with few displacements to look for."""
    before = browser.run(f"return {what}")
    found = followed(browser, where, (130.0, 40.0))
    assert browser.run(f"return {what}") != before
    assert found["asked"] > 10
    assert 0 < found["drawn"] <= min(found["asked"], found["frames"])
    assert 0 < found["displacements"] < displacements


def test_a_four_bar_follows_sliders(browser: Browser, tmp_path: Path) -> None:
    """Its path and zones are looked for where they change alone, and once a frame, however often something moves."""
    four_bar().page(tmp_path / "four.html", "P", **TOLERANCES)
    browser.open(tmp_path / "four.html")
    follows(browser, slider("pose"), "state.pose", 200)
    follows(browser, slider("limit-0"), "state.radii[0]", 2000)
    moves = """
        drawn = 0;
        const input = document.getElementById("pose");
        for (let k = 0; k < 10; k += 1) { input.value = k; input.dispatchEvent(new Event("input")); }
        return drawn;
        """
    assert browser.run(moves) == 0
    assert browser.wait("return drawn", lambda drawn: drawn) == 1
    assert browser.run("return state.pose") == 9


def test_a_stewart_platform_follows(browser: Browser, stewart: Path) -> None:
    """In space the largest displacement is looked for among 400 directions, at the pose that is shown alone."""
    assert stewart.stat().st_size < 1_000_000
    browser.open(stewart)
    follows(browser, slider("pose"), "state.pose", 1000)
    follows(browser, slider("limit-3"), "state.radii[3]", 2500)
    follows(browser, VIEW, "state.yaw", 2500)


def test_numbers_of_the_stewart_platform_are_pythons(browser: Browser, platform: Motion, stewart: Path) -> None:
    browser.open(stewart)
    rng = np.random.default_rng(4)
    for _ in range(20):
        pose, load, radii = int(rng.integers(61)), rng.integers(-200, 201) / 100, rng.integers(0, 301, size=12) / 100
        sliders = {"pose": pose, "load": load} | {f"limit-{k}": value for k, value in enumerate(radii)}
        found = browser.run(SET, {key: str(value) for key, value in sliders.items()})
        lengths = {f"leg {k}": platform.coordinate(f"leg {k}")[pose, 0] for k in range(6)}
        motion = platform.linkage.move(lengths)
        gaps = {f"C{k}": 2e-5 * radii[k] for k in range(6)}
        worst = motion.worst_case("P", clearances=gaps, drives={f"leg {k}": 1e-4 * radii[6 + k] for k in range(6)})
        assert_allclose([float(found[f"place-{axis}"]) for axis in "xyz"], motion.position("P"), rtol=1e-11, atol=1e-15)
        assert_allclose(float(found["worst"]), worst.greatest, rtol=1e-9)
        assert_allclose(float(found["angle"]), worst.angle, rtol=1e-9)
        for leg in ("leg 2", "leg 5"):
            assert_allclose(float(found[f"drive-{leg}"]), load * motion.reactions().drive(leg)[0], rtol=1e-9)


def test_a_finger_drags_too(browser: Browser, tmp_path: Path) -> None:
    four_bar().page(tmp_path / "four.html", "P")
    browser.open(tmp_path / "four.html")
    start, end = browser.run(
        """
        const box = view.getBoundingClientRect();
        return [0, 9].map((pose) => place(data.points.B[pose])).map(([x, y]) =>
          [box.left + x * box.width / WIDTH, box.top + y * box.height / HEIGHT]);
        """
    )
    browser.drag(start, np.subtract(end, start).tolist(), steps=6, kind="touch")
    assert abs(browser.run("return state.pose") - 9) <= 1


def test_dark_and_on_paper(browser: Browser, tmp_path: Path) -> None:
    """The page and its canvas are light on dark where the system is, and dark on white on paper, with all opened."""
    arm_in_space().page(tmp_path / "arm.html", "C", drives={"A": 1e-4})
    browser.open(tmp_path / "arm.html")
    look = """
        redraw();
        const opened = document.querySelectorAll("[open]").length;
        return [getComputedStyle(document.body).backgroundColor, colour.ink.trim(), opened];
        """
    assert browser.run(look) == ["rgb(255, 255, 255)", "#1d2430", 0]
    try:
        browser.command("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": "dark"}])
        dark = ["rgb(20, 24, 30)", "#e6e9ee", 0]
        assert browser.wait(look, lambda found: found == dark) == dark
        browser.run("window.dispatchEvent(new Event('beforeprint'))")
        assert browser.run(look) == ["rgb(255, 255, 255)", "#000", 2]
        browser.run("window.dispatchEvent(new Event('afterprint'))")
        assert browser.run(look) == dark
    finally:
        browser.command("Emulation.setEmulatedMedia", features=[])


def painted(browser: Browser) -> list[Any]:
    """How much of the canvas is painted, and the middle of it."""
    found: list[Any] = browser.run(
        """
        redraw();
        const all = pen.getImageData(0, 0, view.width, view.height).data;
        let count = 0, x = 0;
        for (let k = 0; k < all.length; k += 4) if (all[k + 3] > 0) { count += 1; x += (k / 4) % view.width; }
        return [count, x / count];
        """
    )
    return found


def test_the_view_in_space_turns_and_grows(browser: Browser, tmp_path: Path) -> None:
    arm_in_space().page(tmp_path / "arm.html", "C", drives={"A": 1e-4})
    browser.open(tmp_path / "arm.html")
    first = painted(browser)
    assert first[0] > 2000
    key = "view.dispatchEvent(new KeyboardEvent('keydown', {key: '%s', shiftKey: %s}));"
    pose = browser.run("return state.pose")
    browser.run(key % ("ArrowRight", "true"))
    assert browser.run("return [state.yaw, state.pose]") == [pytest.approx(-0.5), pose]
    assert painted(browser) != first
    browser.run(key % ("ArrowRight", "false"))
    assert browser.run("return state.pose") == pose + 1
    browser.run(key % ("+", "false"))
    whole = browser.run("return state.zoom / FIRST.zoom")
    assert whole == pytest.approx(1.2)
    browser.run("view.dispatchEvent(new WheelEvent('wheel', {deltaY: -100, cancelable: true}))")
    assert browser.run("return state.zoom / FIRST.zoom") == pytest.approx(1.2 * np.exp(0.2))
    browser.run(key % ("0", "false"))
    assert browser.run("return [state.zoom === FIRST.zoom, state.yaw]") == [True, -0.6]
    # Two fingers go apart to twice their distance.
    grown = browser.run(
        """
        view.setPointerCapture = () => {};
        const box = view.getBoundingClientRect();
        const finger = (kind, pointerId, x, y) => view.dispatchEvent(new PointerEvent(kind,
          { pointerId, clientX: box.left + x, clientY: box.top + y }));
        finger("pointerdown", 1, 10, 10);
        finger("pointerdown", 2, 110, 10);
        finger("pointermove", 2, 210, 10);
        finger("pointerup", 1, 10, 10);
        finger("pointerup", 2, 210, 10);
        return [state.zoom / FIRST.zoom, held, fingers.size];
        """
    )
    assert grown == [pytest.approx(2.0), None, 0]


def test_what_is_nearer_lies_before(browser: Browser, tmp_path: Path) -> None:
    """Places on the canvas are the projection; of two points one behind the other the nearer is drawn later."""
    motion = arm_in_space()
    motion.page(tmp_path / "arm.html", "C", drives={"A": 1e-4})
    browser.open(tmp_path / "arm.html")
    browser.run("state.yaw = 0.3; state.pitch = 0.7; look(); redraw();")
    seen = np.array(browser.run("return Object.values(data.points).map((places) => place(places[5]))"))
    points = np.array([motion.position(name)[5] for name in "ABC"])
    right = np.array([np.cos(0.3), -np.sin(0.3), 0.0])
    up = np.array([np.sin(0.7) * np.sin(0.3), np.sin(0.7) * np.cos(0.3), np.cos(0.7)])
    grow = browser.run("return scale * state.zoom")
    assert_allclose(np.diff(seen[:, 0]), grow * np.diff(points @ right), rtol=1e-9)
    assert_allclose(np.diff(seen[:, 1]), -grow * np.diff(points @ up), rtol=1e-9)
    assert_allclose(browser.run("return near"), np.cross(right, up), atol=1e-12)
    depths = browser.run("return parts.map((part) => part[0])")
    assert len(depths) > 5
    assert depths == sorted(depths)


def test_inputs_and_certainty_are_on_every_page(browser: Browser, tmp_path: Path) -> None:
    four_bar().page(tmp_path / "four.html", "P")
    browser.open(tmp_path / "four.html")
    told = browser.run("return [...document.querySelectorAll('details')].map((each) => each.textContent)")
    assert [text.split("#")[0][:10] for text in told] == ["Inputs", "Certainty "]
    assert "drive A: 0 to 6.19592" in told[0]
    assert "[joints.C]" in told[0]
    assert "12 digits" in told[1]


def five_bar() -> Linkage:
    linkage = Linkage(A=(-0.1, 0), B=(-0.2, 0.25), P=(0, 0.5), D=(0.2, 0.25), E=(0.1, 0))
    for name in ("AB", "BP", "DP", "ED"):
        linkage.link(name, *name)
    linkage.revolute("A", "ground", "AB", drive=True)
    linkage.revolute("B", "AB", "BP", clearance=1e-4)
    linkage.revolute("P", "BP", "DP")
    linkage.revolute("D", "DP", "ED")
    linkage.revolute("E", "ground", "ED", drive=True)
    return linkage


def test_each_of_two_drives_moves_by_itself(browser: Browser, tmp_path: Path) -> None:
    """All combinations of both; where P is dragged both follow."""
    linkage, left, right = five_bar(), np.linspace(-0.3, 0.3, 13), np.linspace(-0.4, 0.4, 17)
    linkage.page(tmp_path / "five.html", "P", drives={"A": left[:, None], "E": right})
    assert (tmp_path / "five.html").stat().st_size < 300_000
    browser.open(tmp_path / "five.html")
    for k, j in ((0, 0), (3, 11), (12, 16)):
        found = browser.run(SET, {"pose-0": str(k), "pose-1": str(j), "limit-0": "2"})
        motion = linkage.move(A=left[k], E=right[j])
        assert_allclose([float(found[f"place-{axis}"]) for axis in "xy"], motion.position("P")[:2], rtol=1e-10)
        worst = motion.worst_case("P", clearances={"B": 2e-4})
        assert_allclose(float(found["worst"]), worst.greatest, rtol=1e-9)
    dragged = browser.run(
        """
        const view = document.getElementById("view"), box = view.getBoundingClientRect();
        view.setPointerCapture = () => {};
        const at = (p) => ({ clientX: box.left + place(p)[0] * box.width / WIDTH,
          clientY: box.top + place(p)[1] * box.height / HEIGHT, pointerId: 1 });
        view.dispatchEvent(new PointerEvent("pointerdown", at(data.points.P[state.pose])));
        view.dispatchEvent(new PointerEvent("pointermove", at(data.points.P[17 * 5 + 4])));
        view.dispatchEvent(new PointerEvent("pointerup", { pointerId: 1 }));
        const inputs = ["pose-0", "pose-1"].map((key) => Number(document.getElementById(key).value));
        redraw();
        return [state.pose, inputs, document.getElementById("status").textContent];
        """
    )
    assert dragged[:2] == [17 * 5 + 4, [5, 4]]
    assert dragged[2].startswith(f"A = {np.degrees(left[5]):.6g}°, E = ".replace("-", "−"))
    browser.run("view.dispatchEvent(new KeyboardEvent('keydown', {key: 'ArrowUp'}))")
    assert browser.run("return state.pose") == 17 * 5 + 5


def test_grids_that_are_refused(tmp_path: Path) -> None:
    linkage, values = five_bar(), np.linspace(-0.2, 0.2, 40)
    with pytest.raises(FrameError, match="a page of 40 x 40 poses is too large"):
        linkage.page(tmp_path / "five.html", "P", drives={"A": values[:, None], "E": values})
    with pytest.raises(FrameError, match=r"drive 'A' varies along axes \[0, 1\]"):
        linkage.page(tmp_path / "five.html", "P", drives={"A": values[:4, None] + values[:4], "E": 0.0})
    arm = Linkage(A=(0, 0), B=[(1, 0), (2, 0)])
    arm.link("arm", "A", "B")
    arm.revolute("A", "ground", "arm", drive=True)
    with pytest.raises(FrameError, match=r"has a batch of shape \(2,\): give a drive value for each"):
        arm.page(tmp_path / "arm.html", "B")
