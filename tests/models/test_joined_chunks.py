"""Short chunks that wait for each other are stored in one file, from which a run goes on as from files of their own."""

from __future__ import annotations

from functools import partial
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from linkframe.framework.errors import CheckpointWarning, FrameError
from linkframe.models import propagate
from linkframe.models.propagation import Propagation, run
from linkframe.models.propagation.checkpoint import Checkpoint
from linkframe.models.propagation.gathered import joined
from linkframe.models.propagation.ordered import StoredChunks, covered
from linkframe.models.sampling import BLOCK
from numpy.typing import NDArray
from scipy import stats

Array = NDArray[np.float64]
INPUTS = {"a": stats.norm(3.0, 2.0), "b": (0.0, 1.0)}
SIZE = 2 * BLOCK


@pytest.fixture
def patient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Chunks wait however long they take."""
    monkeypatch.setattr(run, "StoredChunks", partial(StoredChunks, pause=3600.0))


class Function:
    """Keeps what it is called for, gives up after some calls, and fails for one number."""

    def __init__(self, calls: int = 10**6, lost: float = np.inf) -> None:
        self.left, self.lost, self.seen = calls, lost, list[Array]()

    @property
    def samples(self) -> int:
        return sum(map(len, self.seen))

    def __call__(self, a: Array, b: Array) -> Array:
        if len(a) > 2:
            if not self.left:
                raise FrameError("no more")
            self.left -= 1
            self.seen.append(a)
        return np.stack([np.where(a == self.lost, np.nan, a * b), a - b], axis=-1)


def go(folder: Path | None, function: Function | None = None, **more: Any) -> Propagation:
    given = {"n": 6 * SIZE, "rng": 1, "chunk": SIZE, "progress": False, "keep_samples": False} | more
    return propagate(function or Function(), INPUTS, checkpoint=folder, **given)


def files(folder: Path) -> list[tuple[int, int]]:
    """First chunk of each file and the one behind its last."""
    names = (path.stem.split("-") for path in sorted(folder.glob("chunk-*")))
    return [(int(start) // SIZE, -(-int(stop) // SIZE)) for _, start, stop in names]


def same(found: Propagation, wanted: Propagation) -> None:
    for key in ("n", "mean", "second", "third", "fourth"):
        np.testing.assert_array_equal(getattr(found.moments, key), getattr(wanted.moments, key))
    np.testing.assert_array_equal(found.envelope, wanted.envelope)
    np.testing.assert_array_equal(found.missing, wanted.missing)
    assert found.failures.numbers.tolist() == wanted.failures.numbers.tolist()


@pytest.mark.parametrize("more", [{}, {"also": ("histogram", "covariance")}, {"replicates": 4}], ids=str)
def test_a_run_goes_on_from_a_file_of_several_chunks(tmp_path: Path, patient: None, more: dict[str, Any]) -> None:
    with pytest.raises(FrameError, match="no more") as ended:
        go(tmp_path, Function(4), **more)
    assert "4 of 6 chunks are stored" in ended.value.__notes__[0]
    assert files(tmp_path) == [(0, 4)]
    rest = Function()
    found, wanted = go(tmp_path, rest, **more), go(None, **more)
    assert rest.samples == 2 * SIZE
    assert files(tmp_path) == [(0, 4), (4, 6)]
    for each in (found, go(tmp_path, Function(0), **more)):
        same(each, wanted)
        if "also" in more:
            np.testing.assert_array_equal(each.quantile([0.1, 0.99]), wanted.quantile([0.1, 0.99]))
            interval, expected = (one.confidence_interval(of="covariance") for one in (each, wanted))
            np.testing.assert_array_equal(interval, expected)
        if "replicates" in more:
            np.testing.assert_array_equal(each.standard_error, wanted.standard_error)


def test_all_chunks_of_a_damaged_file_are_done_again(tmp_path: Path, patient: None) -> None:
    wanted = go(tmp_path)
    (file,) = tmp_path.glob("chunk-*")
    file.write_bytes(file.read_bytes()[:-1])
    again = Function()
    with pytest.warns(CheckpointWarning, match="damaged"):
        same(go(tmp_path, again), wanted)
    assert again.samples == 6 * SIZE
    same(go(tmp_path, Function(0)), wanted)


@pytest.mark.filterwarnings("ignore::linkframe.framework.errors.SampleWarning")
def test_chunks_of_which_a_sample_failed_have_files_of_their_own(tmp_path: Path, patient: None) -> None:
    drawn = Function()
    go(None, drawn)
    lost = float(np.concatenate(drawn.seen)[2 * SIZE + 7])
    wanted = go(None, Function(lost=lost))
    assert wanted.failures.count == 1
    same(go(tmp_path, Function(lost=lost)), wanted)
    assert files(tmp_path) == [(0, 2), (2, 3), (3, 6)]
    same(go(tmp_path, Function(0, lost=lost)), wanted)


def test_chunks_without_any_result_at_an_entry_have_files_of_their_own(tmp_path: Path, patient: None) -> None:
    """As at a pose that cannot be assembled: each tells why."""

    def entry_without(a: Array, b: Array) -> Array:
        return np.stack([a * b, np.full(a.shape, np.nan)], axis=-1)

    given = {"n": 4 * SIZE, "rng": 1, "chunk": SIZE, "progress": False, "keep_samples": False}
    wanted = propagate(entry_without, INPUTS, **given)
    for _ in range(2):
        same(propagate(entry_without, INPUTS, checkpoint=tmp_path, **given), wanted)
    assert wanted.missing.tolist() == [0, 4 * SIZE]
    assert files(tmp_path) == [(k, k + 1) for k in range(4)]


def test_a_short_last_chunk_has_a_file_of_its_own(tmp_path: Path, patient: None) -> None:
    """So that a longer run, which has a whole one there, goes on from the others."""
    go(tmp_path, n=3 * SIZE + BLOCK + 5)
    assert files(tmp_path) == [(0, 3), (3, 4)]
    more = Function()
    same(go(tmp_path, more), go(None))
    assert more.samples == 3 * SIZE


def test_samples_that_are_kept_are_stored_by_chunks(tmp_path: Path, patient: None) -> None:
    found = go(tmp_path, keep_samples=True)
    assert files(tmp_path) == [(k, k + 1) for k in range(6)]
    np.testing.assert_array_equal(go(tmp_path, Function(0), keep_samples=True).samples, found.samples)


def test_neighbours_alone_share_a_file() -> None:
    """As several workers bring them, out of order; and not with a shorter one."""
    failed = SimpleNamespace(whole=None, rows=[])
    cuts = [(0, 2), (4, 6), (2, 4), (8, 10), (10, 11)]
    found: Any = [(cut, SimpleNamespace(count=cut[1] - cut[0], samples=None, failed=failed)) for cut in cuts]
    assert [group for group, _ in joined(found)] == [[cut] for cut in cuts]


def test_each_chunk_is_written_once(tmp_path: Path) -> None:
    checkpoint = Checkpoint.open(tmp_path, {})
    chunks = StoredChunks[Any](
        checkpoint, lambda _: [b""], bytes, lambda waiting: [([cut for cut, _ in waiting], None)], pause=3600.0
    )
    for k in range(3):
        for own in (2 * k, 2 * k + 1):
            chunks.store((own, own + 1), None)
        chunks.flush()
    assert checkpoint.stored() == {(0, 2), (2, 4), (4, 6)}
    assert chunks.written == 6


def test_files_that_overlap_serve_as_far_as_they_can() -> None:
    cuts = [(k, k + 1) for k in range(6)]
    assert covered(cuts, {(0, 2), (0, 3), (2, 5), (4, 6), (5, 6), (7, 9), (5, 3)}) == {
        (0, 1): (0, 3), (1, 2): None, (2, 3): None, (4, 5): (4, 6), (5, 6): None,
    }  # fmt: skip


def test_files_of_several_kinds_of_samples_lie_side_by_side() -> None:
    cuts = [(k, k + 1, of) for k in range(3) for of in ("linear", "large")]
    assert covered(cuts, {(0, 2, "large"), (1, 2, "linear"), (2, 3, "other")}) == {
        (0, 1, "large"): (0, 2, "large"), (1, 2, "large"): None, (1, 2, "linear"): (1, 2, "linear"),
    }  # fmt: skip
