"""Jobs on several processes, and jobs that are ended and go on: the same files to the last byte."""

from __future__ import annotations

import gc
import os
import resource
import signal
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models.command_line import main, parser
from linkframe.models.job import parts
from linkframe.models.job.parts import Parts
from linkframe.models.job.sharing import SampleKind, SamplePiece, Sharing, sharing
from linkframe.models.job.stages import Progress
from linkframe.models.linkage.job import result as linkage
from linkframe.models.linkage.job.inputs import read_inputs
from linkframe.models.paper import against_paper
from linkframe.models.paper import result as paper
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.job import FourBarJob
from numpy.testing import assert_array_equal
from stress.killed_jobs import COMMAND

TESTS = Path(__file__).parents[1]
FILE = TESTS.parent / "examples" / "four_bar.toml"
FOUR_BAR = ["four-bar", "--poses", "30", "60", "30", "--samples", "10"]


def files(folder: Path) -> dict[str, bytes]:
    """Content of all files by name; what took how long is left out of the report."""
    found = {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}
    found["report.md"] = found["report.md"].partition(b"## Times")[0].partition(b"| stage |")[0]
    return found


def written(tmp_path: Path, name: str, *words: str, code: int = 0) -> dict[str, bytes]:
    out = tmp_path / name
    assert main([*words, "--figures", "none", "--out", str(out)]) == code
    return files(out) if code == 0 else {}


@pytest.fixture
def file(tmp_path: Path) -> str:
    """The linkage of the example with three poses, samples at large displacement, and measured positions."""
    text = FILE.read_text(encoding="utf-8").replace("steps = 37", "steps = 4").replace("start = 0.0", "start = 20.0")
    assert "samples = 100" in text
    text = text.replace("samples = 100", 'samples = 8\nalso = ["large", "digits"]')
    (tmp_path / "seen.csv").write_text("A [deg],x,y\n30.0,0.1866,0.05\n50.0,0.1643,0.0766\n", encoding="utf-8")
    path = tmp_path / "linkage.toml"
    path.write_text(text + '\n[measured]\nfile = "seen.csv"\n', encoding="utf-8")
    return str(path)


@pytest.fixture
def small(monkeypatch: pytest.MonkeyPatch) -> None:
    """Many parts of few samples."""
    monkeypatch.setattr(parts, "ENTRIES", 8)


@pytest.mark.usefixtures("small")
@pytest.mark.parametrize("job", ["four-bar", "run"])
def test_the_same_files_from_two_processes_and_a_checkpoint(
    job: str, tmp_path: Path, file: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    # What the report says of the paper, and of other choices, has samples of its own, which are not shared.
    monkeypatch.setattr(against_paper, "points", lambda *_: [])
    monkeypatch.setattr(FourBarJob, "compared", lambda _: None)
    words = FOUR_BAR if job == "four-bar" else ["run", file]
    wanted = written(tmp_path, "one", *words)
    kept = ["--checkpoint", str(tmp_path / "kept")]
    others = ["--workers", "2"] if job == "run" else []
    assert written(tmp_path, "two", *words, *others, *kept) == wanted
    stored = sorted((tmp_path / "kept").glob("chunk-*"))
    kinds = {path.stem.rpartition("-")[2] for path in stored}
    assert kinds == {"linear", "large"} | ({"measured"} if job == "run" else set())
    for path in stored[1::2]:
        path.unlink()
    again = {path: path.stat().st_mtime_ns for path in stored[::2]}
    assert written(tmp_path, "three", *words, *kept, "--resume") == wanted
    assert {path: path.stat().st_mtime_ns for path in stored[::2]} == again
    assert sorted((tmp_path / "kept").glob("chunk-*")) == stored


@pytest.mark.usefixtures("small")
def test_pieces_in_any_order_give_the_same_bits(monkeypatch: pytest.MonkeyPatch) -> None:
    """As if two hundred processes raced: those of all kinds are done from the last to the first."""
    from linkframe.models.propagation import workers

    inputs = replace(read_inputs(FILE), samples=8, nan_policy="raise")
    drives = {name: replace(drive, values=drive.values[1:4]) for name, drive in inputs.drives.items()}
    inputs = replace(inputs, drives=drives)
    wanted = linkage.compute(inputs)
    monkeypatch.setattr(workers, "computed", lambda task, cuts, *_: ((cut, task(cut)) for cut in reversed(cuts)))
    found = linkage.compute(inputs)
    assert_array_equal(found.displacement, wanted.displacement)
    assert_array_equal(found.spread["P"].std, wanted.spread["P"].std)


class Pieces:
    """Results of samples, their numbers, of which an earlier release stored the first alone."""

    def __init__(self, cut: slice) -> None:
        self.place = np.arange(cut.start, cut.stop)[None]
        self.passed = np.zeros(self.place.shape, dtype=bool)


@pytest.mark.usefixtures("small")
def test_parts_without_a_later_result_are_refused(tmp_path: Path) -> None:
    def run(*names: str) -> Parts:
        found = Parts(Pieces, (1, 24))
        Sharing(folder=tmp_path / "kept").compute({"large": SampleKind("of them", found, names)}, lambda *_: None)
        return found

    run("place")
    stored = sorted((tmp_path / "kept").glob("chunk-*"))
    assert len(stored) > 1
    stored[-1].unlink()
    with pytest.raises(FrameError, match=r"kept is of another release, without passed: give another folder"):
        run("place", "passed")
    assert_array_equal(run("place")["place"], [np.arange(24)])


class Texts:
    """Counts of texts that differ from part to part."""

    def __init__(self, cut: slice) -> None:
        self.cut = cut

    def why(self) -> dict[str, int]:
        return {f"reason {k % 3}": 1 for k in range(self.cut.start, self.cut.stop)} if self.cut.start else {}

    @property
    def most(self) -> Any:
        return np.arange(self.cut.start, self.cut.stop, dtype=float)[None]


@pytest.mark.usefixtures("small")
def test_counts_and_greatest_are_put_together() -> None:
    found = Parts(Texts, (4, 60), greatest=("most",), counted=("why",))
    assert len(found.cuts) > 4
    counts: dict[str, int] = {}
    for cut in found.cuts:
        for text, more in Texts(cut).why().items():
            counts[text] = counts.get(text, 0) + more
    assert found.count("why") == counts
    assert found["most"].tolist() == [[59.0]] * 4


def test_what_is_there_is_spared_while_parts_are_made_and_no_longer() -> None:
    """The collector then looks among what they made; what somebody else spares stays as it is."""
    gc.unfreeze()
    try:
        with parts.sparing_what_is_there(False):
            assert gc.get_freeze_count() == 0
        with parts.sparing_what_is_there(True):
            assert gc.get_freeze_count() > 10_000
        assert gc.get_freeze_count() == 0
    finally:
        gc.freeze()
    with parts.sparing_what_is_there(True):
        pass
    assert gc.get_freeze_count() > 10_000


def options(*words: str) -> Any:
    return parser().parse_args(["four-bar", *words])


def test_another_run_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str], file: str) -> None:
    kept = ["--checkpoint", str(tmp_path / "kept")]
    few = ["--figures", "none", "--out", str(tmp_path / "out"), *kept]
    assert main(["four-bar", "--poses", "30", "30", "1", "--samples", "5", *few]) == 0
    before = {path: path.read_bytes() for path in (tmp_path / "kept").iterdir()}
    capsys.readouterr()
    assert main(["four-bar", "--poses", "30", "30", "1", "--samples", "5", "--load", "90", "--rng", "1", *few]) == 2
    told = capsys.readouterr().err
    assert "belongs to another run: --load, --rng differ; give another folder, or what that run was begun with" in told
    assert main(["run", file, *few]) == 2
    assert "belongs to another run: the job, " in capsys.readouterr().err
    assert {path: path.read_bytes() for path in (tmp_path / "kept").iterdir()} == before
    # More random samples go on; figures may be others.
    sharing(options(*kept, "--samples", "9"), Inputs(poses=(30.0, 30.0, 1.0), samples=9, magnify=3.0)).compute(
        {}, print
    )
    with pytest.raises(FrameError, match="--samples"):
        sharing(options(*kept), Inputs(poses=(30.0, 30.0, 1.0), samples=9, sampler="lhs"))


def test_a_changed_file_is_refused(tmp_path: Path, file: str) -> None:
    run = parser().parse_args(["run", file, "--checkpoint", str(tmp_path / "kept")])
    sharing(run, read_inputs(Path(file))).compute({}, print)
    text = Path(file).read_text(encoding="utf-8")
    for old, new, told in (
        ("scale = 5.0", "scale = 6.0", r"\[tolerances\] differs"),
        ("P = [", "Q = [0.0, 0.0]\nP = [", r"\[points\] differs"),
        ("stop = 360.0", "stop = 350.0", r"\[run.drives\] differs"),
        ("rng = 0", "rng = 1", "rng differs"),
    ):
        assert old in text
        Path(file).write_text(text.replace(old, new), encoding="utf-8")
        with pytest.raises(FrameError, match=f"belongs to another run: {told}"):
            sharing(run, read_inputs(Path(file)))
    Path(file).write_text(text.replace("pose = 30.0", "pose = 40.0"), encoding="utf-8")
    sharing(run, read_inputs(Path(file)))


def test_nothing_to_resume(tmp_path: Path) -> None:
    with pytest.raises(FrameError, match="--resume has no folder to go on in: give it with --checkpoint DIR"):
        sharing(options("--resume"), Inputs())
    with pytest.raises(FrameError, match=r"--resume finds no run in .*none: leave it out to begin one there"):
        sharing(options("--resume", "--checkpoint", str(tmp_path / "none")), Inputs())
    assert not (tmp_path / "none").exists()


def test_what_has_no_samples_has_no_workers(tmp_path: Path) -> None:
    inputs = replace(read_inputs(FILE), tolerances={})
    for words in (["--workers", "2"], ["--checkpoint", str(tmp_path)]):
        with pytest.raises(FrameError, match=f"{words[0]} has no effect, as the file has no tolerances"):
            sharing(options(*words), inputs)
    assert sharing(options(), inputs).workers == 1


@pytest.mark.parametrize("workers", ["0", "-2", "two", "1.5"])
def test_what_are_no_workers(workers: str, capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        options("--workers", workers)
    assert f"is {workers!r}: give a whole number of processes, or -1" in capsys.readouterr().err


@pytest.mark.usefixtures("small")
def test_a_damaged_part_is_told_and_done_again(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    inputs, shared = Inputs(poses=(30.0, 60.0, 30.0), samples=16), Sharing(1, tmp_path / "kept", {})
    wanted = paper.compute(inputs, large=False, shared=shared).samples
    part = sorted((tmp_path / "kept").glob("chunk-*"))[2]
    content = part.read_bytes()
    part.write_bytes(content[:-9] + bytes([content[-9] ^ 1]) + content[-8:])
    assert_array_equal(paper.compute(inputs, large=False, shared=shared).samples, wanted)
    assert f"{part.name} is damaged" in capsys.readouterr().err
    assert part.read_bytes() == content


def test_a_folder_that_cannot_be_written(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "file").write_text("")
    written(tmp_path, "out", *FOUR_BAR, "--checkpoint", str(tmp_path / "file" / "kept"), code=2)
    assert "cannot be read: Not a directory" in capsys.readouterr().err
    written(tmp_path, "out", *FOUR_BAR, "--checkpoint", "/proc/kept", code=2)
    assert "checkpoint /proc/kept cannot be " in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


class Filling:
    """Samples of which the fourth part no longer fits on the disk."""

    def __init__(self, cut: slice) -> None:
        self.size = 1 if cut.start < 24 else 10_000

    @property
    def moved(self) -> Any:
        return np.zeros((1, 8, 1 if self.size == 1 else self.size))


@pytest.mark.skipif(os.name == "nt", reason="limits of POSIX")
def test_a_full_disk_leaves_the_parts_before_it_good(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(parts, "ENTRIES", 8)

    def kinds(make: Any) -> dict[str, SampleKind]:
        held = Parts(make, (1, 40), greatest=("moved",))
        return {"linear": SampleKind("samples", held, ("moved",))}

    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
    shared = Sharing(1, tmp_path / "kept", {})
    try:
        resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
        with pytest.raises(FrameError, match=r"cannot be written: File too large; .* make room") as error:
            shared.compute(kinds(Filling), lambda *_: None)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    stored = sorted((tmp_path / "kept").glob("chunk-*"))
    assert f"{len(stored)} of " in error.value.__notes__[0]
    assert "the same command goes on from there" in error.value.__notes__[0]
    assert stored
    assert not list((tmp_path / "kept").glob(".*"))


def test_the_time_left_is_not_told_by_what_an_earlier_run_did() -> None:
    progress = Progress({"slow": 100})
    progress.count("slow", 60)
    assert progress.left is None
    progress.count("slow", 0)
    time.sleep(0.02)
    progress.count("slow", 10)
    assert 0.05 < (progress.left or 0.0) < 3.0
    assert str(progress) == "70 of 100 slow"


@pytest.mark.skipif(os.name == "nt", reason="signals of POSIX")
def test_a_job_that_was_ended_twice_goes_on(tmp_path: Path, file: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """An interrupt goes to the whole group, as from a terminal; a kill to the job alone, whose workers must end.

    ``python tests/stress/killed_jobs.py`` kills twenty, at random moments.
    """
    monkeypatch.setattr(parts, "ENTRIES", 24)  # as the processes below have it
    text = Path(file).read_text(encoding="utf-8").replace('samples = 8\nalso = ["large", "digits"]', "samples = 100")
    Path(file).write_text(text, encoding="utf-8")
    kept, run = tmp_path / "kept", ["run", file]
    command = [sys.executable, "-c", COMMAND, *run, "--figures", "none", "--out", str(tmp_path / "out")]
    command += ["--workers", "2", "--checkpoint", str(kept)]
    for end, number, code in ((os.killpg, signal.SIGINT, 130), (os.kill, signal.SIGKILL, -signal.SIGKILL)):
        before = {path: path.stat().st_mtime_ns for path in kept.glob("chunk-*")}
        with subprocess.Popen(command, stderr=subprocess.PIPE, start_new_session=True) as running:
            wait_for_parts(kept, len(before) + 2)
            end(running.pid, number)
            # Standard error stays open as long as a worker lives.
            _, told = running.communicate(timeout=60)
        assert running.returncode == code
        assert b"Traceback" not in told, told.decode()
        if number == signal.SIGINT:
            assert f"parts are stored in {kept}: the same command goes on from there".encode() in told
            assert not (tmp_path / "out").exists()
        assert {path: path.stat().st_mtime_ns for path in before} == before
    stored = {path: path.stat().st_mtime_ns for path in kept.glob("chunk-*")}
    resumed = written(tmp_path, "resumed", *run, "--checkpoint", str(kept), "--resume")
    assert {path: path.stat().st_mtime_ns for path in stored} == stored
    assert resumed == written(tmp_path, "alone", *run)


def wait_for_parts(kept: Path, count: int) -> None:
    """Wait until so many are stored, not for ever."""
    for _ in range(1200):
        if len(list(kept.glob("chunk-*"))) >= count:
            return
        time.sleep(0.05)
    raise TimeoutError


def test_what_is_computed_of_a_piece_can_be_sent() -> None:
    """All that other processes need, and no more than its bytes."""
    import pickle

    held = paper.compute(Inputs(poses=(30.0, 30.0, 1.0), samples=4), large=False).study.parts
    task = pickle.loads(pickle.dumps(held.begin(["error_bound"])))
    assert_array_equal(task(slice(0, 4))["error_bound"], held["error_bound"])
    assert held.begin(["error_bound"]).names == ()
    assert SamplePiece(0, 4, "linear").cut == slice(0, 4)
