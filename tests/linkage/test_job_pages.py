"""The pages of the jobs and of a file: limits are those of the tolerances, samples those that were drawn."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from linkage.browser import SET, Browser
from linkage.test_page_forces import data_of
from linkframe.models import read_linkage, tolerance
from linkframe.models.command_line import main
from linkframe.models.distributions import ends
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.run import LinkageJob
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.job import FourBarJob
from numpy.testing import assert_allclose
from scipy import stats

EXAMPLE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
FILE = """\
title = "A four-bar <of mine>"
[points]
A = [0.0, 0.0]
B = [0.0, 0.1]
P = [0.15, 0.25]
C = [0.3, 0.25]
D = [0.3, 0.0]
[links.crank]
points = ["A", "B"]
[links.coupler]
points = ["B", "P", "C"]
[links.rocker]
points = ["C", "D"]
[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "crank"]
drive = true
reference = 0.5
[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "coupler"]
clearance = 5e-5
[joints.C]
kind = "revolute"
point = "C"
links = ["coupler", "rocker"]
[joints.D]
kind = "revolute"
point = "D"
links = ["rocker", "ground"]
[[loads]]
point = "P"
fy = -50.0
"""
RUN = """\
[run]
samples = 50
rng = 3
[run.drives.A]
start = 30.0
stop = 150.0
steps = 7
unit = "deg"
[tolerances.gap]
of = ["joints.B.clearance"]
distribution = "uniform"
loc = 4e-5
scale = 2e-5
[tolerances.place]
of = ["points.C.x"]
distribution = "uniform"
loc = 0.2999
scale = 2e-4
[tolerances.angle]
of = ["joints.A.reference"]
distribution = "norm"
loc = 0.5
scale = 1e-4
[tolerances.force]
of = ["loads.0.fy"]
distribution = "norm"
loc = -50.0
scale = 1.0
"""


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "bar.toml"
    path.write_text(FILE + RUN, encoding="utf-8")
    return path


def moved(file: Path, old: str, new: str) -> np.ndarray:
    """Displacement of P where one number of the file is another."""
    turns = np.radians(np.linspace(30.0, 150.0, 7))
    places = []
    for text in (FILE, FILE.replace(old, new)):
        assert text == FILE or text.count(new) == 1
        other = file.with_name("other.toml")
        other.write_text(text, encoding="utf-8")
        places.append(read_linkage(other).move(A=turns).position("P"))
    return np.asarray(places[1] - places[0])[:, :2]


def test_the_job_of_a_file(file: Path, tmp_path: Path) -> None:
    """Limits against the linkage with other numbers, by finite differences; the cloud within its worst case."""
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    job.page(tmp_path / "index.html")
    data = data_of(tmp_path / "index.html")
    limits = {limit["name"]: limit for limit in data["limits"]}
    assert set(limits) == {"joint B", "points.C.x", "joints.A.reference"}
    assert limits["joint B"]["radius"] == pytest.approx(6e-5)
    assert limits["points.C.x"]["radius"] == pytest.approx(1e-4)
    assert limits["points.C.x"]["middle"] == pytest.approx(0.0, abs=1e-15)
    assert limits["joints.A.reference"]["radius"] == pytest.approx(3e-4)
    step = 1e-6
    for name, old, new in (
        ("points.C.x", "C = [0.3, ", f"C = [{0.3 + step!r}, "),
        ("joints.A.reference", "reference = 0.5", f"reference = {0.5 + step!r}"),
    ):
        by = np.array(limits[name]["by"])[..., 0]
        assert_allclose(by, moved(file, old, new) / step, atol=2e-5)
    (note,) = (note for note in data["notes"] if "Not among" in note)
    assert "force" in note
    assert "place" not in note
    assert data["title"] == "A four-bar <of mine>"
    assert data["command"] == "linkframe run bar.toml"
    about = {each["title"]: each["text"] for each in data["about"]}
    assert FILE in about["Inputs: bar.toml"]
    assert "seed 3" in about["Inputs: bar.toml"]
    assert "Certainty of digits" in about
    samples = job.samples()["displacement"][:, 0, :, :2]
    cloud = np.array(data["cloud"])
    assert_allclose(cloud[..., 0].max(axis=1), samples[..., 0].max(axis=0), rtol=1e-4)
    assert_allclose(cloud[..., 1].min(axis=1), samples[..., 1].min(axis=0), rtol=1e-4)


def test_the_four_bar_is_that_of_its_file(tmp_path: Path, browser: Browser) -> None:
    """The paper's job and the same linkage from a file show the same numbers."""
    job = FourBarJob(Inputs(poses=(30.0, 150.0, 30.0), samples=10))
    job.compute(lambda *_: None)
    job.page(tmp_path / "index.html")
    assert main(["page", str(EXAMPLE), "--out", str(tmp_path / "file.html")]) == 0
    shown = []
    for path, pose in ((tmp_path / "index.html", 1), (tmp_path / "file.html", 6)):
        browser.open(path)
        shown.append(browser.run(SET, {"pose": str(pose), "load": "1.3"}))
    own, other = shown
    assert set(own) == set(other)
    for name in set(own) - {"bound", "worst-x", "worst-y"}:
        assert_allclose(
            float(own[name].removesuffix(" %")), float(other[name].removesuffix(" %")), rtol=1e-9, atol=1e-12
        )


BARS = """\
[beams.bar]
section = "flat"
material = "steel"
[sections.flat]
shape = "rectangle"
y = 0.003
z = 0.006
[materials.steel]
E = 2e11
nu = 0.3
"""


def bent(text: str) -> str:
    """The file with a shorter ground and slender beams, which bend beyond the linear range at some poses."""
    for link in ("crank", "coupler", "rocker"):
        text = text.replace(f"[links.{link}]\n", f'[links.{link}]\nbeam = "bar"\n')
    return text.replace("D = [0.3, 0.0]", "D = [0.2, 0.0]") + BARS


def test_the_page_says_of_a_pose_what_the_table_says(tmp_path: Path, browser: Browser) -> None:
    """Also where displacements are beyond the linear range; with other loads, that it is said of those given."""
    file = tmp_path / "bar.toml"
    file.write_text(bent(FILE) + RUN, encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    job.page(tmp_path / "index.html")
    status = data_of(tmp_path / "index.html")["status"]
    table = job.tables()["table.csv"].splitlines()[1:]
    assert status == [line.split(",")[-1] for line in table]
    beyond = next(k for k, each in enumerate(status) if each.startswith("outside the linear range: estimated error"))
    assert "regular" in status
    browser.open(tmp_path / "index.html")
    for load, more in (("1", ""), ("0.5", " (with the loads as given)")):
        browser.run(SET, {"pose": str(beyond), "load": load})
        told = browser.run("return document.getElementById('status').textContent")
        assert told == f"A = {30 + 20 * beyond}°: {status[beyond]}{more}"


def test_a_page_without_a_job_tells_where_its_deflection_is_not_linear(tmp_path: Path) -> None:
    """The greater the load the more poses; against the estimate of the solution whose displacement is shown."""
    told = []
    for load in (1.0, 40.0, 60.0):
        file = tmp_path / f"bar{load:g}.toml"
        file.write_text(bent(FILE.replace("fy = -50.0", f"fy = {-load}")), encoding="utf-8")
        motion = read_linkage(file).move(A=np.radians(np.linspace(30.0, 150.0, 13)))
        motion.page(tmp_path / "bar.html", "P")
        status = data_of(tmp_path / "bar.html")["status"]
        off = motion.frame().solve(clearance=False).nonlinearity()
        assert [each != "regular" for each in status] == (off > 0.05).tolist()
        told.append(sum(each != "regular" for each in status))
    assert told[0] == 0 < told[1] < told[2]


def test_the_page_of_a_file_without_a_job(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "bar.toml").write_text(FILE, encoding="utf-8")
    assert main(["page", str(tmp_path / "bar.toml"), "--out", str(tmp_path / "x.html")]) == 0
    assert "where P goes" in capsys.readouterr().out
    data = data_of(tmp_path / "x.html")
    assert len(data["status"]) > 100
    assert [limit["name"] for limit in data["limits"]] == ["joint B"]
    assert main(["page", str(tmp_path / "bar.toml"), "--out", str(tmp_path / "x.html"), "--point", "Q"]) == 2
    assert "--point Q: the file has A, B, P, C, D" in capsys.readouterr().err


STRAIGHT = """\
[points]
A = [0.0, 0.0]
B = [0.07, 0.1]
C = [0.41, 0.17]
[links.crank]
points = ["A", "B"]
beam = "bar"
[links.rod]
points = ["B", "C"]
beam = "bar"
[links.block]
points = ["C"]
[joints.A]
kind = "revolute"
point = "A"
links = ["ground", "crank"]
drive = true
[joints.B]
kind = "revolute"
point = "B"
links = ["crank", "rod"]
[joints.C]
kind = "revolute"
point = "C"
links = ["rod", "block"]
[joints.slide]
kind = "prismatic"
point = "C"
links = ["ground", "block"]
axis = [0.41, 0.17]
[[loads]]
point = "C"
fx = -24.6
fy = -10.2
[run]
points = ["B"]
[run.drives.A]
"""


def test_what_is_zero_is_shown_as_zero(tmp_path: Path, browser: Browser) -> None:
    """Where crank and rod lie in line with the load they turn nothing: rounding of the moment there is not shown."""
    file = tmp_path / "straight.toml"
    line = float(np.arctan2(0.17, 0.41) - np.arctan2(0.1, 0.07))
    file.write_text(STRAIGHT + f"values = [{line!r}, {line + 0.5!r}]\n" + BARS, encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    lines = job.summary().splitlines()
    straight, other = ([word for word in line.split(" ") if word] for line in lines[3:5])
    assert abs(float(job.tables()["reactions.csv"].splitlines()[1].split(",")[-2])) > 0.0
    assert straight[5] == "0"
    assert abs(float(other[5])) > 0.1
    job.page(tmp_path / "index.html")
    browser.open(tmp_path / "index.html")
    browser.run(SET, {"pose": "0"})
    shown = "return document.getElementById('row-drive-A').lastChild.textContent"
    assert browser.run(shown) == "0"
    assert browser.run(shown.replace("drive-A", "force-C")) == "0"


def test_a_deflection_of_rounding_is_shown_as_zero(tmp_path: Path) -> None:
    """Crank, rod and load along x: nothing moves across."""
    text = STRAIGHT.replace("[0.41, 0.17]", "[0.41, 0.0]").replace("fy = -10.2", "")
    line = -float(np.arctan2(0.1, 0.07))
    file = tmp_path / "straight.toml"
    file.write_text(text + f"values = [{line!r}, {line + 0.5!r}]\n" + BARS, encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    straight, other = ([word for word in line.split(" ") if word] for line in job.summary().splitlines()[3:5])
    assert abs(float(next(csv.DictReader(job.tables()["table.csv"].splitlines()))["B_total_y"])) > 0.0
    assert float(straight[4]) == 0.0
    assert min(abs(float(each[3])) for each in (straight, other)) > 0.0
    assert float(other[4]) != 0.0


class Quantiles:
    """A distribution of which nothing but its quantiles is known."""

    def __init__(self, of: stats.distributions.rv_frozen) -> None:
        self.ppf = of.ppf


def test_ends_of_distributions() -> None:
    """Limits where there are such; else quantiles, of Cauchy's distribution tan(π (p - 1/2))."""
    assert ends(stats.uniform(1.0, 2.0)) == (1.0, 3.0)
    assert_allclose(ends(stats.norm(1.0, 2.0)), (-5.0, 7.0), rtol=1e-12)
    assert_allclose(ends(stats.cauchy()), np.tan(np.pi * (stats.norm.cdf([-3.0, 3.0]) - 0.5)), rtol=1e-9)
    assert ends(tolerance(0.0, "± 0.03")) == (-0.03, 0.03)
    assert_allclose(ends(Quantiles(stats.norm(1.0, 2.0))), (-5.0, 7.0), rtol=1e-12)


def test_a_singular_pose_that_deflects_much_is_told_so(tmp_path: Path) -> None:
    """Its frame is solved, at the dead point of the block: both are told, there and in the next pose one of them."""
    line = float(np.arctan2(0.17, 0.41) - np.arctan2(0.1, 0.07))
    text = STRAIGHT.replace('point = "C"\nfx = -24.6\nfy = -10.2', 'point = "B"\nfx = -2000.0\nfy = 5000.0')
    file = tmp_path / "straight.toml"
    file.write_text(text + f"values = [{line!r}, {line + 0.5!r}]\n" + BARS, encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    straight, other = (row["status"] for row in csv.DictReader(job.tables()["table.csv"].splitlines()))
    assert straight.startswith("singular (inverse-kinematic, type I; joint C is stationary); outside the linear range")
    assert other.startswith("outside the linear range")
