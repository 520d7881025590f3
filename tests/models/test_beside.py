"""Work that a copy of the process does beside it, and a job that has such work."""

from __future__ import annotations

import errno
import os
import select
import signal
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models.command_line import main
from linkframe.models.job import beside
from linkframe.models.job.beside import Beside, copies
from linkframe.models.paper import against_paper
from linkframe.models.paper.compared_choices import compare_choices
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import begin, finish

JOB = ["four-bar", "--poses", "30", "30", "1", "--samples", "2", "--figures", "none", "--out"]


@pytest.fixture(params=[True, False], ids=["copied", "alone"])
def copied(request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> bool:
    """Whether there is a copy; where a process has threads, as under xdist, there are only those of the test."""
    if request.param:
        monkeypatch.setattr(beside.threading, "active_count", lambda: 1)
        monkeypatch.setattr(beside, "processors", lambda: 2)
        if not copies():
            pytest.skip("this system does not copy processes")
    else:
        monkeypatch.setattr(beside, "processors", lambda: 1)
    return bool(request.param)


def test_the_work_is_done_by_a_copy_or_when_it_is_asked_for(copied: bool, tmp_path: Path) -> None:
    values = np.linspace(0.0, 1.0, 100_000)

    def work() -> tuple[int, np.ndarray]:
        (tmp_path / "file").write_text("written")
        return os.getpid(), np.sin(values)

    with Beside(work) as other:
        assert (other.copy is not None) == copied
        process, found = other.outcome()
    assert (process != os.getpid()) == copied
    np.testing.assert_array_equal(found, np.sin(values))
    assert (tmp_path / "file").read_text() == "written"
    assert Beside(work, worth=False).copy is None


@pytest.mark.usefixtures("copied")
@pytest.mark.parametrize("way", [lambda: os._exit(0), lambda: os.kill(os.getpid(), 9), lambda: 1 // 0, lambda: print])
def test_what_the_copy_cannot_do_this_process_does(way: Callable[[], object]) -> None:
    """A copy may die, fail, or have something to tell that cannot be told."""
    here = os.getpid()

    def work() -> object:
        return "here" if os.getpid() == here else [way(), bytes(2**20), threading.Lock()]

    with Beside(work) as other:
        assert other.outcome() == "here"


@pytest.mark.usefixtures("copied")
def test_errors_are_those_of_the_work() -> None:
    def work() -> None:
        raise FrameError("the disk is full")

    with Beside(work) as other, pytest.raises(FrameError, match="the disk is full"):
        other.outcome()


@pytest.mark.usefixtures("copied")
def test_a_copy_ends_where_nobody_asks() -> None:
    with Beside(lambda: time.sleep(60.0)) as other:
        process = other.copy
    if process is not None:
        with pytest.raises(ChildProcessError):
            os.waitpid(process[0], os.WNOHANG)
        with pytest.raises(OSError, match="descriptor"):
            os.fstat(process[1])


@pytest.mark.usefixtures("copied")
def test_a_copy_ends_with_its_process() -> None:
    """Also where that is killed: it would hold the pipes of a shell open, and write where nobody looks."""
    here, start = os.getpid(), time.monotonic()

    def killed() -> None:
        if os.getpid() != here:
            Beside(lambda: time.sleep(20.0))
            os.kill(os.getpid(), signal.SIGKILL)

    with Beside(killed) as other:
        other.outcome()  # is there when the last process that could write to the pipe has ended
    assert time.monotonic() - start < 10.0


@pytest.mark.usefixtures("copied")
@pytest.mark.skipif(not hasattr(signal, "SIGCHLD"), reason="this system does not copy processes")
def test_nothing_is_lost_where_ended_processes_are_ignored() -> None:
    here, before = os.getpid(), signal.signal(signal.SIGCHLD, signal.SIG_IGN)
    try:
        with Beside(os.getpid) as other:
            assert other.outcome() == here
        with Beside(lambda: os._exit(0) if os.getpid() != here else None) as other:
            if other.copy is not None:
                select.select([other.copy[1]], [], [], 10.0)
    finally:
        signal.signal(signal.SIGCHLD, before)


@pytest.mark.usefixtures("copied")
@pytest.mark.parametrize("name", ["SIGINT", "SIGTERM"])
def test_a_signal_ends_a_copy_at_once(name: str, tmp_path: Path) -> None:
    """What a process does when it is asked to end is not done by its copies."""
    here, number = os.getpid(), getattr(signal, name)

    def work() -> str:
        if os.getpid() != here:
            os.kill(os.getpid(), number)
        return "here"

    before = signal.signal(number, lambda *_: (tmp_path / "file").touch())
    try:
        with Beside(work) as other:
            assert other.outcome() == "here"
    finally:
        signal.signal(number, before)
    assert not (tmp_path / "file").exists()


@pytest.mark.usefixtures("copied")
@pytest.mark.parametrize("what", ["pipe", "fork"])
def test_without_room_for_a_copy_this_process_does_the_work(what: str, monkeypatch: pytest.MonkeyPatch) -> None:
    def refused() -> None:
        raise OSError(errno.EAGAIN, "no room")

    monkeypatch.setattr(os, what, refused, raising=False)
    with Beside(os.getpid) as other:
        assert other.copy is None
        assert other.outcome() == os.getpid()


def test_the_job_writes_the_same_files(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With a copy and without, but for its times."""
    found = []
    for count in (1, 2):
        monkeypatch.setattr(beside.threading, "active_count", lambda: 1)
        monkeypatch.setattr(beside, "processors", lambda count=count: count)
        out = tmp_path / str(count)
        assert main([*JOB, str(out)]) == 0
        files = {str(path.relative_to(out)): path.read_bytes() for path in out.rglob("*") if path.is_file()}
        files["report.md"] = files["report.md"].partition(b"| stage |")[0]
        found.append(files)
    assert found[0] == found[1]


def test_choices_are_compared_at_the_pose_that_is_shown(monkeypatch: pytest.MonkeyPatch) -> None:
    """What was compared beside the samples is shown if these leave the pose that was expected, and only then."""
    inputs = Inputs(poses=(20.0, 60.0, 20.0), samples=10)
    result = finish(begin(inputs), large=False)
    assert result.expected_pose == result.pose
    known, asked = compare_choices(inputs, float(result.degrees[result.pose])), []
    monkeypatch.setattr(against_paper, "compare_choices", lambda _, angle: asked.append(angle) or known)
    text = against_paper.points(result, known)
    assert not asked
    assert against_paper.points(result, replace(known, angle=0.0)) == text
    assert asked == [known.angle]


@pytest.mark.usefixtures("copied")
@pytest.mark.parametrize("copied", [True], indirect=True)
def test_a_signal_while_a_copy_is_made_ends_it(monkeypatch: pytest.MonkeyPatch) -> None:
    """It is heard when the copy is there, of which nobody would know any more."""
    made, plain = [], beside._copied

    def copied_and_asked_to_end() -> int:
        process = plain()
        if process:
            made.append(process)
            os.kill(os.getpid(), signal.SIGINT)
        return process

    monkeypatch.setattr(beside, "_copied", copied_and_asked_to_end)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt):
            Beside(lambda: time.sleep(20.0))
        with pytest.raises(ChildProcessError):
            os.waitpid(made[0], os.WNOHANG)
    finally:
        signal.signal(signal.SIGINT, before)
