"""Pictures where rendering works, a clear word where it does not: both ways on every machine."""

from __future__ import annotations

import importlib.util
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning, view
from linkframe.framework.paraview.entries import series
from linkframe.framework.pictures import plotting, rendering
from linkframe.framework.pictures.drawing import Drawing, drawing
from linkframe.framework.pictures.rendering import RenderingError, can_render
from linkframe.framework.solution import Solution

BAR = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))


def arm(load: object = (0.0, -40.0, 80.0), second: tuple[float, float, float] = (0.5, 1.0, 0.0)) -> Solution:
    """Two bars on a stiff hinge, clamped at one end and pinned at the other."""
    frame = Frame()
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (0.0, 1.0, 0.0), "C": (0.0, 1.0, 0.0), "D": second}.items():
        frame.node(name, place)
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint(stiffness=(1e8, 1e8, 1e8, 1e6, 1e6, 1e2)), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.fix("D", "uy", "uz")
    frame.load("C", fx=load)
    return frame.solve()


def drawn(solution: Solution, scale: float | None = None, colour: str = "von_mises") -> Drawing:
    return drawing(solution, series(solution.shape, None, None, "test"), scale, colour)


@pytest.fixture
def fresh_probe() -> object:
    """The probe's memory, emptied before and after."""
    can_render.cache_clear()
    yield None
    can_render.cache_clear()


# -- the probe ------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("child", "answer"),
    [
        ("pass", True),
        ("raise SystemExit(1)", False),
        ("import os, signal; os.kill(os.getpid(), signal.SIGSEGV)", False),
    ],
)
def test_the_probe_outlives_its_child(
    monkeypatch: pytest.MonkeyPatch, fresh_probe: object, child: str, answer: bool
) -> None:
    monkeypatch.setattr(rendering, "PROBE", child)
    assert can_render() is answer


def test_the_probe_runs_once(monkeypatch: pytest.MonkeyPatch, fresh_probe: object) -> None:
    monkeypatch.setattr(rendering, "PROBE", "pass")
    can_render()
    monkeypatch.setattr(rendering, "PROBE", "raise SystemExit(1)")
    assert can_render()


# -- without rendering ----------------------------------------------------------------------------------------------


@pytest.mark.parametrize(("make", "file"), [(view.picture, "arm.png"), (view.movie, "arm.gif")])
def test_without_rendering_the_remedy_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, make: object, file: str
) -> None:
    assert callable(make)
    monkeypatch.setattr(plotting, "can_render", lambda: False)
    with pytest.raises(RenderingError, match=r"was not made: .*apt-get install .*libegl1 libgl1-mesa-dri"):
        make(arm(5.0), tmp_path / file)
    assert list(tmp_path.iterdir()) == []


def test_without_the_extra_a_movie_says_what_to_install(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plotting, "can_render", lambda: True)
    monkeypatch.setattr(plotting, "find_spec", lambda name: None)
    with pytest.raises(RenderingError, match=r"pip install 'linkframe\[movie\]'"):
        view.movie(arm(), tmp_path / "arm.gif")


# -- what is asked --------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("file", "options", "message"),
    [
        ("arm.bmp", {"entry": 0}, r"arm\.bmp does not end in \.png or \.jpg"),
        ("arm.png", {"entry": 0, "colour": "red"}, r"colour='red': choose one of von_mises, displacement"),
        ("arm.png", {}, r"batch shape is \(3,\)"),
        ("arm.png", {"entry": 0, "scale": np.nan}, r"scale of arm\.png contains nan"),
        ("arm.png", {"entry": 0, "scale": [1.0, 2.0]}, r"scale=\[1\.0, 2\.0\]: give one number"),
        ("arm.png", {"entry": 0, "size": (0, 100)}, r"size in pixels is 0: give a whole number of 1 or more"),
        ("arm.png", {"entry": 0, "size": 200}, r"size=200: give width and height in pixels"),
        ("arm.txt/arm.png", {"entry": 1}, r"cannot write in .*arm\.txt"),
    ],
)
def test_bad_requests_are_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, file: str, options: dict[str, object], message: str
) -> None:
    monkeypatch.setattr(plotting, "can_render", lambda: True)
    (tmp_path / "arm.txt").touch()
    with pytest.raises(FrameError, match=message):
        view.picture(arm(), tmp_path / file, **options)  # type: ignore[arg-type]
    assert [path.name for path in tmp_path.iterdir()] == ["arm.txt"]


def test_a_movie_has_a_rate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plotting, "can_render", lambda: True)
    with pytest.raises(FrameError, match="rate in poses a second is 0: give a whole number of 1 or more"):
        view.movie(arm(), tmp_path / "arm.gif", rate=0)


# -- on this machine ------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("colour", ["von_mises", "displacement"])
def test_a_picture_or_a_reason(tmp_path: Path, colour: view.Colour) -> None:
    path = tmp_path / "arm.png"
    if not can_render():
        with pytest.raises(RenderingError):
            view.picture(arm(), path, entry=2, colour=colour)
        assert not path.exists()
        return
    view.picture(arm(), path, entry=2, colour=colour, size=(480, 320))
    image = matplotlib.image.imread(path)[..., :3]
    assert image.shape == (320, 480, 3)
    assert (image[0] == 1.0).all()
    red = (image[..., 0] > 0.6) & (image[..., 1] < 0.35) & (image[..., 2] < 0.35)
    dark = image.max(axis=-1) < 0.25
    assert red.sum() > 40  # the force
    assert dark.sum() > 40  # the joint


def test_a_movie_or_a_reason(tmp_path: Path) -> None:
    path = tmp_path / "arm.gif"
    if not can_render() or importlib.util.find_spec("imageio") is None:
        with pytest.raises(RenderingError):
            view.movie(arm(), path)
        assert not path.exists()
        return
    view.movie(arm(), path, size=(240, 160))
    frames = frames_of(path)
    assert len(frames) == 3
    assert (frames[0] != frames[2]).any()


def frames_of(path: Path) -> list[np.ndarray]:
    from PIL import Image, ImageSequence

    with Image.open(path) as image:
        return [np.asarray(frame.convert("RGB")) for frame in ImageSequence.Iterator(image)]


# -- what is drawn --------------------------------------------------------------------------------------------------


def test_deformed_members_lie_at_the_scaled_displacements() -> None:
    solution = arm()
    shown = drawn(solution, scale=300.0)
    surface = shown.surfaces(2)["members"].points
    for member, nodes in enumerate(("AB", "CD")):
        own = np.split(surface, 2)[member]
        for node in nodes:
            end = solution.frame.position(node) + 300.0 * solution.displacement(node)[2, :3]
            # The round end of a tube lies at its radius from the member's end, and nothing of the tube is nearer.
            distance = np.sort(np.linalg.norm(own - end, axis=-1))
            np.testing.assert_allclose(distance[:100], 0.01 * np.hypot(0.5, 1.0), rtol=1e-6)


def test_the_largest_displacement_shows_at_a_round_scale() -> None:
    solution = arm()
    shown = drawn(solution)
    largest = np.linalg.norm(shown.shift, axis=-1).max()
    assert f"{shown.scale:e}"[0] in "125"
    assert 0.03 < shown.scale * largest / np.hypot(0.5, 1.0) <= 0.08


@pytest.mark.parametrize("colour", ["von_mises", "displacement"])
def test_the_colour_range_is_round_and_holds_all_values(colour: str) -> None:
    shown = drawn(arm(), colour=colour)
    assert 0.0 < shown.values.max() <= shown.top < 2.0 * shown.values.max()
    assert float(f"{shown.top:.2g}") == pytest.approx(shown.top, rel=1e-12)


def test_an_unloaded_structure_can_be_drawn() -> None:
    shown = drawn(arm(0.0))
    assert (shown.scale, shown.top) == (1.0, 1.0)
    assert set(shown.surfaces(0)) == {"undeformed", "members", "joints", "clamps", "pins"}


def test_supports_forces_and_joints_are_marked_where_they_are() -> None:
    solution = arm()
    shown = drawn(solution, scale=1.0)
    surfaces = shown.surfaces(2)
    for kind, place in (("clamps", (0.0, 0.0, 0.0)), ("pins", (0.5, 1.0, 0.0)), ("joints", (0.0, 1.0, 0.0))):
        assert np.linalg.norm(surfaces[kind].points - place, axis=-1).max() < 0.08
    # The clamp lies behind the end of its member, which leaves upwards.
    assert surfaces["clamps"].points[:, 1].max() == pytest.approx(0.0, abs=1e-12)
    # The arrows end at the loaded node: none at the first pose, half as long and the other way at the second.
    none, half, full = (shown.surfaces(pose)["forces"].points[:, 0] for pose in range(3))
    tip = solution.displacement("C")[:, 0]
    assert np.ptp(none) == 0.0
    assert (half.min(), full.max()) == pytest.approx((tip[1], tip[2]), rel=1e-12)
    assert np.ptp(full) == pytest.approx(0.16 * np.hypot(0.5, 1.0), rel=1e-9)
    assert np.ptp(half) == pytest.approx(0.5 * np.ptp(full), rel=1e-9)


def test_a_plane_structure_is_seen_at_right_angles() -> None:
    assert drawn(arm()).across == 2
    assert drawn(arm(second=(0.0, 1.0, 1.0), load=0.0)).across == 0
    assert drawn(arm(second=(0.5, 1.0, 0.7))).across is None


def test_a_mechanism_is_drawn_undeformed() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.fix("A", "ux", "uy", "uz", "rx", "ry")
    frame.load("B", fy=1.0)
    with pytest.warns(MechanismWarning):
        shown = drawn(frame.solve())
    assert not shown.solved.any()
    assert all(np.isfinite(surface.points).all() for surface in shown.surfaces(0).values())
    assert (shown.shift == 0.0).all()


def test_a_frame_without_members_is_refused() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.fix("A")
    with pytest.raises(FrameError, match="no member to draw"):
        drawn(frame.solve())
