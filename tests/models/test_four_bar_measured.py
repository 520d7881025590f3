"""Measured positions beside the prediction of ``linkframe four-bar``, made by a linkage of known lengths."""

from __future__ import annotations

import csv
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, write_linkage
from linkframe.models.command_line import main
from linkframe.models.job.sharing import Sharing
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.result import compute as compute_file
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.job import FourBarJob
from linkframe.models.paper.page import write_job_page
from linkframe.models.paper.result import Result, compute
from linkframe.models.paper.study import work
from numpy.testing import assert_allclose, assert_array_equal

ANGLES = np.array([25.0, 60.0, 95.0, 140.0, 320.0])
# The linkage that was measured has another crank than the drawing; and how well it was measured.
BUILT, UNCERTAINTY = 0.10016, 5e-5
# Rigid links on ideal joints: only the lengths matter.
RIGID: dict[str, Any] = {
    "ground": 0.25, "coupler": 0.22, "rocker": 0.16, "point": (0.1, 0.03), "branch": "open", "load": 0.0,
    "load_sd": 0.0, "clearance": 0.0, "clearance_sd": 0.0, "stiffness_sd": 0.0, "poses": (60.0, 95.0, 35.0),
    "samples": 256, "sampler": "sobol",
}  # fmt: skip


def coupler_point(angles: np.ndarray, crank: float = 0.1, **changed: float) -> np.ndarray:
    """Where P is, by two circles that meet, (poses, 2)."""
    coupler, rocker, ground = (changed.get(name, RIGID[name]) for name in ("coupler", "rocker", "ground"))
    b = crank * np.exp(1j * np.radians(angles))
    to_e = ground - b
    along = (coupler**2 - rocker**2 + np.abs(to_e) ** 2) / (2.0 * np.abs(to_e))
    way = to_e / np.abs(to_e) * (along + 1j * np.sqrt(coupler**2 - along**2))
    p = b + complex(*RIGID["point"]) * way / np.abs(way)
    return np.stack([p.real, p.imag], axis=-1)


def noise() -> np.ndarray:
    return np.random.default_rng(5).normal(0.0, UNCERTAINTY, (len(ANGLES), 2))


def table(folder: Path, angles: np.ndarray = ANGLES) -> Path:
    """What was measured of the linkage as it was built."""
    rows = np.column_stack([angles, coupler_point(angles, BUILT) + noise()])
    text = "".join(f"{a!r},{x!r},{y!r},{UNCERTAINTY},{UNCERTAINTY}\n" for a, x, y in rows.tolist())
    path = folder / "seen.csv"
    path.write_text(f"A [deg],x,y,ux,uy\n{text}", encoding="utf-8")
    return path


def found(path: Path, **changed: Any) -> Result:
    return compute(Inputs(**RIGID | changed, measured=path))


def test_the_lengths_that_were_measured_have_the_chi_squared_of_the_noise(tmp_path: Path) -> None:
    result = found(table(tmp_path), crank=BUILT).measured
    assert result is not None
    assert_allclose(result.comparison.residual[:, :2], noise(), atol=1e-15)
    assert_allclose(result.comparison.chi_squared, np.sum((noise() / UNCERTAINTY) ** 2), rtol=1e-9)
    assert "every pose lies within the 95 % band" in result.in_words()


def test_the_files_of_the_job(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Other lengths leave the band of their tolerance, at poses that are not those of the run."""
    deviation, out = 2e-5, tmp_path / "out"
    words = ["--measured", str(table(tmp_path)), "--length-sd", str(deviation), "--figures", "none", "--out", str(out)]
    for name, value in RIGID.items():
        values = value if isinstance(value, tuple) else (value,)
        words += [f"--{name.replace('_', '-')}", *map(str, values)]
    assert main(["four-bar", *words]) == 0
    off = coupler_point(ANGLES, BUILT) + noise() - coupler_point(ANGLES)
    lengths = {"crank": 0.1} | {name: RIGID[name] for name in ("coupler", "rocker", "ground")}
    slopes = [
        (coupler_point(ANGLES, **lengths | {name: value + 1e-6}) - coupler_point(ANGLES, **lengths)) / 1e-6
        for name, value in lengths.items()
    ]
    band = np.hypot(UNCERTAINTY, deviation * np.linalg.norm(slopes, axis=0))
    with (out / "measured.csv").open(encoding="utf-8") as lines:
        rows = list(csv.DictReader(lines))
    assert_allclose([float(row["A_deg"]) for row in rows], ANGLES)
    for name, wanted, close in (
        ("residual", off, {"atol": 1e-7}),
        ("uncertainty", band, {"rtol": 0.02}),
        ("normalised", off / band, {"rtol": 0.03, "atol": 1e-2}),
    ):
        assert_allclose([[float(row[f"{name}_{k}"]) for k in "xy"] for row in rows], wanted, **close)
        assert [row[f"{name}_z"] for row in rows] == [""] * len(ANGLES)
    covariance = deviation**2 * np.einsum("kpi,kpj->pij", slopes, slopes) + UNCERTAINTY**2 * np.eye(2)
    squares = np.einsum("pi,pij,pj->p", off, np.linalg.inv(covariance), off)
    beyond = squares > 5.991  # the 95 % point of chi squared with two degrees of freedom
    assert 0 < beyond.sum() < len(ANGLES)
    assert [row["band"] == "outside" for row in rows] == beyond.tolist()
    report = (out / "report.md").read_text(encoding="utf-8")
    for text in (report, capsys.readouterr().out):
        told = text.partition("Measured P against the prediction: chi squared ")[2]
        assert_allclose(float(told.split()[0]), squares.sum(), rtol=0.03)
        assert f"of {2 * len(ANGLES)} components" in told
        assert f"{beyond.sum()} of {len(ANGLES)} poses outside the 95 % band" in told
    assert "## Measured" in report
    assert "| measured | " in report
    # A run without what was measured leaves neither of the two behind.
    assert {"measured.csv", "measured.png"} <= set(FourBarJob.optional)


def test_the_figure_and_the_page(tmp_path: Path) -> None:
    result = found(table(tmp_path), samples=8, length_sd=1e-5)
    assert result.measured is not None
    (axes,) = result.measured.draw().axes
    assert axes.get_xlabel() == "A [°]"
    assert axes.get_title(loc="left").startswith("χ² = ")
    (marked,) = (line for line in axes.lines if line.get_label() == "outside")
    assert_allclose(marked.get_xdata(), ANGLES[result.measured.comparison.outside])
    job = FourBarJob(result.inputs)
    job.result = result
    assert "measured.png" in job.captions()
    write_job_page(result, tmp_path / "index.html")
    page = (tmp_path / "index.html").read_text(encoding="utf-8")
    assert result.measured.in_words() in page


def test_the_same_from_the_same_four_bar_in_a_file(tmp_path: Path) -> None:
    """Both jobs say the same of the same measurement, to the last character but rounding."""
    path = table(tmp_path)
    own = found(path).measured
    a, e, d = np.zeros(2), np.array([RIGID["ground"], 0.0]), None
    b = 0.1 * np.array([np.cos(np.radians(60.0)), np.sin(np.radians(60.0))])
    p = coupler_point(np.array([60.0]))[0]
    way = complex(*(p - b)) / complex(*RIGID["point"])
    d = b + RIGID["coupler"] * np.array([way.real, way.imag]) / abs(way)
    linkage = Linkage(A=tuple(a), B=tuple(b), P=tuple(p), D=tuple(d), E=tuple(e))
    linkage.link("crank", "A", "B")
    linkage.link("coupler", "B", "P", "D")
    linkage.link("rocker", "D", "E")
    linkage.revolute("A", "ground", "crank", drive=True, reference=np.radians(60.0))
    linkage.revolute("B", "crank", "coupler")
    linkage.revolute("D", "coupler", "rocker")
    linkage.revolute("E", "rocker", "ground")
    file = tmp_path / "four_bar.toml"
    write_linkage(linkage, file)
    run = '\n[run]\npoints = ["P"]\n[run.drives.A]\nvalues = [60.0, 95.0]\nunit = "deg"\n'
    file.write_text(file.read_text(encoding="utf-8") + run, encoding="utf-8")
    other = compute_file(read_inputs(file).measured_by(path)).measured
    assert own is not None
    assert other is not None
    assert own.in_words() == other.in_words()
    assert own.as_csv().splitlines()[0] == other.as_csv().splitlines()[0]
    assert own.as_text() == other.as_text()


def test_poses_of_the_run_where_the_table_has_no_drive(tmp_path: Path) -> None:
    x, y = coupler_point(np.array([60.0, 95.0])).T + np.array([[0.0, 0.0], [0.0, UNCERTAINTY]])
    rows = [f"{float(a)!r},{float(b)!r},{UNCERTAINTY},{UNCERTAINTY}" for a, b in zip(x, y, strict=True)]
    (tmp_path / "seen.csv").write_text("\n".join(["x,y,ux,uy", *rows]), encoding="utf-8")
    result = found(tmp_path / "seen.csv", samples=4).measured
    assert result is not None
    assert_allclose(result.comparison.normalised[:, :2], [[0, 0], [0, 1]], atol=1e-9)
    assert_allclose(result.drives["A"].values, [60.0, 95.0])


def test_poses_that_cannot_be_assembled_are_left_out(tmp_path: Path) -> None:
    result = found(table(tmp_path), samples=4, ground=0.38, coupler=0.22, rocker=0.16)
    assert result.measured is not None
    assert np.isnan(result.measured.predicted[ANGLES == 140.0]).all()
    assert 0 < result.measured.comparison.count < 2 * len(ANGLES)
    assert work(result.inputs)["at measured poses"] == 4 * result.measured.comparison.count / 2


def test_samples_at_measured_poses_are_stored_and_tell_another_run(tmp_path: Path) -> None:
    inputs = Inputs(**RIGID | {"samples": 8, "length_sd": 1e-5}, measured=table(tmp_path))
    shared = Sharing(1, tmp_path / "kept", inputs.about)
    wanted = compute(inputs, shared=shared).measured
    assert {path.stem.rpartition("-")[2] for path in (tmp_path / "kept").glob("chunk-*")} == {
        "linear", "large", "measured",
    }  # fmt: skip
    again = compute(inputs, shared=shared).measured
    assert wanted is not None
    assert again is not None
    assert_array_equal(again.predicted, wanted.predicted)
    table(tmp_path, ANGLES + 1.0)
    other = replace(inputs)
    with pytest.raises(FrameError, match="belongs to another run: --measured differs"):
        compute(other, shared=Sharing(1, tmp_path / "kept", other.about))


@pytest.mark.parametrize(
    ("rows", "message"),
    [
        (None, r"none\.csv cannot be read: No such file"),
        ("B [deg],x,ux\n60,0.1,1e-4\n", r"seen\.csv has a column 'B', which is no drive: the drives are A"),
        ("theta,x,ux\n60,0.1,1e-4\n", r"seen\.csv has a column 'theta', which is no drive: the drives are A"),
        (
            "A,x,ux\n60,0.1,1e-4\n",
            r"seen\.csv has a column 'A' without a unit, .* name the column 'A \[deg\]' or 'A \[rad\]'",
        ),
        ("x,ux\n0.1,1e-4\n", r"1 measured poses and no columns .* give it a column 'A \[deg\]'"),
        ("A [deg],p\n60,0.1\n", r"row 1: no column is a position, of A \[deg\], p: name those x, y, z"),
        ("A [deg],x,ux\n60,0.1,1e-4\n,0.1,1e-4\n", r"row 3: A \[deg\] has no value: give that of the drive"),
        ("A [deg],x,ux\n60,0.1,wide\n", r"row 2: ux is 'wide', which is no number"),
    ],
)
def test_wrong_tables_are_refused_where_they_are_given(rows: str | None, message: str, tmp_path: Path) -> None:
    path = tmp_path / ("none.csv" if rows is None else "seen.csv")
    if rows is not None:
        path.write_text(rows, encoding="utf-8")
    with pytest.raises(FrameError, match=message):
        Inputs(**RIGID, measured=path)


def test_what_cannot_be_compared_is_told_with_its_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "seen.csv"
    path.write_text("A [deg],x\n60,0.1\n", encoding="utf-8")
    with pytest.raises(FrameError, match=r"seen\.csv: neither measurement nor prediction has an uncertainty"):
        found(path, samples=4)
    path.write_text("A [deg],x,ux\n180,0.1,1e-4\n", encoding="utf-8")
    with pytest.raises(FrameError, match=r"seen\.csv: the linkage cannot be assembled at any measured pose"):
        found(path, samples=4, ground=0.38)
    assert main(["four-bar", "--measured", str(tmp_path / "none.csv"), "--out", str(tmp_path / "out")]) == 2
    assert "none.csv cannot be read: No such file" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
