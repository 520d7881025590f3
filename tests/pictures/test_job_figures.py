"""Figures of the jobs: all points, in space too, everything explained, in the forms asked for."""

from __future__ import annotations

import warnings
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.models.command_line import main
from linkframe.models.job.figures import TracedPoint, draw_histograms, draw_trajectories
from linkframe.models.job.letters import missing_letters
from linkframe.models.job.outcome import magnification
from linkframe.models.linkage.job.run import LinkageJob
from linkframe.models.paper.drawing import draw_linkage
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from numpy.testing import assert_allclose
from pictures.test_plots import legible

ARM = """\
[points]
A = [0.0, 0.0]
B = [0.5, 0.0]
[links.arm]
points = ["A", "B"]
mass = 1.0
[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "arm"]
drive = true
[run]
points = ["B"]
[run.drives.A]
values = [0.0, 1.0]
"""
RNG = np.random.default_rng(0)
PATH = 0.1 * np.stack([np.cos(np.linspace(0, 2, 6)), np.sin(np.linspace(0, 2, 6)), np.linspace(0, 1, 6)], axis=-1)
SPREAD = np.array([3e-3, 1e-3, 0.0]) + 1e-5 * RNG.normal(size=(6, 40, 3))


def traced(name: str, ways: str) -> TracedPoint:
    count = len(ways)
    return TracedPoint(name, ways, PATH[:, :count], PATH[:, :count], SPREAD[..., :count])


def test_all_points_are_drawn() -> None:
    figure = draw_trajectories([traced("P", "xy"), traced("Q", "xy")], 10.0, 2, "A = 30°")
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert [label for label in labels if label.startswith("x of")] == ["x of P [mm]", "x of Q [mm]"]
    assert len(figure.axes) == 4


def test_the_cloud_fills_its_panel_however_far_off_zero_it_is() -> None:
    """3 mm off, with a deviation of 10 µm; what rings and circles are stands in the legend."""
    figure = draw_trajectories([traced("P", "xy")], 10.0, 2, "A = 30°")
    left, right = figure.axes
    figure.canvas.draw()
    cloud = 1e3 * SPREAD[2, :, :2]
    assert np.ptp(cloud[:, 0]) > 0.3 * np.ptp(right.get_xlim()) or np.ptp(cloud[:, 1]) > 0.3 * np.ptp(right.get_ylim())
    ring = next(line for line in left.lines if line.get_label() == "A = 30°")
    assert_allclose(ring.get_xydata(), 1e3 * PATH[2:3, :2])
    assert "A = 30°" in [text.get_text() for text in left.get_legend().get_texts()]  # type: ignore[union-attr]
    legible(figure)


def test_a_pose_without_results_is_told() -> None:
    """The path of the other poses is drawn all the same."""
    spread = SPREAD.copy()
    spread[2] = np.nan
    left, right = draw_trajectories([replace(traced("P", "xy"), samples=spread[..., :2])], 10.0, 2, "A = 30°").axes
    assert right.get_title(loc="left") == "no sample has a result at A = 30°"
    assert "singular pose" in [line.get_label() for line in left.lines]


def test_samples_in_space_are_drawn_in_space() -> None:
    figure = draw_trajectories([traced("P", "xyz")], 10.0, 2, "A = 30°")
    space: Any = figure.axes[0]
    assert space.name == "3d"
    lines = [np.stack(line.get_data_3d(), axis=-1) for line in space.lines if len(line.get_data_3d()[0]) == len(PATH)]
    for sample in (0, 39):
        wanted = 1e3 * (PATH + 10.0 * SPREAD[:, sample])
        assert any(np.allclose(line, wanted, rtol=0.0, atol=1e-9) for line in lines)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    # Nothing is cut off at the edges of the picture.
    pixels = np.asarray(canvas.buffer_rgba())[..., :3]
    inked = (pixels < 230).any(axis=-1)
    assert not inked[[0, -1]].any()
    assert not inked[:, [0, -1]].any()
    assert [axes.get_xlabel()[:5] for axes in figure.axes[1:]] == ["$u_x$", "$u_x$", "$u_y$"]


@pytest.mark.parametrize(("size", "unit"), [(1e-3, "mm"), (1e-6, "µm"), (1e-9, "nm")])
def test_histograms_have_a_unit_in_which_they_can_be_read(size: float, unit: str) -> None:
    figure = draw_histograms([(size * RNG.normal(size=(300, 2)), ("P", "xy"))], "A = 30°")
    assert all(f"[{unit}]" in axes.get_xlabel() and f"[1/{unit}]" in axes.get_ylabel() for axes in figure.axes)
    legible(figure)


def test_a_few_huge_displacements_do_not_hide_the_others() -> None:
    """Near a singular pose, a fifth of the poses is a hundred times as far off; the others are still seen."""
    moved = np.where(np.arange(100) < 80, 1e-4, 1e-2)
    assert magnification(moved, 0.01) == 20.0
    assert magnification(np.full(10, 1e-4), 0.01) == 100.0


def test_figure_5_has_axes_and_is_to_scale() -> None:
    at = {"A": (0, 0), "B": (0.1, 0.0), "P": (0.2, 0.02), "D": (0.3, 0.0), "E": (0.2, -0.1)}
    (axes,) = draw_linkage({name: np.array([*place, 0.0]) for name, place in at.items()}, (0.0, 50.0), 0.0).axes
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("x [m]", "y [m]")
    assert axes.axison
    assert axes.get_aspect() == 1.0
    coupler = next(line for line in axes.lines if line.get_label() == "coupler")
    assert_allclose(coupler.get_xydata(), [at[name] for name in "BPD"], atol=1e-15)


def test_figures_in_other_forms(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The text of an SVG stays text; a run without a form removes it; the report shows what is there."""

    def figures(_: LinkageJob) -> Iterator[tuple[str, Figure]]:
        figure = Figure(figsize=(2.0, 1.0))
        figure.text(0.1, 0.5, "coupler")
        yield "mechanism.png", figure

    monkeypatch.setattr(LinkageJob, "figures", figures)
    file, out = tmp_path / "arm.toml", tmp_path / "out"
    file.write_text(ARM, encoding="utf-8")
    few = ["run", str(file), "--figures", "2d", "--out", str(out)]
    assert main([*few, "--format", "svg", "pdf"]) == 0
    assert ">coupler<" in (out / "mechanism.svg").read_text(encoding="utf-8")
    assert (out / "mechanism.pdf").read_bytes().startswith(b"%PDF")
    assert not list(out.glob("*.png"))
    assert "](mechanism.svg)" in (out / "report.md").read_text(encoding="utf-8")
    before = (out / "mechanism.svg").read_bytes()
    assert main([*few, "--format", "svg"]) == 0
    assert not list(out.glob("*.pdf"))
    assert (out / "mechanism.svg").read_bytes() == before
    assert main([*few, "--format", "pdf"]) == 0
    assert "\n[The linkage at A = " in (out / "report.md").read_text(encoding="utf-8")


def test_letters_that_the_font_has_not_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """In a sentence, in place of warnings of the program that draws."""
    file = tmp_path / "arm.toml"
    file.write_text(ARM.replace("B = ", '"图" = ').replace('"B"', '"图"'), encoding="utf-8")
    assert main(["run", str(file), "--figures", "2d", "--out", str(tmp_path / "out")]) == 0
    told = "The font of the figures has no 图: a box stands in place of each letter"
    assert told in capsys.readouterr().out.replace("\n", " ")
    assert f"**Note:** {told}" in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")


def test_other_warnings_of_the_program_that_draws_go_on() -> None:
    with pytest.warns(UserWarning, match="^the axes are too small$"), missing_letters() as notes:
        warnings.warn("the axes are too small", UserWarning, stacklevel=1)
    assert notes == []
