"""Names that figures and tables take for something else: dollars, underscores, bars, breaks."""

from __future__ import annotations

import csv
from io import StringIO
from pathlib import Path

import matplotlib.image
import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.models import Linkage, write_linkage
from linkframe.models.command_line import main
from linkframe.models.job.figures import TracedPoint, draw_histograms, draw_trajectories
from linkframe.models.job.tables import markdown, separated
from linkframe.models.linkage.job.figures import draw_mechanism
from matplotlib.figure import Figure

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))
B, P, D = "B $x^{$", "_P", 'D|\\\n"$'
CRANK, COUPLER = "_crank $\\foo$", "cou|pler"


def four_bar() -> Linkage:
    linkage = Linkage(**{"A": (0, 0), B: (0, 0.1), P: (0.12, 0.19), D: (0.24, 0.16), "E": (0.22, 0)})
    for link, points in {CRANK: ("A", B), COUPLER: (B, P, D), "rocker": (D, "E")}.items():
        linkage.link(link, *points, beam=BAR)
    linkage.revolute("A", "ground", CRANK, drive=True)
    linkage.revolute(B, CRANK, COUPLER)
    linkage.revolute(D, COUPLER, "rocker")
    linkage.revolute("E", "rocker", "ground")
    return linkage


def drawn(figure: Figure, path: Path) -> None:
    """It can be drawn, and something is."""
    figure.savefig(path)
    assert matplotlib.image.imread(path).std() > 0.01


def test_a_drawing_shows_names_as_they_are(tmp_path: Path) -> None:
    figure = draw_mechanism(four_bar().move(A=np.linspace(0.0, 1.0, 5)), 2, [P], "costs $5 $x^{")
    drawn(figure, tmp_path / "mechanism.png")
    assert [text.get_text().strip() for text in figure.axes[0].get_legend().get_texts()] == [CRANK, COUPLER, "rocker"]


@pytest.mark.parametrize("name", ["P", B, P, D])
def test_figures_of_a_point_of_any_name(name: str, tmp_path: Path) -> None:
    samples = 1e-3 * np.random.default_rng(0).normal(size=(3, 20, 2))
    path = np.stack([np.arange(3.0), np.zeros(3)], axis=-1)
    drawn(draw_histograms([(samples[0], (name, "xy"))], "here"), tmp_path / "histogram.png")
    traced = TracedPoint(name, "xy", path, path, samples)
    drawn(draw_trajectories([traced], 10.0, 1, "here"), tmp_path / "trajectory.png")


def test_a_job_of_such_names(tmp_path: Path) -> None:
    file = tmp_path / "linkage.toml"
    write_linkage(four_bar(), file)
    drive = "[run.drives.A]\nstart = 0.0\nstop = 1.0\nsteps = 3\n[[loads]]\npoint = '_P'\nfy = 10.0\n"
    file.write_text(file.read_text(encoding="utf-8") + drive, encoding="utf-8")
    assert main(["run", str(file), "--figures", "2d", "--out", str(tmp_path / "out")]) == 0
    heading = next(csv.reader(StringIO((tmp_path / "out" / "reactions.csv").read_text(encoding="utf-8"))))
    assert any(name.startswith(f"{B}_") for name in heading)


def test_tables_keep_their_columns() -> None:
    lines = markdown(["a|b", "c"], [["d\ne", "f|"]]).splitlines()
    assert lines == [r"| a\|b | c |", "| --: | --: |", r"| d e | f\| |"]
    assert list(csv.reader(StringIO(separated([D], [[1.0]])))) == [[D], ["1.0"]]
