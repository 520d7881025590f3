"""What a process that was killed left behind is removed, and nothing of a process that may live."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
from pathlib import Path
from time import sleep

import pytest
from linkframe.framework.owner import is_gone, owner
from linkframe.framework.paraview import files
from linkframe.framework.paraview.files import STAGE, whole_or_nothing

WRITING = """
import sys, time
from pathlib import Path
from linkframe.framework.paraview.files import whole_or_nothing
with whole_or_nothing(Path(sys.argv[1])) as stage:
    (stage / "half.txt").write_text("half")
    print("there", flush=True)
    time.sleep(60)
"""


def stages(folder: Path) -> set[str]:
    return {path.name for path in folder.glob(f"{STAGE}*")}


@pytest.mark.skipif(os.name != "posix", reason="processes of POSIX")
def test_a_killed_run_leaves_a_folder_that_the_next_one_removes(tmp_path: Path) -> None:
    with subprocess.Popen([sys.executable, "-c", WRITING, str(tmp_path)], stdout=subprocess.PIPE, text=True) as other:
        assert other.stdout is not None
        assert other.stdout.readline() == "there\n"
        (left,) = stages(tmp_path)
        assert not is_gone(left.removeprefix(STAGE).rpartition("-")[0])
        with whole_or_nothing(tmp_path) as stage:
            (stage / "whole.txt").write_text("whole")
        assert stages(tmp_path) == {left}  # of a run that goes on
        other.send_signal(signal.SIGKILL)
        # Ended, though nobody has asked for it: its number is still there.
        os.waitid(os.P_PID, other.pid, os.WEXITED | os.WNOWAIT)
        assert is_gone(left.removeprefix(STAGE).rpartition("-")[0])
    with whole_or_nothing(tmp_path):
        pass
    assert sorted(path.name for path in tmp_path.iterdir()) == ["whole.txt"]


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="what Linux tells of processes")
def test_who_is_gone() -> None:
    machine, process, start = owner().split("-")
    assert not is_gone(owner())
    assert is_gone(f"{machine}-{process}-{int(start) + 1}")  # its number was given to this one
    assert is_gone(f"{machine}-{2**22 + 1}-5")  # more than Linux gives
    assert not is_gone(f"{machine}-{process}-0")  # of a system that does not tell when it began
    assert not is_gone(f"{'0' * 12}-{2**22 + 1}-5")  # on another machine
    for text in ("", "abcd1234", f"{machine}-{process}", f"{machine}-x-{start}"):
        assert not is_gone(text)


def test_folders_of_others_stay(tmp_path: Path) -> None:
    """Those of other machines, of earlier releases, and one of this process itself, such as of another thread."""
    for name in (f"{STAGE}abcd1234", f"{STAGE}{'0' * 12}-7-7-abc", f"{STAGE}{owner()}-abc"):
        (tmp_path / name).mkdir()
    before = stages(tmp_path)
    with whole_or_nothing(tmp_path):
        pass
    assert stages(tmp_path) == before


@pytest.mark.parametrize("others", [0, 3])
@pytest.mark.skipif(os.name != "posix", reason="a signal sent to oneself ends the process")
def test_an_interrupt_while_the_folder_is_made_leaves_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, others: int
) -> None:
    """It is heard when all that was made is known, also where other threads would take it."""
    done = threading.Event()
    threads = [threading.Thread(target=done.wait) for _ in range(others)]
    for thread in threads:
        thread.start()

    class Interrupted(files.TemporaryDirectory[str]):
        def __init__(self, **words: str) -> None:
            super().__init__(**words)
            os.kill(os.getpid(), signal.SIGINT)
            sleep(0.01)

    monkeypatch.setattr(files, "TemporaryDirectory", Interrupted)
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    try:
        with pytest.raises(KeyboardInterrupt), whole_or_nothing(tmp_path / "new" / "out"):
            raise AssertionError
    finally:
        signal.signal(signal.SIGINT, before)
        done.set()
        for thread in threads:
            thread.join()
    assert not (tmp_path / "new").exists()
