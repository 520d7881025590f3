"""A crank that cannot turn fully: the job tells of the poses that can be assembled, and marks the others."""

from __future__ import annotations

import csv
from pathlib import Path

import meshio
import numpy as np
import pytest
from linkframe.models.command_line import main
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import compute
from numpy.testing import assert_allclose, assert_array_equal

# The crank reaches 75.5 degrees: there coupler and rocker are in line, 0.35 long.
LENGTHS = {"crank": 0.25, "coupler": 0.2, "rocker": 0.15, "ground": 0.3}
ROCKING = Inputs(samples=5, poses=(260.0, 440.0, 30.0), **LENGTHS)


def reach(degrees: np.ndarray) -> np.ndarray:
    """Distance from the crank pin to the rocker's pivot, by the law of cosines."""
    a, d = LENGTHS["crank"], LENGTHS["ground"]
    return np.sqrt(a * a + d * d - 2.0 * a * d * np.cos(np.radians(degrees)))


def test_poses_out_of_reach_are_marked_and_the_others_are_as_without_them() -> None:
    result = compute(ROCKING)
    lost = reach(ROCKING.degrees) > 0.35
    assert_array_equal(lost, [True, False, False, False, False, False, True])
    assert_array_equal(~result.assembled, lost)
    for pose in np.flatnonzero(lost):
        gap = reach(ROCKING.degrees)[pose] - 0.35
        assert result.status[pose] == result.marked_status[pose] == f"not assembled: gap {gap:.3g}"
    alone = compute(ROCKING.but(poses=(290.0, 410.0, 30.0)))
    for name in ("rigid", "samples", "mean", "std", "kappa", "compliance", "error_bound", "forces", "planar_kappa"):
        everywhere = getattr(result, name)
        assert np.isnan(everywhere[lost]).all(), name
        assert_allclose(everywhere[~lost], getattr(alone, name), rtol=1e-9, atol=1e-15, err_msg=name)
    assert_allclose(result.large.samples[~lost], alone.large.samples, rtol=1e-6, atol=1e-12)
    assert result.degrees[result.pose] == 290.0
    assert result.entry == alone.pose == 0
    turned = result.path[np.isfinite(result.path).all(axis=1)]
    assert 0 < len(turned) < len(result.path), "the path has gaps where it cannot go"


def test_the_command_writes_all_that_there_is(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    sizes = [word for name, length in LENGTHS.items() for word in (f"--{name}", str(length))]
    options = ["--samples", "3", "--poses", "60", "120", "30", "--figures", "2d", "--out", str(tmp_path)]
    assert main(["four-bar", *sizes, *options]) == 0
    printed = capsys.readouterr().out
    assert "not assembled: gap 0.0405" in printed
    with (tmp_path / "table1.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [bool(row["mu_x_m"]) for row in rows] == [True, False, False]
    assert rows[1]["x_m"] == rows[1]["large_mu_x_m"] == rows[1]["kappa"] == ""
    assert len(list((tmp_path / "trajectory").glob("beams*.vtu"))) == 1
    assert meshio.read(tmp_path / "trajectory" / "beams_000.vtu").points.shape[1] == 3
    report = (tmp_path / "report.md").read_text(encoding="utf-8")
    assert "At 90°, 120°: not assembled" in report
    assert "nan" not in report
    assert np.load(tmp_path / "samples.npz")["displacement"].shape == (3, 3, 3)


def test_lengths_that_never_close_are_refused_in_the_command_s_words(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["four-bar", "--ground", "0.5", "--out", "never"]) == 2
    told = capsys.readouterr().err
    assert "--ground 0.5" in told
    assert "at 0°" in told
    assert "assembles(" not in told
    assert not Path("never").exists()
