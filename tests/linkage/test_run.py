"""``linkframe run``: what it writes is what the linkage does, the same seed, the same bits; bad files leave nothing."""

from __future__ import annotations

import csv
import re
from pathlib import Path

import meshio
import numpy as np
import pytest
from linkframe.framework import Frame, FrameError
from linkframe.framework.paraview.vtu import read_names
from linkframe.models import FourBar
from linkframe.models.command_line import main
from linkframe.models.linkage import read_linkage, write_linkage
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.job.table import as_csv, as_text, legend
from linkframe.models.sampling import draw
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import bennett, four_bar
from reference.spatial import stewart

LINKAGE = """\
title = "A slider-crank"
gravity = [0.0, -9.81]

[points]
A = [0.0, 0.0]
B = [0.1, 0.0]
C = [0.4, 0.0]

[links.crank]
points = ["A", "B"]
beam = "bar"

[links.rod]
points = ["B", "C"]
beam = "bar"

[links.piston]
points = ["C"]
mass = 2.0

[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "crank"]
drive = true

[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "rod"]
stiffness = [2e9, 2e9, 2e9, 2e9, 2e9, 0.0]
clearance = 1e-5

[joints.C]
kind = "revolute"
point = "C"
links = ["rod", "piston"]

[joints.slide]
kind = "prismatic"
point = "C"
links = ["ground", "piston"]
axis = [1.0, 0.0, 0.0]

[[loads]]
point = "C"
link = "piston"
fx = -500.0

[beams.bar]
section = "flat"
material = "steel"

[sections.flat]
shape = "rectangle"
y = 0.02
z = 0.01

[materials.steel]
E = 2e11
nu = 0.3
density = 7850.0
"""
RUN = """
[run]
points = ["B", "C"]
pose = 60.0

[run.drives.A]
start = 20.0
stop = 160.0
steps = 8
unit = "deg"
rate = 600.0
"""
TOLERANCES = """
[tolerances.rod]
of = ["points.C.0"]
distribution = "norm"
loc = 0.4
scale = 1e-4

[tolerances.gap]
of = ["joints.B.clearance"]
distribution = "uniform"
loc = 1e-5
scale = 1e-5

[tolerances.stiffness]
of = ["joints.B.stiffness"]
distribution = "norm"
loc = 2e9
scale = 1e8

[tolerances.load]
of = ["loads.0.fx"]
distribution = "norm"
loc = -500.0
scale = 25.0
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "slider.toml"
    path.write_text(text, encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("run")
    path = written(folder, LINKAGE + RUN.replace("[run]", "[run]\nsamples = 40\nrng = 7") + TOLERANCES)
    # The picture in space has tests of its own.
    assert main(["run", str(path), "--figures", "2d", "--out", str(folder / "out")]) == 0
    return folder


def table(path: Path) -> dict[str, np.ndarray]:
    with path.open(encoding="utf-8") as file:
        heading, *rows = csv.reader(file)
    return {name: np.array(column) for name, column in zip(heading, zip(*rows, strict=True), strict=True)}


def test_files(results: Path) -> None:
    names = {path.name for path in (results / "out").iterdir()}
    pictures = {"mechanism.png", "trajectory.png", "reactions.png", "histogram.png"}
    assert names == pictures | {
        "table.csv",
        "reactions.csv",
        "samples.npz",
        "trajectory.pvd",
        "trajectory",
        "report.md",
        "index.html",
    }
    assert len(list((results / "out" / "trajectory").glob("beams_*.vtu"))) == 8


def test_tables_are_what_the_linkage_does(results: Path) -> None:
    """Against the linkage read from the same file and moved by hand."""
    motion = read_linkage(results / "slider.toml").move(
        A=np.radians(np.linspace(20, 160, 8)), rates={"A": np.radians(600)}
    )
    found = table(results / "out" / "table.csv")
    assert_allclose(found["A_deg"].astype(float), np.linspace(20, 160, 8))
    assert_allclose(found["C_x"].astype(float), motion.position("C")[:, 0], rtol=1e-12)
    accuracy = motion.accuracy("C", inertia=True)
    for name, values in (
        ("compliance", accuracy.compliance),
        ("clearance", accuracy.clearance),
        ("total", accuracy.total),
    ):
        assert_allclose(found[f"C_{name}_x"].astype(float), values[:, 0], rtol=1e-9, atol=1e-15)
    assert set(found["status"]) == {"regular"}
    forces = table(results / "out" / "reactions.csv")
    assert_allclose(forces["A_drive_rz"].astype(float), motion.reactions().drive("A")[:, 0], rtol=1e-9)
    assert_allclose(forces["B_fy"].astype(float), motion.reactions().force("B")[:, 1], rtol=1e-9)


def test_samples_are_those_of_the_linkage_with_other_numbers(results: Path) -> None:
    """The first sample by a file that has its numbers written in."""
    inputs = read_inputs(results / "slider.toml")
    result = compute(inputs)
    assert result.displacement is not None
    saved = np.load(results / "out" / "samples.npz")
    assert_array_equal(saved["displacement"], result.displacement)
    assert saved["displacement"].shape == (40, 2, 8, 3)
    drawn = draw({name: t.distribution for name, t in inputs.tolerances.items()}, 40, 7)
    text = LINKAGE.replace(
        "C = [0.4, 0.0]", f"C = [{drawn['rod'][3]!r}, 0.0]".replace("np.float64(", "").replace(")", "")
    )
    text = text.replace("clearance = 1e-5", f"clearance = {float(drawn['gap'][3])!r}")
    text = text.replace(
        "[2e9, 2e9, 2e9, 2e9, 2e9, 0.0]", f"[{', '.join([repr(float(drawn['stiffness'][3]))] * 5)}, 0.0]"
    )
    text = text.replace("fx = -500.0", f"fx = {float(drawn['load'][3])!r}")
    one = results / "one.toml"
    one.write_text(text, encoding="utf-8")
    motion = read_linkage(one).move(A=np.radians(np.linspace(20, 160, 8)), rates={"A": np.radians(600)})
    place = motion.position("C") + motion.accuracy("C", inertia=True).total[:, :3]
    assert_allclose(saved["displacement"][3, 1], place - result.accuracy["C"].rigid, rtol=0.0, atol=1e-13)
    spread = table(results / "out" / "table.csv")["C_sigma_x"].astype(float)
    assert_allclose(spread, saved["displacement"][:, 1, :, 0].std(axis=0, ddof=1), rtol=1e-9)


def test_report(results: Path) -> None:
    text = (results / "out" / "report.md").read_text(encoding="utf-8")
    assert text.startswith("# A slider-crank\n")
    for part in (
        "8 poses × 40 samples, seed 7",
        "| piston | C | rigid |",
        "uniform(loc=1e-05, scale=1e-05)",
    ):
        assert part in text
    assert "Joint reactions: determinate" in text
    for name in ("mechanism.png", "trajectory.png", "reactions.png", "histogram.png", "index.html"):
        assert f"]({name})" in text


def test_rigid_links_without_tolerances(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """No beam, no sample: tables, drawing, and the links' lines for ParaView; what an earlier run left is gone."""
    out = tmp_path / "out"
    out.mkdir()
    for left in ("histogram.png", "samples.npz", "mine.txt"):
        (out / left).write_text("old", encoding="utf-8")
    text = (LINKAGE + RUN).replace('beam = "bar"', "mass = 1.0").replace("stop = 160.0", "stop = 180.0")
    assert main(["run", str(written(tmp_path, text)), "--out", str(out)]) == 0
    assert {path.name for path in out.iterdir()} == {
        *("mechanism.png", "trajectory.png", "reactions.png", "table.csv", "reactions.csv", "report.md", "mine.txt"),
        "index.html",
        *("trajectory", "trajectory.pvd"),
    }
    assert len(list((out / "trajectory").glob("links_*.vtu"))) == 8
    assert "drive A" in capsys.readouterr().out


def test_poses_that_cannot_be_assembled_are_told_and_the_others_done(tmp_path: Path) -> None:
    text = LINKAGE.replace("C = [0.4, 0.0]", "C = [0.17, 0.0]") + RUN.replace('points = ["B", "C"]', "")
    text = text.replace('beam = "bar"', "mass = 1.0").replace("pose = 60.0", "")
    assert main(["run", str(written(tmp_path, text)), "--out", str(tmp_path / "out")]) == 0
    status = table(tmp_path / "out" / "table.csv")["status"]
    assert status[0] == "regular"
    assert status[4].startswith("not assembled: gap")
    assert "not assembled" in (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
    assert len(list((tmp_path / "out" / "trajectory").glob("links_*.vtu"))) < 8


@pytest.mark.parametrize(
    ("old", "new", "at", "key", "told"),
    [
        ('unit = "deg"', 'unit = "grad"', None, "run.drives.A.unit", "choose one of rad, deg"),
        ("steps = 8", "steps = 0", None, "run.drives.A.steps", "whole number of poses, 1 or more"),
        ("steps = 8", "", "[run.drives.A]", "run.drives.A", "has no steps"),
        ("start = 20.0", 'start = "20"', None, "run.drives.A.start", "give a number"),
        ("[run.drives.A]", "[run.drives.B]", "[run]", "run", "joint 'A' is driven: give its values in"),
        (
            'points = ["B", "C"]\npose',
            'points = ["B", "Q"]\npose',
            'points = ["B", "Q"]',
            "run.points.1",
            "no point 'Q'",
        ),
        ("pose = 60.0", "posture = 60.0", None, "run.posture", "no such key here"),
        ("pose = 60.0", "samples = 1", None, "run.samples", "2 or more"),
        ("pose = 60.0", 'branch = "left"', None, "run.branch", "choose one of keep, switch"),
        ("pose = 60.0", "magnify = -1.0", None, "run.magnify", "above zero"),
        (
            'of = ["joints.B.clearance"]',
            'of = ["joints.B.gap"]',
            None,
            "tolerances.gap.of.0",
            "there is no 'joints.B.gap' in this file",
        ),
        ('of = ["joints.B.clearance"]', 'of = ["joints.B.kind"]', None, "tolerances.gap.of.0", "name a number"),
        ('of = ["joints.B.clearance"]', 'of = ["run.pose"]', None, "tolerances.gap.of.0", "no part of the linkage"),
        (
            'distribution = "uniform"',
            'distribution = "square"',
            None,
            "tolerances.gap.distribution",
            "distribution of scipy.stats",
        ),
        (
            "loc = 0.4\nscale = 1e-4",
            "loc = 0.4\nscale = -1e-4",
            "[tolerances.rod]",
            "tolerances.rod",
            "scale must be above 0",
        ),
        ("loc = 0.4\nscale = 1e-4", "mean = 0.4", "[tolerances.rod]", "tolerances.rod", "norm does not take mean"),
        ("mass = 2.0", "mass = -2.0", None, "links.piston.mass", "give zero or above"),
    ],
)
def test_bad_jobs_are_told_by_line_and_key_and_leave_nothing(
    old: str, new: str, at: str | None, key: str, told: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    text = LINKAGE + RUN + TOLERANCES
    assert text.count(old) == 1
    text = text.replace(old, new)
    line = 1 + text.splitlines().index(new if at is None else at)
    path = written(tmp_path, text)
    assert main(["run", str(path), "--out", str(tmp_path / "deep" / "out")]) == 2
    captured = capsys.readouterr()
    assert captured.err.startswith(f"linkframe run: error: {path}, line {line}, {key}: ")
    assert told in captured.err
    assert captured.out == ""
    assert [entry.name for entry in tmp_path.iterdir()] == ["slider.toml"]


def test_a_linkage_that_can_never_be_assembled_is_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = LINKAGE.replace("C = [0.4, 0.0]", "C = [0.17, 0.0]").replace('beam = "bar"', "mass = 1.0") + RUN
    text = text.replace("start = 20.0", "start = 80.0").replace("stop = 160.0", "stop = 100.0")
    assert main(["run", str(written(tmp_path, text)), "--out", str(tmp_path / "out")]) == 2
    assert "no pose can be assembled" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_dead_points_alone_are_told_as_such(tmp_path: Path) -> None:
    """A parallelogram in line: nothing has a number, and nothing is told as if it had one."""
    text = (Path(__file__).parents[2] / "examples" / "four_bar.toml").read_text(encoding="utf-8")
    for old, new in (("start = 0.0\nstop = 360.0\nsteps = 37", "values = [0.0, 180.0]"), ("pose = 30.0\n", "")):
        assert old in text
        text = text.replace(old, new)
    file, out = written(tmp_path, text), tmp_path / "out"
    assert main(["run", str(file), "--figures", "2d", "--format", "svg", "--out", str(out)]) == 0
    report = (out / "report.md").read_text(encoding="utf-8")
    assert "No pose has finite joint reactions." in report
    assert "| mean of samples | – ± – | – ± – |" in report
    assert "nan" not in report
    assert "do not move" not in report
    drawn = (out / "reactions.svg").read_text(encoding="utf-8")
    assert "no pose has a finite joint force" in drawn
    assert "no pose has a finite drive torque" in drawn


def test_no_drive(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(written(tmp_path, LINKAGE.replace("drive = true", ""))), "--out", str(tmp_path / "o")]) == 2
    assert "moves nothing: drive a joint" in capsys.readouterr().err


def test_the_example_file_is_the_paper_s_four_bar() -> None:
    """Against the closed form of `FourBar` and its own frame, without clearance."""
    inputs = read_inputs(Path(__file__).parents[2] / "examples" / "four_bar.toml")
    result = compute(inputs)
    theta = np.radians(np.linspace(0, 360, 37))
    special = FourBar(stiffness=(2e11,) * 5 + (0.0,))
    assert_allclose(result.main.rigid, special.move(theta).position("P"), rtol=0.0, atol=1e-14)
    regular = np.isfinite(result.main.compliance).all(axis=-1)
    assert np.flatnonzero(~regular).tolist() == [0, 18, 36]
    marked = np.char.startswith(result.status, "outside the linear range: estimated error")
    assert np.all(marked | ~regular | (result.status == "regular"))
    assert isinstance(result.solution.frame, Frame)
    large = result.solution.frame.solve(large=True).displacement("P")[:, :3]
    off = np.linalg.norm(large - result.main.total[:, :3], axis=-1) / np.linalg.norm(large, axis=-1)
    assert np.all(off[marked] > 0.02)
    assert np.all(off[regular & ~marked] < 0.1)
    assert marked[1]
    assert not marked[9]
    frame = special.move(theta[regular]).frame()
    frame.load("P", fy=100.0)
    wanted = frame.solve().displacement("P")
    assert_allclose(result.main.compliance[regular], wanted, rtol=0.0, atol=1e-10 * np.abs(wanted).max())
    own = [f"{name}.{joint}" for name in ("clearance", "contact", "stiffness") for joint in "BDE"]
    assert sorted(inputs.tolerances) == sorted([*own, "fy"])


def test_a_platform_in_space(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Six drives at once, a linkage written by the program itself, drawings in space."""
    linkage, _, _ = stewart()
    linkage.load("O", fz=-100.0)
    path = tmp_path / "platform.toml"
    write_linkage(linkage, path)
    drives = "".join(f"[run.drives.M{k}]\nvalues = [0.0, {0.01 * k}, 0.03]\n" for k in range(6))
    path.write_text(path.read_text(encoding="utf-8") + drives, encoding="utf-8")
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 0
    found, forces = table(tmp_path / "out" / "table.csv"), table(tmp_path / "out" / "reactions.csv")
    motion = linkage.move({f"M{k}": np.array([0.0, 0.01 * k, 0.03]) for k in range(6)})
    assert_allclose(found["O_z"].astype(float), motion.position("O")[:, 2], rtol=1e-12)
    assert_allclose(forces["M3_drive_uz"].astype(float), motion.reactions().drive("M3")[:, 0], rtol=1e-9)
    assert (tmp_path / "out" / "mechanism.png").stat().st_size > 20_000
    # The first drive stands still, so that time is the number of the pose.
    series = (tmp_path / "out" / "trajectory.pvd").read_text(encoding="utf-8")
    assert 'timestep="2.0"' in series
    assert "M5" in capsys.readouterr().out


def test_a_motion_in_paraview(tmp_path: Path) -> None:
    """Links as lines, with what their points do; poses that are not assembled are left out."""
    motion = four_bar(0.4, 0.5, 0.45, 0.7, 1.0).move(A=np.radians([30.0, 180.0, 40.0]), rates={"A": 2.0})
    motion.save(tmp_path / "motion.pvd", times=[1.0, 2.0, 3.0])
    files = sorted((tmp_path / "motion").glob("*.vtu"))
    assert len(files) == 2
    mesh = meshio.read(files[1])
    assert_allclose(mesh.points[[0, 1, 3]], [motion.position(p)[2] for p in "ABD"], rtol=1e-14)
    assert_allclose(mesh.point_data["velocity"][3], motion.velocity("D")[2], rtol=1e-14)
    assert mesh.cells_dict["line"].tolist() == [[0, 1], [2, 3], [4, 5]]
    assert read_names(tmp_path / "motion.pvd") == {"link": ["crank", "coupler", "rocker"]}
    for bad, told in (("motion.vtu", "does not end in .pvd"), ("motion.pvd/motion.pvd", "cannot write")):
        with pytest.raises(FrameError, match=told):
            motion.save(tmp_path / bad)
    with pytest.raises(FrameError, match="give 3 increasing numbers"):
        motion.save(tmp_path / "motion.pvd", times=[1.0, 1.0, 2.0])
    with pytest.raises(FrameError, match=r"batch shape is \(3, 2\)"):
        four_bar(0.3, 0.9, 0.8, 0.7, 1.0).move(A=np.ones((3, 2))).save(tmp_path / "x.pvd")


def test_a_drawing_with_few_digits_moves_within_its_tolerance(tmp_path: Path) -> None:
    """Bennett's linkage, overconstrained, from a file with six digits behind the point."""
    exact = tmp_path / "exact.toml"
    write_linkage(bennett(0.6, 1.1, 1.0), exact)
    rounded = re.sub(r"-?\d+\.\d{7,}(e-?\d+)?", lambda number: f"{float(number[0]):.6f}", exact.read_text("utf-8"))
    drive = "[run.drives.H0]\nstart = 1.0\nstop = 1.5\nsteps = 6\n"
    for given, closed in (("", False), ("tolerance = 1e-5\n", True)):
        file = written(tmp_path, f"{rounded}\n[run]\n{given}{drive}")
        assert main(["run", str(file), "--out", str(tmp_path / "out")]) == 0
        status = table(tmp_path / "out" / "table.csv")["status"]
        assert all(text == "regular" for text in status[1:]) is closed
        report = (tmp_path / "out" / "report.md").read_text(encoding="utf-8")
        assert ("mobility 1 (" in report) is closed
        assert ("tolerance=" in report) is not closed


QUILL = """\
gravity = [0.0, 0.0, -9.81]
[points]
A = [0.3, 0.0, 0.5]
T = [0.3, 0.0, 0.2]
[links.quill]
points = ["A", "T"]
mass = 2.0
inertia = 0.01
[joints.A]
kind = "cylindrical"
point = "A"
links = ["ground", "quill"]
drive = true
[run.drives.A.rz]
values = [0.0, 90.0, 180.0]
unit = "deg"
rate = [0.0, 10.0, 20.0]
acceleration = 90.0
[run.drives.A.uz]
values = [0.0, 0.1, 0.3]
acceleration = [0.0, 1.0, 2.0]
"""


def test_both_drives_of_one_joint(tmp_path: Path) -> None:
    """A quill that is lifted and turned: m (g + a) and I alpha; rates pose by pose."""
    result = compute(read_inputs(written(tmp_path, QUILL)))
    forces = result.reactions.drive("A")
    assert_allclose(forces[:, 0], 2.0 * (9.81 + np.array([0.0, 1.0, 2.0])), rtol=1e-14)
    assert_allclose(forces[:, 1], 0.01 * np.pi / 2.0, rtol=1e-12)
    assert_allclose(result.motion.position("T")[:, 2], [0.2, 0.3, 0.5], rtol=1e-14)
    assert_allclose(result.motion.angular_velocity("quill")[:, 2], np.radians([0.0, 10.0, 20.0]), rtol=1e-13)
    moved = result.inputs.driven_poses.move(result.inputs.linkage, column=True)
    assert_allclose(moved.position("T")[:, 0], result.motion.position("T"))
    heading = as_csv(result).splitlines()[0]
    assert heading.startswith("A.uz,A.rz_deg,T_x")
    assert "drive A.uz  drive A.rz" in as_text(result)
    for old, new, told in (
        ("[run.drives.A.uz]", "[run.drives.A.ux]", "A.ux: there is no such key here: use one of uz, rz"),
        ("[run.drives.A.uz]", "[other]", "there is no such table"),
        ("[run.drives.A.uz]\nvalues = [0.0, 0.1, 0.3]\nacceleration = [0.0, 1.0, 2.0]\n", "", "A: has no uz"),
        ("[0.0, 10.0, 20.0]", "[0.0, 10.0]", r"A.rz.rate: has shape \(2,\): give one number, or 3, one a pose"),
    ):
        assert old in QUILL
        with pytest.raises(FrameError, match=told):
            read_inputs(written(tmp_path, QUILL.replace(old, new)))


@pytest.mark.parametrize(
    ("drive", "told", "label"),
    [
        ('A = { start = 20.0, stop = 40.0, steps = 3, unit = "deg" }', "A = 30°", "A [°]"),
        ('A = { start = 0.5, stop = 1.5, steps = 3, unit = "rad" }', "A = 1 rad", "A [rad]"),
        ("slide = { start = 0.0, stop = -0.02, steps = 3 }", "slide = -0.01 m", "slide [m]"),
    ],
)
def test_a_pose_is_told_in_the_unit_of_its_drive(tmp_path: Path, drive: str, told: str, label: str) -> None:
    text = LINKAGE.replace("B = [0.1, 0.0]", "B = [0.06, 0.08]").replace("C = [0.4, 0.0]", "C = [0.35, 0.0]")
    if drive.startswith("slide"):
        text = text.replace("drive = true\n", "").replace(
            "axis = [1.0, 0.0, 0.0]", "axis = [1.0, 0.0, 0.0]\ndrive = true"
        )
    path = tmp_path / "unit.toml"
    path.write_text(f'{text}\n[run]\npoints = ["B"]\n\n[run.drives]\n{drive}\n', encoding="utf-8")
    result = compute(read_inputs(path))
    assert result.where(1) == told
    assert f"{label}" in legend(result)
