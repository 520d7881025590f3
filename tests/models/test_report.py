"""The job's results: table, samples, figures, ParaView files and what the report says of the paper."""

from __future__ import annotations

import csv
import re
from contextlib import redirect_stdout
from functools import cache
from io import StringIO
from pathlib import Path

import meshio
import numpy as np
import pytest
from linkframe.framework.pictures import drawing_process
from linkframe.models.command_line import main
from linkframe.models.four_bar import FourBar
from linkframe.models.job.figures import TracedPoint, draw_histograms, draw_trajectories
from linkframe.models.paper.drawing import draw_linkage
from linkframe.models.paper.formulas import equation_6, mean_direction
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.printed import printed
from linkframe.models.paper.result import Result, compute
from numpy.testing import assert_allclose

SINGULAR = "singular (direct-kinematic, type II): coupler and rocker in line"


@cache
def linear(inputs: Inputs = Inputs()) -> Result:  # noqa: B008 - inputs are frozen
    """Results of which those at large displacement are computed where they are read."""
    return compute(inputs, large=False)


@pytest.fixture(scope="module")
def job(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, str]:
    """The default job on a machine that cannot render, and what it prints."""
    out = tmp_path_factory.mktemp("job") / "results"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(drawing_process, "PROGRAM", "raise SystemExit(1)")
        with redirect_stdout(StringIO()) as text:
            assert main(["four-bar", "--out", str(out)]) == 0
    return out, text.getvalue()


@pytest.fixture(scope="module")
def table(job: tuple[Path, str]) -> dict[float, dict[str, str]]:
    with (job[0] / "table1.csv").open(encoding="utf-8") as file:
        return {float(row["theta_deg"]): row for row in csv.DictReader(file)}


@pytest.fixture(scope="module")
def report(job: tuple[Path, str]) -> str:
    return (job[0] / "report.md").read_text(encoding="utf-8")


def test_everything_is_written_and_nothing_else(job: tuple[Path, str]) -> None:
    out, _ = job
    names = {"table1.csv", "reactions.csv", "samples.npz", "report.md", "trajectory.pvd", "trajectory"}
    assert {path.name for path in out.iterdir()} == names | {
        "figure5.png",
        "figure6.png",
        "figure7.png",
        "reactions.png",
        "index.html",
    }


def test_the_report_names_the_arrays_that_are_in_the_files(job: tuple[Path, str], report: str) -> None:
    section = next(part for part in report.split("\n## ") if "Warp By Vector" in part)
    named = set(re.findall(r"`(\w+)`", section))
    mesh = meshio.read(job[0] / "trajectory" / "beams_000.vtu")
    assert {"displacement", "solved"} <= named <= {*mesh.point_data, *mesh.cell_data}


def test_a_second_run_replaces_the_first_and_leaves_the_rest(tmp_path: Path) -> None:
    (tmp_path / "mine.txt").write_text("mine", encoding="utf-8")
    (tmp_path / "figure3d.png").write_text("old", encoding="utf-8")
    for last, count, figures in (("60", 4, "2d"), ("40", 2, "none")):
        options = ["--poses", "30", last, "10", "--samples", "5", "--figures", figures]
        assert main(["four-bar", *options, "--out", str(tmp_path)]) == 0
        assert (tmp_path / "figure6.png").exists() == (figures == "2d")
        assert (tmp_path / "index.html").exists() == (figures == "2d")
        assert len(list((tmp_path / "trajectory").glob("beams*.vtu"))) == count
    assert (tmp_path / "mine.txt").read_text(encoding="utf-8") == "mine"
    assert not (tmp_path / "figure3d.png").exists()
    assert not list(tmp_path.glob(".*"))


def test_without_rendering_the_job_says_what_to_install(job: tuple[Path, str], report: str) -> None:
    assert "libegl1" in job[1]
    assert "libegl1" in report


def test_table_holds_the_run(table: dict[float, dict[str, str]]) -> None:
    result = linear()
    assert list(table) == list(np.arange(0.0, 361.0, 10.0))
    for i, row in enumerate(table.values()):
        theta = np.radians(float(row["theta_deg"]))
        assert_allclose(
            [float(row["x_m"]), float(row["y_m"])], 0.1 * np.array([1 + np.cos(theta), np.sin(theta)]), atol=1e-15
        )
        if i % 18 == 0:
            assert row["status"] == SINGULAR
            assert row["mu_x_m"] == row["sigma_y_m"] == ""
            assert float(row["kappa"]) > 1e15
        else:
            assert row["status"] == "regular" or row["status"].startswith("outside the linear range: estimated error")
            assert_allclose(float(row["mu_x_m"]), result.rigid[i, 0] + result.samples[i, :, 0].mean(), rtol=1e-14)
            assert_allclose(float(row["sigma_y_m"]), result.samples[i, :, 1].std(ddof=1), rtol=1e-12)
            assert 1e8 < float(row["kappa"]) < 1e10


def test_printed_values_stand_under_the_headings_that_fit(table: dict[float, dict[str, str]]) -> None:
    for angle, row in table.items():
        if angle in printed().theta and angle % 180.0:
            theta = np.radians(angle)
            assert abs(float(row["printed_mu_x"]) - 0.1 - 0.1 * np.cos(theta)) < 4.1e-3
            assert abs(float(row["printed_mu_y"]) - 0.1 * np.sin(theta)) < 3e-3
            assert 0.0 < float(row["printed_sigma_x"]) < 1e-3
            assert 0.0 < float(row["printed_sigma_y"]) < 1e-3
    assert table[40.0]["printed_kappa"] == ""
    assert float(table[230.0]["printed_kappa"]) == 5.4659e8


def test_terminal_shows_the_same_table(job: tuple[Path, str], table: dict[float, dict[str, str]]) -> None:
    lines = [line for line in job[1].splitlines() if re.match(r"\s*\d+ ", line)]
    assert len(lines) == len(table)
    for line, row in zip(lines, table.values(), strict=True):
        assert float(line.split()[0]) == float(row["theta_deg"])
        assert line.endswith(row["status"])
        if row["mu_x_m"]:
            assert f"{float(row['mu_x_m']):.6f}" in line
            assert f"{float(row['kappa']):.2e}" in line


def test_other_linkages_are_not_laid_beside_the_printed_values(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    other = linear(Inputs(rocker=0.12, poses=(30.0, 90.0, 30.0), samples=10))
    assert not other.inputs.is_paper_linkage
    from linkframe.models.paper.table import as_csv, as_text

    assert all(row["printed_mu_y"] == "" for row in csv.DictReader(as_csv(other).splitlines()))
    assert "│" not in as_text(other)


def test_samples_are_those_of_the_seed(job: tuple[Path, str]) -> None:
    saved = np.load(job[0] / "samples.npz")
    assert saved["displacement"].shape == (37, 100, 3)
    assert saved["status"][18] == SINGULAR
    again, other = linear(), linear(Inputs(rng=1))
    assert saved["displacement"].tobytes() == again.samples.tobytes()
    assert saved["displacement_large"].tobytes() == again.large.samples.tobytes()
    assert saved["input_fy"].tobytes() == again.draws["fy"].tobytes()
    assert not np.array_equal(saved["displacement"], other.samples, equal_nan=True)
    assert {"input_clearance.B", "input_contact.D", "input_stiffness.E"} <= set(saved.files)


def test_paraview_reads_every_pose(job: tuple[Path, str]) -> None:
    import pyvista

    reader = pyvista.PVDReader(str(job[0] / "trajectory.pvd"))
    assert reader.time_values == list(np.arange(0.0, 361.0, 10.0))
    reader.set_active_time_value(30.0)
    beams = reader.read()[0]["beams"]
    off = np.abs(beams.point_data["displacement"] - linear().compliance[3]).max(axis=1)
    assert off.min() < 1e-15  # one of the points is P


@pytest.mark.parametrize("name", ["figure5.png", "figure6.png", "figure7.png", "reactions.png"])
def test_figures_are_pictures_and_not_blank(name: str, job: tuple[Path, str]) -> None:
    from matplotlib.image import imread

    pixels = imread(job[0] / name)
    assert min(pixels.shape[:2]) > 500
    inked = (pixels[..., :3] < 0.9).any(-1)
    assert 0.01 < inked.mean() < 0.5
    assert not inked[[0, -1]].any(), "something is cut off at the edge"


def test_figures_show_the_data() -> None:
    result = linear()
    flat = (each[..., :2] for each in (result.path, result.rigid, result.samples))
    figure = draw_trajectories([TracedPoint("P", "xy", *flat)], 20.0, 3, "θ = 30°")
    left, right = figure.axes
    assert "20" in left.get_title(loc="left")
    drawn = np.array([line.get_xydata()[3] for line in left.lines[:100]])
    assert_allclose(drawn, 1e3 * (result.rigid[3, :2] + 20.0 * result.samples[3, :, :2]))
    cloud = next(line for line in right.lines if line.get_label() == "samples")
    assert_allclose(cloud.get_xydata(), 1e3 * result.samples[3, :, :2])
    for axes, values in zip(
        draw_histograms([(result.samples[3], ("P", "xy"))], "θ = 30°").axes, 1e3 * result.samples[3].T, strict=False
    ):
        assert_allclose(sum(bar.get_height() * bar.get_width() for bar in axes.patches), 1.0)
        assert f"{values.std(ddof=1):.3f}" in axes.get_title(loc="left")
    points = {name: result.motion.position(name)[22] for name in "ABPDE"}
    text = {note.get_text() for note in draw_linkage(points, (0.0, 50.0), np.radians(220.0)).axes[0].texts}
    assert {"θ = 220°", "50 N", "crank", "coupler", "rocker", "A", "E"} <= text


def test_choices_change_what_they_should() -> None:
    one = Inputs(poses=(30.0, 30.0, 1.0))
    base = linear(one)
    flat = linear(one.but(in_plane="short"))
    # Bending rules, and EI falls by the square of the ratio of the sides.
    assert_allclose(np.linalg.norm(flat.compliance) / np.linalg.norm(base.compliance), 4.0, rtol=0.02)
    half = linear(one.but(clearance_is="diameter"))
    assert_allclose(half.study.clearance.samples, 0.5 * base.study.clearance.samples, rtol=1e-10)
    assert_allclose(linear(one.but(poisson=0.0)).compliance, base.compliance, rtol=1e-12)
    shared = linear(one.but(joints="shared"))
    assert {"contact", "clearance", "stiffness"} <= set(shared.draws)
    exact = linear(one.but(closure="exact"))
    assert_allclose(exact.samples, base.study.compliance.samples + base.study.clearance_exact.samples)
    stiff = linear(one.but(stiffness=np.inf, stiffness_sd=0.0))
    assert np.isnan(stiff.kappa).all()
    assert_allclose(stiff.compliance, base.compliance, rtol=1e-3)
    varied = linear(one.but(length_sd=1e-4, young_sd=1e10))
    assert {"crank", "ground", "E.coupler"} <= set(varied.draws)
    assert linear(one.but(contact="reaction")).std[0, 1] < 0.2 * base.std[0, 1]


# -- against the paper --------------------------------------------------------------------------------------------


def test_report_has_all_five_points_with_numbers(report: str) -> None:
    headings = re.findall(r"^### (\d)\. ", report, flags=re.MULTILINE)
    assert headings == list("12345")
    assert "nan" not in report
    for name in ("figure5.png", "figure6.png", "figure7.png", "table1.csv", "trajectory.pvd"):
        assert name in report


def test_equation_6_is_not_a_beam() -> None:
    bar = FourBar().link_beam("crank")
    length, stiffness = 0.1, 2e11 * 6.35e-3 * 12.7e-3**3 / 12.0
    theirs, true = equation_6(bar, length)
    assert true.rigid_turn(1.0) < 1e-9 * 12.0 * stiffness / length**2
    assert_allclose(theirs.rigid_turn(1.0), 12.0 * stiffness / length**2, rtol=1e-12)
    assert true.exchange() < 1e-15
    assert theirs.exchange() > 1e-3
    assert_allclose(
        true.cantilever(100.0), [100 * length**3 / 3 / stiffness, 100 * length**2 / 2 / stiffness], rtol=1e-12
    )
    assert_allclose(
        theirs.cantilever(100.0), [100 * length**3 / 3 / stiffness, -100 * length**2 / 2 / stiffness], rtol=1e-12
    )


def test_report_states_this_runs_numbers(report: str, table: dict[float, dict[str, str]]) -> None:
    stiffness = 2e11 * 6.35e-3 * 12.7e-3**3 / 12.0
    assert f"| {1e-3 * 12.0 * stiffness / 0.1**2:.4g} |" in report  # N after a rigid turn by Eq. (6)
    assert f"{np.cos(np.pi) * np.exp(-(np.pi**2) / 2):.4g} ε" in report
    offset = 1e3 * (float(table[60.0]["mu_x_m"]) - float(table[60.0]["x_m"]))
    assert re.search(rf"^\| 60° \| \+3\.6 \| -1\.7 \| {re.escape(f'{offset:+.3f}')} ", report, flags=re.MULTILINE)
    assert re.search(rf"^\| 180° \| .* \| {re.escape(SINGULAR)} \|$", report, flags=re.MULTILINE)
    assert f"{float(table[30.0]['kappa']):.3e}" in report


def test_mean_contact_direction() -> None:
    nodes, weights = np.polynomial.hermite_e.hermegauss(60)
    for mean, deviation in ((180.0, 180.0), (30.0, 50.0), (0.0, 0.0)):
        gamma = np.radians(mean + deviation * nodes)
        assert_allclose(mean_direction(mean, deviation), weights @ np.cos(gamma) / np.sqrt(2.0 * np.pi), atol=1e-12)
