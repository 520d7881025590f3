"""Runs that are ended go on where they were, to the same bits; what is not theirs, or not whole, is not taken."""

from __future__ import annotations

import resource
import shutil
import signal
import subprocess
import sys
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from linkframe.framework.errors import CheckpointWarning, FrameError
from linkframe.models import propagate
from linkframe.models.propagation import run
from linkframe.models.propagation.ordered import StoredChunks
from linkframe.models.sampling import BLOCK
from numpy.testing import assert_array_equal
from scipy import stats
from scipy.stats import qmc

TESTS = Path(__file__).parents[1]
INPUTS = {"a": stats.norm(3.0, 2.0), "b": (0.0, 1.0)}
STREAM = {"keep_samples": False, "also": ("histogram", "covariance")}


def fn(a, b):
    return np.stack([a * b, a - b], axis=-1)


class Counted:
    """Counts the samples it is called for, and gives up or is interrupted after some calls."""

    def __init__(self, calls=10**6, error=KeyboardInterrupt):
        self.left, self.error, self.samples = calls, error, 0

    def __call__(self, a, b):
        if len(a) == 2:  # the first samples, by which the function is known
            return fn(a, b)
        if not self.left:
            raise self.error
        self.left -= 1
        self.samples += len(a)
        return fn(a, b)


def go(folder, counted=None, **more):
    given = {"n": 8 * BLOCK, "rng": 1, "sampler": "sobol", "chunk": 2 * BLOCK, "progress": False} | STREAM | more
    return propagate(counted or fn, given.pop("inputs", INPUTS), checkpoint=folder, **given)


def same(found, wanted):
    assert_array_equal(found.mean, wanted.mean)
    assert_array_equal(found.std_standard_error, wanted.std_standard_error)
    assert_array_equal(found.envelope, wanted.envelope)
    if wanted.kept is None:
        assert_array_equal(found.quantile([0.1, 0.99]), wanted.quantile([0.1, 0.99]))
        assert_array_equal(found.confidence_interval(of="covariance"), wanted.confidence_interval(of="covariance"))
    else:
        assert_array_equal(found.samples, wanted.samples)


@pytest.mark.parametrize(
    "more", [{}, {"keep_samples": True, "also": ()}, {"sampler": "lhs"}, {"correlation": {("a", "b"): 0.4}}]
)
def test_an_interrupted_run_goes_on_to_the_same_bits(tmp_path, more):
    with pytest.raises(KeyboardInterrupt) as interrupt:
        go(tmp_path / "run", Counted(2), **more)
    told = f"2 of 4 chunks are stored in {tmp_path / 'run'}: the same call with this checkpoint goes on from there"
    assert interrupt.value.__notes__ == [told]
    rest = Counted()
    found = go(tmp_path / "run", rest, **more)
    assert rest.samples == 4 * BLOCK
    same(found, go(None, **more))
    again = Counted(0)
    same(go(tmp_path / "run", again, **more), found)


def test_an_interrupt_without_checkpoint_says_what_would_help():
    with pytest.raises(KeyboardInterrupt) as interrupt:
        go(None, Counted(1))
    assert "with checkpoint='a folder' an interrupted run can be resumed" in interrupt.value.__notes__[0]


def test_a_seed_of_chance_is_that_of_the_run(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        go(tmp_path, Counted(1), rng=None)
    first = go(tmp_path, rng=None)
    same(go(tmp_path, Counted(0), rng=None), first)
    with pytest.raises(KeyboardInterrupt):
        go(tmp_path / "generator", Counted(1), rng=np.random.default_rng(4))
    same(go(tmp_path / "generator", rng=np.random.default_rng(4)), go(None, rng=np.random.default_rng(4)))


@pytest.mark.parametrize("sampler", ["random", "sobol", "halton"])
def test_a_run_is_extended(tmp_path, sampler):
    go(tmp_path, n=4 * BLOCK, sampler=sampler)
    more = Counted()
    found = go(tmp_path, more, n=12 * BLOCK, sampler=sampler)
    assert more.samples == 8 * BLOCK
    same(found, go(None, n=12 * BLOCK, sampler=sampler))


def test_other_workers_may_go_on(tmp_path):
    with pytest.raises(KeyboardInterrupt):
        go(tmp_path, Counted(2))
    same(go(tmp_path, workers=2), go(None))


@pytest.mark.parametrize(
    ("change", "told"),
    [
        ({"rng": 2}, "the seed differs"),
        ({"sampler": "random"}, "the sampler differs"),
        ({"sampler": qmc.Sobol(2, rng=0)}, "the sampler differs"),
        ({"inputs": {**INPUTS, "b": (0.0, 1.1)}}, "the distribution of 'b' differs"),
        ({"inputs": dict(reversed(INPUTS.items()))}, "the order of the inputs differs"),
        ({"correlation": {("a", "b"): 0.1}}, "the correlation differs"),
        ({"also": ()}, "also differs"),
        ({"nan_policy": "raise"}, "nan_policy differs"),
        ({"counted": lambda a, b: fn(a, 1.001 * b)}, "what the function returns for the first samples differs"),
        ({"counted": lambda a, b: a}, "what the function returns for the first samples differs"),
    ],
)
def test_another_run_is_refused(tmp_path, change, told):
    go(tmp_path)
    before = {path: path.read_bytes() for path in tmp_path.iterdir()}
    with pytest.raises(FrameError, match=f"belongs to another run: {told}"):
        go(tmp_path, **change)
    assert {path: path.read_bytes() for path in tmp_path.iterdir()} == before


def test_a_function_that_differs_by_rounding_is_the_same(tmp_path):
    go(tmp_path)
    go(tmp_path, lambda a, b: fn(a, b) * (1.0 + 2.0**-50))


def test_the_number_of_a_latin_hypercube_belongs_to_it(tmp_path):
    go(tmp_path, sampler="lhs")
    with pytest.raises(FrameError, match="the number of samples differs"):
        go(tmp_path, sampler="lhs", n=12 * BLOCK)


@pytest.mark.parametrize(
    "harm", [lambda b: b[: len(b) // 2], lambda b: b"", lambda b: b[:-9] + bytes([b[-9] ^ 1]) + b[-8:]]
)
def test_a_damaged_chunk_is_found_and_done_again(tmp_path, harm, monkeypatch):
    """Cut off, empty, or with one bit turned."""
    monkeypatch.setattr(run, "StoredChunks", partial(StoredChunks, pause=0.0))  # each chunk as soon as it is done
    wanted = go(tmp_path)
    chunk = sorted(tmp_path.glob("chunk-*"))[2]
    chunk.write_bytes(harm(chunk.read_bytes()))
    again = Counted()
    with pytest.warns(CheckpointWarning, match=f"{chunk.name} is damaged .* computed again"):
        found = go(tmp_path, again)
    assert again.samples == 2 * BLOCK
    same(found, wanted)
    same(go(tmp_path, Counted(0)), wanted)


def test_a_folder_that_holds_something_else(tmp_path):
    go(tmp_path)
    (tmp_path / "run.json").write_text("{", encoding="utf-8")
    with pytest.raises(FrameError, match=r"run\.json is damaged: remove the folder"):
        go(tmp_path)
    (tmp_path / "run.json").write_text('{"format": 0}', encoding="utf-8")
    with pytest.raises(FrameError, match="is of another release"):
        go(tmp_path)
    (tmp_path / "run.json").unlink()
    with pytest.raises(FrameError, match=r"holds chunks, but no run\.json"):
        go(tmp_path)


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(FrameError, match=r"checkpoint .*file/run cannot be (made|read): Not a directory"):
        go(tmp_path / "file" / "run")
    with pytest.raises(FrameError, match=r"cannot be (made|written): "):
        go(Path("/proc/run"))


def test_a_full_disk_leaves_the_chunks_before_it_good(tmp_path, monkeypatch):
    """No file may grow beyond a limit, which comes after two chunks: as a full disk the write fails half way."""
    monkeypatch.setattr(run, "StoredChunks", partial(StoredChunks, pause=0.0))  # each chunk as soon as it is done
    wanted = go(None)
    counted = Counted()
    soft, hard = resource.getrlimit(resource.RLIMIT_FSIZE)
    before = signal.signal(signal.SIGXFSZ, signal.SIG_IGN)

    def filled(a, b):
        result = counted(a, b)
        if counted.samples == 6 * BLOCK:
            resource.setrlimit(resource.RLIMIT_FSIZE, (20_000, hard))
        return result

    try:
        with pytest.raises(FrameError, match=r"chunk-.* cannot be written: File too large; .* make room") as error:
            go(tmp_path, filled)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (soft, hard))
        signal.signal(signal.SIGXFSZ, before)
    assert "2 of 4 chunks are stored" in error.value.__notes__[0]
    assert not list(tmp_path.glob(".*"))
    rest = Counted()
    same(go(tmp_path, rest), wanted)
    assert rest.samples == 4 * BLOCK


def test_a_folder_that_vanishes_is_told(tmp_path, monkeypatch):
    """Nothing is left there to go on from."""
    monkeypatch.setattr(run, "StoredChunks", partial(StoredChunks, pause=0.0))
    counted = Counted()

    def removes(a, b):
        result = counted(a, b)
        if counted.samples == 6 * BLOCK:
            shutil.rmtree(tmp_path / "run")
        return result

    with pytest.raises(FrameError, match=r"checkpoint .*run is gone, and what was stored there: start again") as error:
        go(tmp_path / "run", removes)
    assert not getattr(error.value, "__notes__", [])


def test_runs_that_are_killed_go_on_to_the_same_bits():
    """Two here; ``python tests/stress/kills.py`` kills twenty."""
    script = "import sys, warnings; warnings.simplefilter('ignore'); from stress.kills import kills; kills(2)"
    subprocess.run([sys.executable, "-c", script], check=True, timeout=60, cwd=TESTS)


@pytest.mark.parametrize("other", [1e9, np.inf])
def test_another_function_beside_results_that_are_great(tmp_path, other):
    """Displacements beside stresses: a function that has changed in the small ones alone is another one."""

    def run(size):
        def fn(x):
            return np.stack([size * x, np.full_like(x, other)], axis=-1)

        with np.errstate(invalid="ignore"):
            return propagate(fn, {"x": stats.norm(1.0, 0.1)}, n=4096, rng=0, checkpoint=tmp_path)

    assert run(1e-5 * (1.0 + 1e-13)).mean[0] == run(1e-5).mean[0]
    with pytest.raises(FrameError, match="another run"):
        run(1.3e-5)


def test_a_run_begins_with_its_first_chunk(tmp_path):
    """Alone, nothing is computed twice to know the function by; with others, two samples are."""
    called = []

    def counted(a, b):
        called.append(len(a))
        return fn(a, b)

    go(tmp_path / "alone", counted)
    assert called == [2 * BLOCK] * 4
    called.clear()
    go(tmp_path / "mapped", counted, workers=map)
    assert called == [2, *[2 * BLOCK] * 4]


def test_a_function_that_rounds_otherwise_for_few_samples_is_the_same(tmp_path):
    def rounding(a, b):
        # A difference of what is almost the same, of which nothing but rounding is left.
        return np.stack([a * b, (1e-12 if len(a) == 2 else 1e-13) * np.sign(a - b)], axis=-1)

    first = go(tmp_path, rounding)
    same(go(tmp_path, rounding), first)
    with pytest.raises(FrameError, match="what the function returns for the first samples differs"):
        go(tmp_path, lambda a, b: 1.001 * rounding(a, b))


def test_a_folder_that_cannot_be_made_is_refused_before_anything_is_computed(tmp_path):
    (tmp_path / "file").write_text("")
    counted = Counted()
    with pytest.raises(FrameError, match="file/run cannot be"):
        go(tmp_path / "file" / "run", counted)
    assert counted.samples == 0
