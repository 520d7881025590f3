"""Measured positions beside the prediction of ``linkframe run``: residuals, chi squared, poses outside, bad tables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage, write_linkage
from linkframe.models.command_line import main
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.linkage.job.result import compute
from linkframe.models.linkage.job.run import LinkageJob
from numpy.testing import assert_allclose

ANGLES = np.array([15.0, 35.0, 80.0])
DEVIATION, UNCERTAINTY, CLEARANCE = 1e-4, 2e-4, 3e-4
# Measured less predicted, of which the last pose alone lies outside its band.
OFF = np.array([[1e-4, -1e-4], [2e-4, 3e-4], [9e-4, -8e-4]])
RUN = """
[run.drives.A]
start = 0.0
stop = 90.0
steps = 2
unit = "deg"
"""
TOLERANCE = f"""
[run]
samples = 512
sampler = "sobol"

[tolerances.length]
of = ["points.P.x"]
distribution = "norm"
loc = 0.2
scale = {DEVIATION}
"""
MEASURED = """
[measured]
file = "measured.csv"
"""


def written(folder: Path, more: str, table: str | None = None) -> Path:
    """A crank of 0.2 m on a pin with clearance along x, and the table of where its end was measured."""
    crank = Linkage(A=(0, 0), P=(0.2, 0))
    crank.link("crank", "A", "P")
    crank.revolute("A", "ground", "crank", drive=True, clearance=CLEARANCE, contact=0.0)
    write_linkage(crank, folder / "crank.toml")
    text = (folder / "crank.toml").read_text() + RUN + more
    (folder / "crank.toml").write_text(text)
    x, y = 0.2 * np.array([np.cos(np.radians(ANGLES)), np.sin(np.radians(ANGLES))])
    rows = [
        f"{a},{float(x + CLEARANCE + dx)!r},{float(y + dy)!r}"
        for a, x, y, (dx, dy) in zip(ANGLES, x, y, OFF, strict=True)
    ]
    own = "A [deg],x,y,ux,uy\n" + "".join(f"{row},{UNCERTAINTY},{UNCERTAINTY}\n" for row in rows)
    (folder / "measured.csv").write_text(own if table is None else table)
    return folder / "crank.toml"


def expected() -> np.ndarray:
    """Standard deviation of the residuals: the length spreads along the crank."""
    way = np.abs([np.cos(np.radians(ANGLES)), np.sin(np.radians(ANGLES))]).T
    return np.hypot(UNCERTAINTY, DEVIATION * way)


def test_residuals_and_band(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """At the poses of the measurement, which are not those of the run."""
    file, out = written(tmp_path, TOLERANCE + MEASURED), tmp_path / "out"
    assert main(["run", str(file), "--out", str(out), "--figures", "none"]) == 0
    rows = list(csv.DictReader((out / "measured.csv").read_text().splitlines()))
    assert [float(row["A_deg"]) for row in rows] == ANGLES.tolist()
    assert_allclose([[float(row[f"residual_{k}"]) for k in "xy"] for row in rows], OFF, atol=1e-6)
    assert_allclose([[float(row[f"uncertainty_{k}"]) for k in "xy"] for row in rows], expected(), rtol=1e-2)
    assert [row["band"] for row in rows] == ["", "", "outside"]
    assert [row["residual_z"] for row in rows] == [""] * 3
    report, shown = (out / "report.md").read_text(), capsys.readouterr().out
    ways = np.array([np.cos(np.radians(ANGLES)), np.sin(np.radians(ANGLES))]).T
    covariance = DEVIATION**2 * ways[:, :, None] * ways[:, None] + UNCERTAINTY**2 * np.eye(2)
    chi_squared = np.einsum("pi,pij,pj->", OFF, np.linalg.inv(covariance), OFF)
    for text in (report, shown):
        told = text.partition("Measured P against the prediction: chi squared ")[2]
        assert_allclose(float(told.split()[0]), chi_squared, rtol=0.02)
        assert "of 6 components" in text
        assert "1 of 3 poses outside the 95 % band: A = 80°." in text
    assert "## Measured" in report
    # A run without what was measured leaves no such table behind.
    assert "measured.csv" in LinkageJob.optional


def test_without_tolerances_the_measurement_has_the_uncertainty(tmp_path: Path) -> None:
    found = compute(read_inputs(written(tmp_path, "")).measured_by(tmp_path / "measured.csv")).measured
    assert found is not None
    assert_allclose(found.comparison.residual[:, :2], OFF, atol=1e-15)
    assert_allclose(found.comparison.chi_squared, np.sum((OFF / UNCERTAINTY) ** 2), rtol=1e-9)


@pytest.mark.parametrize(
    ("unit", "column", "factor"),
    [("deg", "A [deg]", 1.0), ("deg", "A [rad]", np.pi / 180.0), ("rad", "A", np.pi / 180.0)],
)
def test_the_drive_of_a_table_in_each_unit(unit: str, column: str, factor: float, tmp_path: Path) -> None:
    file = written(tmp_path, MEASURED)
    file.write_text(file.read_text().replace('unit = "deg"', f'unit = "{unit}"'))
    text = (tmp_path / "measured.csv").read_text().replace("A [deg]", column)
    for angle in ANGLES:
        text = text.replace(f"\n{angle},", f"\n{float(angle * factor)!r},")
    (tmp_path / "measured.csv").write_text(text)
    found = compute(read_inputs(file)).measured
    assert found is not None
    assert_allclose(found.comparison.residual[:, :2], OFF, atol=1e-15)


def test_a_column_without_a_unit_where_the_run_has_degrees(tmp_path: Path) -> None:
    """Taken as radians, 15° would be 139° away, and the residuals nonsense without a word."""
    file = written(tmp_path, MEASURED, "A,x,y,ux,uy\n15.0,0.2,0.0,1e-4,1e-4\n")
    told = r"measured\.csv has a column 'A' without a unit, .* in degrees: name the column 'A \[deg\]' or 'A \[rad\]'"
    with pytest.raises(FrameError, match=told):
        compute(read_inputs(file))


@pytest.mark.parametrize(
    ("column", "told"),
    [
        ("S [deg]", r"measured\.csv has a column 'S \[deg\]', and that drive is a length: name the column 'S'"),
        ("S [mm]", r"a column 'S \[mm\]', which is no drive: the drives are S, .* none behind that of a length"),
    ],
)
def test_a_unit_behind_a_drive_that_is_a_length(column: str, told: str, tmp_path: Path) -> None:
    """In degrees, a stroke of 15 mm would be one of 0.26 mm."""
    slide = Linkage(A=(0, 0), P=(0.2, 0))
    slide.link("slider", "A", "P")
    slide.prismatic("A", "ground", "slider", axis=(1, 0, 0), drive=True, name="S")
    write_linkage(slide, tmp_path / "slide.toml")
    run = "[run.drives.S]\nvalues = [0.0, 0.01]\n" + MEASURED
    (tmp_path / "slide.toml").write_text((tmp_path / "slide.toml").read_text() + run)
    (tmp_path / "measured.csv").write_text("S,x,ux\n0.015,0.2151,1e-4\n")
    found = compute(read_inputs(tmp_path / "slide.toml")).measured
    assert found is not None
    assert_allclose(found.comparison.residual[0, 0], 1e-4, atol=1e-15)
    (tmp_path / "measured.csv").write_text(f"{column},x,ux\n0.015,0.2151,1e-4\n")
    with pytest.raises(FrameError, match=told):
        compute(read_inputs(tmp_path / "slide.toml"))


def test_poses_of_the_run_where_the_table_has_no_drives(tmp_path: Path) -> None:
    table = "x,y,ux,uy\n0.2003,0,1e-4,1e-4\n0.0003,0.2001,1e-4,1e-4\n"
    found = compute(read_inputs(written(tmp_path, MEASURED, table))).measured
    assert found is not None
    assert_allclose(found.comparison.normalised[:, :2], [[0, 0], [0, 1]], atol=1e-9)
    assert "every pose lies within" in found.in_words()


@pytest.mark.parametrize(
    ("more", "table", "message"),
    [
        (
            MEASURED.replace("measured.csv", "none.csv"),
            None,
            r"line \d+, measured\.file: .*none\.csv cannot be read: No such file",
        ),
        (MEASURED + 'point = "Q"\n', None, r"measured\.point: is 'Q'"),
        (MEASURED + "level = 2.0\n", None, r"measured\.level: is 2\.0: give a probability"),
        (MEASURED + "band = 2.0\n", None, r"measured\.band: there is no such key"),
        (MEASURED, "B,x,ux\n0,0.2,1e-4\n", r"measured: measured\.csv has a column 'B', which is no drive: .* A"),
        (MEASURED, "x,ux\n0.2,1e-4\n", r"1 measured poses and no columns .* give it a column 'A \[deg\]'"),
        (MEASURED, "A [deg],x\n0,0.2\n", r"measured: neither measurement nor prediction has an uncertainty"),
    ],
)
def test_bad_tables_are_told_by_line(tmp_path: Path, more: str, table: str | None, message: str) -> None:
    with pytest.raises(FrameError, match=message):
        compute(read_inputs(written(tmp_path, more, table)))
