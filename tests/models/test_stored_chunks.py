"""Chunks as they lie on disk: every kind of array, several at a time, and none of what was half written."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.framework.owner import owner
from linkframe.models.job.parts import Parts
from linkframe.models.job.sharing import SampleKind, Sharing
from linkframe.models.propagation import ordered
from linkframe.models.propagation.checkpoint import Checkpoint
from linkframe.models.propagation.ordered import StoredChunks, gather
from linkframe.models.propagation.packed import packed_arrays, unpacked_arrays
from numpy.testing import assert_array_equal

TABLE = np.arange(24.0).reshape(2, 3, 4)
ARRAYS: dict[str, Any] = {
    "as it is": TABLE, "components first": TABLE.transpose(2, 0, 1), "some": TABLE[:, ::2], "one": np.array(3.0),
    "the same": np.broadcast_to(2.0, (3, 2)), "nothing": np.zeros((0, 3)), "names": np.array(["", "ab"]),
    "no characters": np.zeros(2, "U0"), "whether": np.array([True, False]),
    "counted": np.array([("not assembled", 3), ("", 1)], dtype=[("text", "U13"), ("count", np.int64)]),
}  # fmt: skip


@pytest.mark.parametrize("name", ARRAYS)
def test_every_array_comes_back(name: str) -> None:
    found = unpacked_arrays(b"".join(packed_arrays({"before": TABLE, name: ARRAYS[name], "behind": TABLE})))
    assert found[name].dtype == ARRAYS[name].dtype
    assert_array_equal(found[name], ARRAYS[name])
    assert_array_equal(found["behind"], TABLE)


class Lost:
    """Samples of which some have no result."""

    def __init__(self, cut: slice) -> None:
        self.cut = cut

    def lost(self) -> dict[str, int]:
        return {"not assembled": self.cut.stop - self.cut.start}


def test_counts_of_lost_samples_are_read_back(tmp_path: Path) -> None:
    for _ in range(2):
        parts = Parts(Lost, (1, 40), counted=("lost",))
        kinds = {"linear": SampleKind("samples", parts, ("lost",))}
        Sharing(1, tmp_path, {}).compute(kinds, lambda *_: None)
        assert parts.count("lost") == {"not assembled": 40}


class Receiving:
    """Takes chunks, and is interrupted at one."""

    def __init__(self, error: BaseException | None = None) -> None:
        self.error, self.got = error, list[int]()

    def expect(self, cut: tuple[int, int]) -> None:
        """Nothing is to be told."""

    def add(self, cut: tuple[int, int], _: object) -> None:
        self.got.append(cut[0])
        if self.error is not None and len(self.got) == 4:
            raise self.error

    def progress(self, done: int, of: int) -> str:
        return f"{done} of {of}"


@pytest.mark.parametrize("error", [KeyboardInterrupt(), FrameError("no"), None])
def test_chunks_that_wait_for_others_are_written_when_the_run_ends(tmp_path: Path, error: BaseException | None) -> None:
    """However it ends, and told as they are on disk."""
    cuts = [(k, k + 1) for k in range(6)]

    def compute(left: list[tuple[int, int]]) -> Iterator[Any]:
        for cut in left:
            assert not list(tmp_path.glob("chunk-*"))
            yield cut, {"x": np.full(3, float(cut[0]))}

    folder = StoredChunks(Checkpoint.open(tmp_path, {}), packed_arrays, unpacked_arrays, pause=60.0)
    receiver = Receiving(error)
    if error is None:
        gather(cuts, compute, receiver, folder, set())  # type: ignore[arg-type]
    else:
        with pytest.raises(type(error)) as ended:
            gather(cuts, compute, receiver, folder, set())  # type: ignore[arg-type]
        assert ended.value.__notes__ == ["4 of 6"]
    stored = Checkpoint(tmp_path).stored()
    assert stored == set(cuts[: 4 if error else 6])
    assert folder.load(cuts[2])["x"].tolist() == [2.0] * 3


@pytest.mark.skipif(os.name != "posix", reason="processes of POSIX")
def test_what_a_killed_process_left_half_written_is_removed(tmp_path: Path) -> None:
    machine = owner().partition("-")[0]
    gone, living = f".chunk-1.bin.{machine}-{2**22 + 1}-5.part", f".chunk-2.bin.{owner()}.part"
    Checkpoint.open(tmp_path, {})
    for name in (gone, living):
        (tmp_path / name).write_bytes(b"half")
    Checkpoint.open(tmp_path, {})
    assert [path.name for path in tmp_path.glob(".*")] == [living]


def test_of_two_runs_that_begin_at_once_one_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The other begins after this one has found the folder empty."""
    begin = Checkpoint._begin

    def late(self: Checkpoint, about: dict[str, Any]) -> bool:
        monkeypatch.setattr(Checkpoint, "_begin", begin)
        Checkpoint.open(tmp_path, {"load": 1.0})
        return begin(self, about)

    monkeypatch.setattr(Checkpoint, "_begin", late)
    with pytest.raises(FrameError, match="belongs to another run: load differs"):
        Checkpoint.open(tmp_path, {"load": 2.0})
    assert Checkpoint.known(tmp_path) == {"load": 1.0}
    assert [path.name for path in tmp_path.iterdir()] == ["run.json"]


def test_a_run_begins_where_a_file_has_one_name_only(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def refuse(*_: object) -> None:
        raise PermissionError

    monkeypatch.setattr(os, "link", refuse)
    Checkpoint.open(tmp_path, {"load": 2.0})
    assert Checkpoint.known(tmp_path) == {"load": 2.0}
    assert [path.name for path in tmp_path.iterdir()] == ["run.json"]


def test_long_chunks_that_come_together_are_all_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Those of several workers, which began at once; short ones wait for others."""
    clock = [0.0]
    monkeypatch.setattr(ordered, "monotonic", lambda: clock[0])
    for seconds, each in ((600.0, True), (1e-3, False)):
        checkpoint = Checkpoint.open(tmp_path / f"{seconds}", {})
        chunks = StoredChunks[Any](checkpoint, lambda _: [b""], bytes)
        for k in range(8):
            clock[0] += seconds if k % 4 == 0 else 1e-4
            chunks.store((k, k + 1), None)
        assert (len(checkpoint.stored()) == 8) == each
