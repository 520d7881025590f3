"""The times that a job tells are all that it took, from its beginning on; what it does not show it does not compute."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from linkframe.models.command_line import main
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.job import FourBarJob
from linkframe.models.paper.result import begin

FEW = ["four-bar", "--poses", "30", "60", "30", "--samples", "5", "--figures", "none"]


def test_what_is_told_before_samples_and_the_report_count(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def slowly(_: FourBarJob) -> list[str]:
        time.sleep(0.1)
        return []

    monkeypatch.setattr(FourBarJob, "beforehand", slowly)
    start = time.perf_counter()
    assert main([*FEW, "--out", str(tmp_path)]) == 0
    taken = time.perf_counter() - start
    rows = [line.strip("| ").split(" | ") for line in (tmp_path / "report.md").read_text(encoding="utf-8").splitlines()]
    told = {row[0].strip("*"): float(row[1].strip("*")) for row in rows[[row[0] for row in rows].index("stage") + 2 :]}
    whole = told.pop("all")
    assert next(iter(told)) == "start"
    assert list(told)[-1] == "report"
    assert told["start"] >= 0.1
    assert abs(sum(told.values()) - whole) < 0.05
    assert whole < taken + 0.05
    assert f"{whole:.2f} s: start {told['start']:.2f}, " in capsys.readouterr().out


def test_the_mean_inputs_go_to_large_displacement_where_it_is_shown() -> None:
    found = begin(Inputs(poses=(0.0, 90.0, 30.0))).large_mean_inputs
    np.testing.assert_array_equal(np.isfinite(found).all(axis=-1), [True, False, False, False])
    assert np.isnan(begin(Inputs(poses=(30.0, 90.0, 30.0))).large_mean_inputs).all()


@pytest.mark.skipif(os.name != "posix", reason="a shell that becomes the program it starts")
def test_what_a_shell_did_before_it_became_the_program_does_not_count(tmp_path: Path) -> None:
    """As in ``python -m venv .venv && pip install . && linkframe four-bar``, of which the last takes the place."""
    program = [sys.executable, "-m", "linkframe", *FEW, "--out", str(tmp_path)]
    start = time.perf_counter()
    found = subprocess.run(
        ["sh", "-c", 'sleep 0.3; exec "$@"', "sh", *program], check=True, capture_output=True, text=True
    )
    taken = time.perf_counter() - start
    told = re.search(r"([\d.]+) s: start ([\d.]+), ", found.stdout)
    assert told is not None
    assert float(told[1]) < taken - 0.25
    assert float(told[2]) > 0.05
