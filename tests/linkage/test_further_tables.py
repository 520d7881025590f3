"""What any linkage's job tells beside its table when asked: condition numbers, digits, large displacement, choices."""

from __future__ import annotations

import csv
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import FourBar, accuracy
from linkframe.models.job import digits, outcome
from linkframe.models.linkage.job.inputs import RunInputs, read_inputs
from linkframe.models.linkage.job.optional_tables import columns, sections
from linkframe.models.linkage.job.remarks import remarks
from linkframe.models.linkage.job.result import RunResult, compute, work
from linkframe.models.linkage.job.run import LinkageJob
from linkframe.models.linkage.job.table import as_csv
from linkframe.models.paper import inputs as paper
from linkframe.models.paper.result import compute as compute_paper
from numpy.testing import assert_allclose

FILE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
CHOICE = """
[choices.flat]
"sections.flat.y" = 0.00635
"sections.flat.z" = 0.0127
"""
CONDITION = '["condition"]'
SHORT, SAMPLES = (20.0, 80.0, 30.0), 12


def asked(folder: Path, also: str = '["condition", "digits", "large"]', more: str = "") -> RunInputs:
    """The example's file with further tables, at a few poses."""
    text = FILE.read_text(encoding="utf-8").replace('points = ["P"]\npose', f'points = ["P"]\nalso = {also}\npose')
    text = text.replace("start = 0.0\nstop = 360.0\nsteps = 37", "start = 20.0\nstop = 80.0\nsteps = 3")
    text = text.replace("pose = 30.0\nsamples = 100", f"pose = 50.0\nsamples = {SAMPLES}")
    path = folder / "four_bar.toml"
    path.write_text(text + more, encoding="utf-8")
    return read_inputs(path)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> RunResult:
    return compute(asked(tmp_path_factory.mktemp("also"), more=CHOICE))


def test_they_are_those_of_the_paper_for_its_linkage(result: RunResult) -> None:
    """Which are computed from the four-bar's closed form."""
    theirs, ours = compute_paper(paper.Inputs(poses=SHORT, samples=SAMPLES)), result.outcome
    assert_allclose(ours.kappa, theirs.kappa, rtol=2e-6)  # eps times itself
    assert_allclose(ours.planar_kappa, theirs.planar_kappa, rtol=2e-6)
    assert (ours.planar_kappa < 0.9 * ours.kappa).all()
    assert_allclose(ours.large.samples, theirs.large.samples, rtol=1e-7, atol=1e-12)
    assert_allclose(ours.apart, theirs.apart, rtol=1e-5)
    known = {name: few for name, _, few, _ in digits.certain_digits(theirs)}
    for name, error, few, pose in digits.certain_digits(ours):
        assert pose in ("20°", "50°", "80°")
        assert error > 0.0
        assert abs(few - known.get(name, 13)) <= 2


def test_they_are_in_the_report_and_the_table(result: RunResult) -> None:
    text = "\n\n".join(sections(result))
    assert [text.index(part) for part in ("### Digits", "### Large displacement", "### Choices")]
    rows = list(csv.DictReader(as_csv(result).splitlines()))
    outcome = result.outcome
    for name, values in {"": outcome.kappa, "_plane": outcome.planar_kappa, "_scaled": outcome.kappa_scaled}.items():
        assert_allclose([float(row[f"kappa{name}"]) for row in rows], values)
    assert_allclose([float(row["P_large_mu_y"]) for row in rows], (outcome.rigid + outcome.large.mean)[:, 1])
    assert_allclose([float(row["P_large_sigma_x"]) for row in rows], outcome.large.std[:, 0])


def test_the_samples_are_written_with_what_was_asked_for(result: RunResult) -> None:
    """By the closed form of the four-bar, with the samples of the inputs that the same file has."""
    job = LinkageJob(result.inputs)
    job.result = result
    saved = job.samples()
    drawn = {name.removeprefix("input_"): values for name, values in saved.items() if name.startswith("input_")}
    assert drawn.keys() == result.inputs.tolerances.keys()
    of_joints = {kind: {joint: drawn[f"{kind}.{joint}"] for joint in "BDE"} for kind in ("clearance", "contact")}
    springs = {joint: drawn[f"stiffness.{joint}"][:, None] * [1.0, 1.0, 1.0, 1.0, 1.0, 0.0] for joint in "BDE"}
    theta = np.radians(saved["drive"])[:, None]
    found = accuracy(FourBar(stiffness=springs), theta, load=(0.0, drawn["fy"], 0.0), **of_joints)
    assert_allclose(saved["rigid"][0], found.rigid[:, 0], rtol=1e-12, atol=1e-15)
    assert_allclose(np.swapaxes(saved["displacement"][:, 0], 0, 1), found.total, rtol=1e-9, atol=1e-15)
    assert_allclose(np.swapaxes(saved["displacement_large"], 0, 1), found.large, rtol=1e-7, atol=1e-12)
    assert_allclose(saved["kappa_scaled"], result.outcome.kappa_scaled)
    assert_allclose(saved["kappa_plane"], result.outcome.planar_kappa)


def test_every_table_marks_the_poses_that_need_it(tmp_path: Path) -> None:
    """No pose is regular in one table and listed in another as one where linear mechanics does not hold.

    The contacts lie across the rocker at the first pose, so that the nominal clearances hardly turn the coupler there,
    and all others do.
    """
    text = asked(tmp_path, '["large"]').source.text
    text = text.replace("start = 20.0\nstop = 80.0\nsteps = 3", "values = [10.0, 90.0]")
    for key in ("contact", "loc"):
        text = text.replace(f"{key} = {np.pi}", f"{key} = {np.radians(100.0)}")
    text = text.replace("clearance = 1e-3", "clearance = 3e-4")
    text = text.replace('"norm"\nloc = 1e-3\nscale = 5e-5', '"uniform"\nloc = 0.0\nscale = 2e-3')
    file = tmp_path / "across.toml"
    file.write_text(text, encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    saved = job.samples()
    linear, true = saved["displacement"][:, 0, :, :2], saved["displacement_large"][..., :2]
    off = np.abs(linear.mean(axis=0) - true.mean(axis=0)) + np.abs(linear.std(axis=0) - true.std(axis=0))
    assert ((off / true.std(axis=0)).max(axis=1) > 0.1).tolist() == [True, False]
    statuses = [row["status"] for row in csv.DictReader(as_csv(job.result).splitlines())]
    assert saved["status"].tolist() == statuses
    assert re.fullmatch(r"outside the linear range: estimated error \d+ % of the spread", statuses[0])
    assert statuses[1] == "regular"
    assert job.summary().count(statuses[0]) == 2
    assert f"At A = 10°: {statuses[0]}." in job.report().summary
    assert "beside the samples at large displacement" in job.summary()


def test_samples_that_passed_a_singular_pose_are_counted_and_written(tmp_path: Path) -> None:
    """At 350 degrees those of which the coupler turned beyond the line from B to E."""
    text = asked(tmp_path, '["large"]').source.text
    text = text.replace("start = 20.0\nstop = 80.0\nsteps = 3", "values = [350.0, 90.0]")
    file = tmp_path / "near.toml"
    file.write_text(text.replace(f"samples = {SAMPLES}", "samples = 60"), encoding="utf-8")
    job = LinkageJob(read_inputs(file))
    job.compute(lambda *_: None)
    saved = job.samples()
    moved, pin = saved["displacement_large"][:, 0], 0.1 * np.exp(1j * np.radians(350.0))
    beyond = np.angle(0.1 + moved[:, 0] + 1j * moved[:, 1]) > np.angle(0.2 - pin)
    assert np.count_nonzero(beyond) == 1
    assert saved["large_passes"][:, 0].tolist() == beyond.tolist()
    assert not saved["large_passes"][:, 1].any()
    assert columns(job.result)["P_large_passes"].tolist() == [1, 0]


def test_what_failed_at_large_displacement_is_told_at_once(result: RunResult, monkeypatch: pytest.MonkeyPatch) -> None:
    """In the terminal as well, and once in the report."""
    monkeypatch.setattr(outcome, "MOST", 5)
    found = compute(result.inputs)
    first = "that of the first 5 of the 12 samples"
    assert sum(first in each for each in remarks(found)) == 1
    assert not any(first in each for each in sections(found))


def test_a_choice_is_a_run_of_the_file_with_its_numbers(result: RunResult, tmp_path: Path) -> None:
    file = tmp_path / "flat.toml"
    text = result.inputs.source.file.read_text(encoding="utf-8").partition("[choices")[0]
    file.write_text(text.replace("y = 0.0127\nz = 0.00635", "y = 0.00635\nz = 0.0127"), encoding="utf-8")
    flat = compute(replace(read_inputs(file), also=())).outcome
    line = next(line for line in "\n".join(sections(result)).splitlines() if line.startswith("| flat |"))
    length, deviation = 1e6 * np.linalg.norm(flat.compliance[1]), 1e3 * flat.std[1]
    assert f"| {length:.2f} |" in line
    assert f"| {deviation[0]:.3f} ±" in line
    assert f"| {deviation[1]:.3f} ±" in line
    assert f"| {flat.kappa[1]:.3e} | {flat.kappa_scaled[1]:.3e} |" in line


def test_without_tolerances_there_is_one_sample(tmp_path: Path) -> None:
    inputs = replace(asked(tmp_path), tolerances={})
    told: list[tuple[str, int]] = []
    found = compute(inputs, lambda *each: told.append(each))
    assert sum(more for _, more in told) == 3 == sum(work(inputs).values())
    exact = found.motion.frame().solve(large=True).displacement("P")[:, :2]
    assert_allclose(found.outcome.large.mean[:, :2], exact, rtol=1e-9)
    large = [f"P_large_mu_{axis}" for axis in "xyz"] + ["P_large_passes"]
    assert [name for name in columns(found) if "large" in name] == large
    assert "| A | x linear | y linear | x large | y large | status |" in "\n".join(sections(found))
    assert {"u_x", "u_y", "κ", "κ scaled"} == {name for name, *_ in digits.certain_digits(found.outcome)}


@pytest.mark.parametrize(
    ("also", "more", "told"),
    [
        ('["speed"]', "", r"there is no further table 'speed': choose of condition, digits, large"),
        (CONDITION, "[choices.flat]\n", r"choices.flat: give a table of numbers"),
        (CONDITION, '[choices.flat]\n"sections.round.y" = 1.0\n', r"choices.flat.*sections.round.y"),
        (CONDITION, '[choices.flat]\n"sections.flat.y" = "thin"\n', r"choices.flat.*'thin': give a number"),
    ],
)
def test_what_there_is_not_is_refused(also: str, more: str, told: str, tmp_path: Path) -> None:
    with pytest.raises(FrameError, match=told):
        asked(tmp_path, also, more)


def test_a_choice_that_cannot_be_is_refused_before_anything_is_computed(tmp_path: Path) -> None:
    inputs = asked(tmp_path, CONDITION, '[choices.flat]\n"sections.flat.y" = -1.0\n')
    with pytest.raises(FrameError, match=r"choices.flat"):
        compute(inputs)


def test_the_nodes_of_a_joint_that_is_ideal_in_all_directions_are_one() -> None:
    """A bar that is welded on has the condition number of one that is joined to the node itself."""
    bar = Beam(Rectangle(y=0.02, z=0.01), Material(E=2e11, nu=0.3))

    def condition(stiffness: float | None) -> float:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.0, 0.0))
        frame.node("D", (1.5, 0.0, 0.0))
        frame.add("AB", bar, "A", "B")
        if stiffness is None:
            frame.add("BD", bar, "B", "D")
            frame.fix("D")
        else:
            frame.node("C", (1.0, 0.0, 0.0))
            frame.node("E", (1.5, 0.0, 0.0))
            frame.add("CD", bar, "C", "D")
            frame.add("BC", Joint(stiffness=(stiffness,) * 6), "B", "C")
            frame.add("DE", Joint(stiffness=(np.inf,) * 6), "D", "E")
            frame.fix("E")
        frame.fix("A")
        frame.load("B", fy=1.0)
        return float(frame.solve().condition_number())

    assert_allclose(condition(np.inf), condition(None), rtol=1e-9)
    assert condition(1e13) > 10.0 * condition(None)
