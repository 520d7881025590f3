"""A cluster of dask on this machine: the same bits as on one worker, also where a worker is killed at its chunk."""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Iterator
from concurrent.futures import Executor, Future
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import propagate
from linkframe.models.sampling import BLOCK
from numpy.testing import assert_array_equal
from scipy import stats

INPUTS = {"a": stats.norm(3.0, 2.0), "b": stats.uniform()}
COMMON: dict[str, Any] = {"n": 9 * BLOCK + 100, "rng": 3, "chunk": 2 * BLOCK, "progress": False}


def both(a: Any, b: Any) -> Any:
    return np.stack([a * b, a - b], axis=-1)


def killed_once(a: Any, b: Any, mark: str, spared: int) -> Any:
    """Like `both`, but the first process that comes here, unless it is spared, is killed in the middle of its chunk."""
    if os.getpid() == spared:
        return both(a, b)
    try:
        os.close(os.open(mark, os.O_CREAT | os.O_EXCL))
    except FileExistsError:
        return both(a, b)
    os.kill(os.getpid(), signal.SIGKILL)
    return both(a, b)


def same(found: Any, wanted: Any) -> None:
    for name in ("mean", "std", "std_standard_error", "envelope"):
        assert_array_equal(getattr(found, name), getattr(wanted, name))


@pytest.fixture(scope="module")
def client() -> Iterator[Any]:
    distributed = pytest.importorskip("distributed")
    # Without its pages, whose port another cluster may have.
    cluster = distributed.LocalCluster(
        2, threads_per_worker=1, dashboard_address=None, scheduler_kwargs={"dashboard": False}
    )
    with cluster, distributed.Client(cluster) as found:
        yield found


def test_same_bits_on_a_cluster(client: Any) -> None:
    for options in ({"sampler": "sobol"}, {"keep_samples": False, "also": ("histogram", "covariance")}):
        found = propagate(both, INPUTS, workers=client, **COMMON, **options)
        wanted = propagate(both, INPUTS, **COMMON, **options)
        same(found, wanted)
        assert_array_equal(found.quantile([0.01, 0.9]), wanted.quantile([0.01, 0.9]))


def test_a_function_of_a_script_goes_by_value(client: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """The workers do not know it by name, as they do not know that of a notebook."""
    space: dict[str, Any] = {"__name__": "__main__"}
    exec("factor = 2.0\ndef scaled(a, b):\n    return factor * a * b\n", space)
    monkeypatch.setattr(sys.modules["__main__"], "scaled", space["scaled"], raising=False)
    found = propagate(space["scaled"], INPUTS, workers=client, **COMMON)
    same(found, propagate(space["scaled"], INPUTS, **COMMON))


def test_a_worker_that_is_killed_costs_no_bit(client: Any, tmp_path: Path) -> None:
    before = set(client.run(os.getpid).values())
    function = partial(killed_once, mark=str(tmp_path / "killed"), spared=os.getpid())
    found = propagate(function, INPUTS, workers=client, checkpoint=tmp_path / "run", **COMMON)
    same(found, propagate(both, INPUTS, **COMMON))
    assert (tmp_path / "killed").exists()
    assert len(list((tmp_path / "run").glob("chunk-*"))) == 5
    client.wait_for_workers(2, timeout=30)
    assert before - set(client.run(os.getpid).values())


class Failing(Executor):
    """An executor of which every chunk ends alike."""

    def __init__(self, error: Exception | None) -> None:
        self.error = error

    def submit(self, *_: Any, **__: Any) -> Future[Any]:
        future: Future[Any] = Future()
        if self.error is None:
            future.cancel()
            future.set_running_or_notify_cancel()
        else:
            future.set_exception(self.error)
        return future


class KilledWorker(Exception):
    """By this name dask tells of a chunk at which its workers died, one after the other."""


def test_a_cluster_that_is_lost_is_told() -> None:
    with pytest.raises(FrameError, match="a worker came to an end before its chunk was done"):
        propagate(both, INPUTS, workers=Failing(KilledWorker("chunk", 3)), **COMMON)
    with pytest.raises(FrameError, match="a chunk was cancelled before it was done: the executor, or the cluster"):
        propagate(both, INPUTS, workers=Failing(None), **COMMON)
    scheduler = sys.modules.get("distributed.scheduler")
    assert scheduler is None or scheduler.KilledWorker.__name__ == KilledWorker.__name__
