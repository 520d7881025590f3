"""Jobs of many samples: some at a time, with the time that is left; refused where they do not fit; ended by signals."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models.command_line import main
from linkframe.models.four_bar import job, parts
from linkframe.models.four_bar.inputs import Inputs
from linkframe.models.four_bar.result import compute, work
from linkframe.models.job import memory
from linkframe.models.job.stages import Stages

COMMAND = [sys.executable, "-c", "from linkframe.models.command_line import main; raise SystemExit(main())", "four-bar"]
FEW = ["--poses", "30", "60", "30", "--samples", "5"]


def test_samples_in_parts_are_those_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Same draws, same results to rounding; each pose and sample is counted once a pass."""
    inputs = Inputs(poses=(30.0, 60.0, 30.0), samples=23)
    whole = compute(inputs)
    monkeypatch.setattr(parts, "ENTRIES", 14)
    told: list[int] = []
    some = compute(inputs, told.append)
    assert sum(told) == work(inputs)
    assert len(told) > 4
    for name in ("mean", "std", "error_bound", "sampled_kappa"):
        np.testing.assert_allclose(
            getattr(some, name), getattr(whole, name), rtol=1e-6 if name != "error_bound" else 0.5
        )
    np.testing.assert_allclose(some.large.samples, whole.large.samples, rtol=1e-9)


@pytest.mark.parametrize("soon", [False, True])
def test_parts_cover_all_samples_and_none_is_single(soon: bool) -> None:
    for poses in (1, 37, 5000):
        for samples in (2, 3, 100, 4097, 100_000):
            found = parts.cuts(poses, samples, soon=soon)
            assert [cut.start for cut in found] == [0, *(cut.stop for cut in found[:-1])]
            assert found[-1].stop == samples
            sizes = [cut.stop - cut.start for cut in found]
            assert min(sizes) >= 2
            assert max(sizes) <= max(parts.ENTRIES // poses, 2) + 1


def test_what_does_not_fit_is_refused_before_it_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: 10**9)
    start = time.perf_counter()
    with pytest.raises(FrameError, match=r"--samples 10000000 takes \d{12} bytes of memory, and 1000000000 are free"):
        compute(Inputs(samples=10_000_000))
    assert time.perf_counter() - start < 0.5


def test_memory_is_told_by_the_system() -> None:
    found = memory.available()
    assert found is None or found > 10**6


def test_lines_where_there_is_no_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    """How much is done, and from the first part on an estimate; nothing of what takes no time."""
    stages = Stages(1)
    with stages.progress("samples", 10) as advance:
        advance(10)
    assert capsys.readouterr().err == ""
    with stages.progress("samples", 10) as advance:
        time.sleep(1.3)
        advance(5)
        time.sleep(1.0)
    first, second = capsys.readouterr().err.splitlines()
    assert first == "0 of 10 samples after 1 s, no estimate yet"
    assert re.fullmatch("5 of 10 samples after 2 s, about 2 s to go", second)


def test_only_what_was_written_is_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(job, "rendered", lambda *_: [])
    (tmp_path / "my notes.txt").write_text("mine", encoding="utf-8")
    assert main(["four-bar", *FEW, "--out", str(tmp_path)]) == 0
    line = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("Written to"))
    assert "my notes" not in line
    names = line.split(": ")[1].split(", ")
    assert {"report.md", "table1.csv", "trajectory/", "trajectory.pvd"} <= set(names)
    assert all((tmp_path / name).exists() for name in names)


def test_an_empty_folder_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    for words in (["four-bar"], ["run", "file.toml"]):
        with pytest.raises(SystemExit):
            main([*words, "--out", ""])
        assert "--out: is empty" in capsys.readouterr().err


def test_jobs_have_folders_of_their_own(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By default each file's results go apart."""
    from linkframe.models.linkage.job import inputs, run

    found = []
    monkeypatch.setattr(inputs, "read_inputs", lambda file: file)
    monkeypatch.setattr(run, "run", lambda _, out: found.append(out))
    main(["run", "some/lift.toml"])
    main(["run", "some/lift.toml", "--out", "here"])
    assert found == [Path("results-lift"), Path("here")]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_leaves_nothing(number: signal.Signals, code: int, tmp_path: Path) -> None:
    """Neither files nor the folder in which they were to be made."""
    out = tmp_path / "out"
    with subprocess.Popen([*COMMAND, "--samples", "100000", "--out", str(out)], stderr=subprocess.PIPE) as running:
        for _ in range(600):
            if out.exists():
                break
            time.sleep(0.1)
        running.send_signal(number)
        _, told = running.communicate(timeout=60)
    assert running.returncode == code
    assert b"Traceback" not in told
    assert b"interrupted" in told
    assert not out.exists()


@pytest.mark.skipif(os.name == "nt", reason="pipes of POSIX")
def test_a_closed_pipe_ends_quietly() -> None:
    read, write = os.pipe()
    os.close(read)
    printing = "from linkframe.models.four_bar import job; job.run = lambda *_: print('x' * 100000); "
    command = [sys.executable, "-c", printing + COMMAND[2], "four-bar"]
    ended = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (ended.returncode, ended.stderr) == (141, b"")
