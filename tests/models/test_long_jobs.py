"""Jobs of many samples: some at a time, with the time that is left; refused where they do not fit; ended by signals."""

from __future__ import annotations

import gc
import os
import signal
import subprocess
import sys
import threading
import time
import tracemalloc
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.framework.clock import tell, watched
from linkframe.models.command_line import main
from linkframe.models.four_bar import study
from linkframe.models.four_bar.four_bar import FourBar
from linkframe.models.job import choices, memory, outcome, output, parts, stages
from linkframe.models.job.stages import Progress, Stages
from linkframe.models.linkage.job import result as linkage
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.paper import against_paper, compared_choices
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.remarks import remarks
from linkframe.models.paper.result import BYTES, Result, compute
from linkframe.models.paper.study import work
from numpy.typing import NDArray
from stress.killed_jobs import HEARING

MAIN = "from linkframe.models.command_line import main; raise SystemExit(main())"
COMMAND = [sys.executable, "-c", MAIN, "four-bar"]
FILE = Path(__file__).parents[2] / "examples" / "four_bar.toml"
FEW = ["--poses", "30", "60", "30", "--samples", "5"]


def test_samples_in_parts_are_those_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Same draws, same results to rounding; each pose and sample is counted once a pass."""
    inputs = Inputs(poses=(30.0, 60.0, 30.0), samples=23)
    whole = compute(inputs)
    monkeypatch.setattr(parts, "ENTRIES", 14)
    told: list[tuple[str, int]] = []
    some = compute(inputs, lambda *each: told.append(each))
    for way, total in work(inputs).items():
        assert sum(more for name, more in told if name == way) == total
        assert len([more for name, more in told if name == way and more]) > 2
    for name in ("mean", "std", "error_bound"):
        np.testing.assert_allclose(
            getattr(some, name), getattr(whole, name), rtol=1e-6 if name != "error_bound" else 0.5
        )
    np.testing.assert_allclose(some.large.samples, whole.large.samples, rtol=1e-9)
    np.testing.assert_allclose(some.sampled_kappa, whole.sampled_kappa, rtol=1e-6)


def test_large_displacement_of_the_first_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where there are very many: they are those of a run of fewer, and linear spreads are set beside them alike."""
    inputs = Inputs(poses=(30.0, 60.0, 30.0), samples=23)
    few = compute(inputs.but(samples=7))
    monkeypatch.setattr(outcome, "MOST", 7)
    many = compute(inputs)
    assert many.samples.shape == (2, 23, 3)
    np.testing.assert_allclose(many.large.samples, few.large.samples, rtol=1e-9)
    np.testing.assert_allclose(many.apart, few.apart, rtol=1e-6)
    assert work(inputs) == {outcome.LINEAR_WAY: 2 * 23, outcome.LARGE_WAY: 2 * 7}
    assert "first 7 of the 23 samples" in "".join(remarks(many))
    assert "Large displacement is that" not in "".join(remarks(few))


def test_memory_a_sample_is_bounded() -> None:
    """What is left of each sample, and what there is at once: neither the matrices that it was solved with."""
    inputs = Inputs(poses=(30.0, 30.0, 1.0), joints="shared")
    compute(inputs.but(samples=9000), large=False)  # what is imported and compiled once is not counted
    tracemalloc.start()
    try:
        result = compute(inputs.but(samples=9000), large=False)
        held, most = tracemalloc.get_traced_memory()
        gc.collect()
        held = tracemalloc.get_traced_memory()[0]
    finally:
        tracemalloc.stop()
    assert result.samples.shape == (1, 9000, 3)
    assert held < 9000 * BYTES
    assert most < 160e6


def test_the_report_compares_few_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the choices that the paper leaves open; and none of them at large displacement."""
    inputs = Inputs(poses=(30.0, 30.0, 1.0), samples=40)
    result = compute(inputs)
    asked: list[tuple[int, bool]] = []

    def counted(inputs: Inputs, *, large: bool) -> Result:
        asked.append((inputs.samples, large))
        return compute(inputs, large=large)

    monkeypatch.setattr(compared_choices, "compute", counted)
    monkeypatch.setattr(choices, "COMPARED", 10)
    text = "".join(against_paper.points(result))
    assert asked == [(10, False)] * 6
    assert "with the same seed, of the first 10 samples" in text


def test_the_first_estimate_does_not_wait_for_every_sample(monkeypatch: pytest.MonkeyPatch) -> None:
    """What certain lengths can reach is asked once, not for each sample, before the first of them are solved."""
    asked: list[int] = []
    of_one = study.toleranced

    def toleranced(four_bar: FourBar, samples: Mapping[str, NDArray[np.float64]]) -> FourBar:
        asked.append(len(samples))
        return of_one(four_bar, samples)

    class Begun(Exception):
        """The first samples are solved."""

    def advance(_: str, more: int) -> None:
        if more:
            raise Begun

    monkeypatch.setattr(study, "toleranced", toleranced)
    with pytest.raises(Begun):
        compute(Inputs(samples=50_000, poses=(30.0, 60.0, 30.0)), advance)
    # Whether it can be assembled; that all samples are in range; the first part.
    assert [bool(each) for each in asked] == [False, True, True]


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
    tracemalloc.start()
    try:
        with pytest.raises(
            FrameError, match=r"--samples 10000000 takes \d{12} bytes of memory, and 1000000000 are free"
        ):
            compute(Inputs(samples=10_000_000))
        most = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert most < 10_000_000  # not a byte for each sample


def test_memory_is_told_by_the_system() -> None:
    found = memory.available()
    assert found is None or found > 10**6


class Clock:
    """Time that goes on where a test says so; a thread that waits for a moment of it is there at that moment."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 0.0
        self.due: float | None = None  # when the thread that waits goes on
        self.changed = threading.Condition()
        monkeypatch.setattr(stages, "perf_counter", lambda: self.now)
        monkeypatch.setattr(stages, "Event", lambda: Ended(self))

    def sleep(self, seconds: float) -> None:
        end = self.now + seconds
        with self.changed:
            while True:
                assert self.changed.wait_for(lambda: self.due is not None, timeout=60.0)
                assert self.due is not None
                if self.due > end:
                    break
                self.now, self.due = self.due, None
                self.changed.notify_all()
            self.now = end


class Ended:
    """An event by such a clock."""

    def __init__(self, clock: Clock) -> None:
        self.clock, self.happened = clock, False

    def set(self) -> None:
        with self.clock.changed:
            self.happened = True
            self.clock.changed.notify_all()

    def wait(self, pause: float) -> bool:
        clock = self.clock
        with clock.changed:
            clock.due = clock.now + pause
            clock.changed.notify_all()
            clock.changed.wait_for(lambda: self.happened or clock.due is None)
            clock.due = None
            return self.happened


def test_lines_where_there_is_no_terminal(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """How much is done, with an estimate, for which the first line waits; nothing of what is soon or nearly done."""
    clock, shown = Clock(monkeypatch), Stages(3)
    with shown("solution", {"samples": 10}) as advance:
        advance("samples", 10)
    with shown("solution", {"samples": 1000}) as advance:
        advance("samples", 0)
        advance("samples", 999)
        clock.sleep(1.2)
    assert capsys.readouterr().err == ""
    with shown("solution", {"samples": 10}) as advance:
        advance("samples", 0)
        clock.sleep(1.3)
        advance("samples", 5)
        clock.sleep(0.5)
    assert capsys.readouterr().err == "solution: 5 of 10 samples after 1 s, about 1 s to go\n"
    with shown("solution", {"samples": 10}):
        clock.sleep(2.9)
        assert capsys.readouterr().err == ""
        clock.sleep(0.3)
    assert capsys.readouterr().err == "solution: 0 of 10 samples after 3 s, no estimate yet\n"


def test_lines_become_rare(capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """Each comes after half of what was spent till then, and after half a minute at most."""
    clock = Clock(monkeypatch)
    with Stages(1)("figures"):
        clock.sleep(150.0)
    spent = [1.0]
    while spent[-1] + min(max(1.0, spent[-1] / 2.0), 30.0) <= 150.0:
        spent.append(spent[-1] + min(max(1.0, spent[-1] / 2.0), 30.0))
    assert capsys.readouterr().err.splitlines() == [f"figures: {each:.0f} s so far" for each in spent]


def test_a_long_stage_without_parts_tells_its_name(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """By the clock of the machine."""
    monkeypatch.setattr(stages, "FIRST", 0.05)
    with Stages(1)("figures"):
        time.sleep(0.25)
    assert set(capsys.readouterr().err.splitlines()) == {"figures: 0 s so far"}


def test_the_estimate_does_not_wait_for_a_whole_part() -> None:
    """A long solution tells how many of its entries are solved."""
    beginning = Progress({"slow": 40})
    beginning.count("slow", 0)
    assert beginning.left is None
    with watched(beginning.inside):
        tell(4)
        time.sleep(0.02)
        tell(2)
    assert 0.18 <= (beginning.left or 0.0) < 5.0  # 36 at 5 ms each
    tell(40)
    assert (beginning.left or 0.0) >= 0.18


def test_the_estimate_is_of_each_thing_by_itself(monkeypatch: pytest.MonkeyPatch) -> None:
    """By what its parts took but the first, which sets up what the others share."""
    clock = iter([0.0, 1.0, 4.0, 4.0, 5.0, 5.0, 7.0])
    monkeypatch.setattr(stages, "perf_counter", lambda: next(clock))
    progress = Progress({"fast": 100, "slow": 40, "none": 0})
    progress.count("fast", 0)  # at 1
    progress.count("fast", 10)  # 3 s for 10
    assert progress.left is None
    progress.count("slow", 0)
    progress.count("slow", 2)  # 1 s for 2
    assert progress.left == pytest.approx(0.3 * 90 + 0.5 * 38)
    progress.count("fast", 0)
    progress.count("fast", 40)  # 2 s for 40
    assert progress.left == pytest.approx(0.05 * 50 + 0.5 * 38)
    assert str(progress) == "50 of 100 fast, 2 of 40 slow"


def test_the_linkage_in_a_file_has_parts_and_progress(monkeypatch: pytest.MonkeyPatch) -> None:
    """As many samples at a time as memory should hold, counted; the draws and the results stay the same."""
    inputs = replace(read_inputs(FILE), samples=9)
    whole = linkage.compute(inputs).displacement
    monkeypatch.setattr(parts, "ENTRIES", 3 * 37)
    told: list[int] = []
    some = linkage.compute(inputs, lambda _, more: told.append(more)).displacement
    assert whole is not None
    assert some is not None
    np.testing.assert_allclose(some, whole, rtol=1e-9, atol=1e-15)
    assert {"samples at a pose": sum(told)} == linkage.work(inputs) == {"samples at a pose": 37 * 9}
    assert len([more for more in told if more]) > 2


def test_the_linkage_in_a_file_must_fit_the_memory(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(memory, "available", lambda: 10**8)
    with pytest.raises(FrameError, match=r"samples 1000000 takes \d{11} bytes of memory, and 100000000 are free"):
        linkage.compute(replace(read_inputs(FILE), samples=1_000_000))


@pytest.mark.parametrize(("job", "other"), [("four-bar", "run"), ("run", "four-bar")])
def test_results_of_two_jobs_do_not_mix(job: str, other: str, tmp_path: Path) -> None:
    """A job refuses the folder of another, and changes nothing there; one that holds a part of them is the user's."""
    mine, theirs = output.SIGNS[job], output.SIGNS[other]
    with output.results(tmp_path, other, ()) as stage:
        for name in theirs:
            (stage / name).write_text("theirs", encoding="utf-8")
    with (
        pytest.raises(FrameError, match=f"holds the results of linkframe {other} .*{theirs[0]}.*give another folder"),
        output.results(tmp_path, job, ("*",)) as stage,
    ):
        (stage / mine[0]).write_text("mine", encoding="utf-8")
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted(theirs)
    (tmp_path / theirs[0]).unlink()
    with output.results(tmp_path, job, ()) as stage:
        (stage / mine[0]).write_text("mine", encoding="utf-8")
    assert {path.name for path in tmp_path.iterdir()} == {mine[0], theirs[1]}


def test_only_what_was_written_is_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "my notes.txt").write_text("mine", encoding="utf-8")
    assert main(["four-bar", *FEW, "--figures", "none", "--out", str(tmp_path)]) == 0
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
    from linkframe.models.job import run
    from linkframe.models.linkage.job import inputs

    found = []
    monkeypatch.setattr(inputs, "read_inputs", lambda file: file)
    monkeypatch.setattr(run, "run", lambda _, out, *rest: found.append(out))
    main(["run", "some/lift.toml"])
    main(["run", "some/lift.toml", "--out", "here"])
    assert found == [Path("results-lift"), Path("here")]


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
@pytest.mark.parametrize(("number", "code"), [(signal.SIGTERM, 143), (signal.SIGINT, 130)])
def test_a_signal_leaves_nothing(number: signal.Signals, code: int, tmp_path: Path) -> None:
    """Neither files nor the folder in which they were to be made."""
    out = tmp_path / "out"
    command = [sys.executable, "-c", HEARING + MAIN, "four-bar", "--samples", "100000", "--out", str(out)]
    with subprocess.Popen(command, stderr=subprocess.PIPE) as running:
        for _ in range(3000):
            if out.exists():
                break
            time.sleep(0.02)
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
    printing = "from linkframe.models.job import run; run.run = lambda *_: print('x' * 100000); "
    command = [sys.executable, "-c", printing + MAIN, "four-bar"]
    ended = subprocess.run(command, stdout=write, stderr=subprocess.PIPE, check=False)
    os.close(write)
    assert (ended.returncode, ended.stderr) == (141, b"")
