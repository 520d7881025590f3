"""The same bits whoever computes the chunks, and in whatever order they come."""

from __future__ import annotations

import multiprocessing
import os
import pickle
import random
import sys
import threading
from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from time import sleep

import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import propagate
from linkframe.models.propagation.chunk import cuts
from linkframe.models.propagation.processes import of_this_process, processes
from linkframe.models.propagation.progress import told
from linkframe.models.sampling import BLOCK
from numpy.testing import assert_array_equal
from scipy import stats

INPUTS = {"a": stats.norm(3.0, 2.0), "b": stats.uniform()}
COMMON = {"n": 9 * BLOCK + 100, "rng": 3, "chunk": 2 * BLOCK, "progress": False}


def fn(a, b):
    return np.stack([a * b, a - b, np.where(a > 9.0, np.nan, a)], axis=-1)


def dies(a, b):
    os._exit(1)


def same(found, wanted):
    assert_array_equal(found.mean, wanted.mean)
    assert_array_equal(found.std_standard_error, wanted.std_standard_error)
    assert_array_equal(found.envelope, wanted.envelope)
    assert found.failed == wanted.failed
    if wanted.kept is not None:
        assert_array_equal(found.samples, wanted.samples)
    else:
        assert_array_equal(found.quantile([0.1, 0.99]), wanted.quantile([0.1, 0.99]))
        assert_array_equal(found.covariance, wanted.covariance)


class Shuffled(ThreadPoolExecutor):
    """Four workers that get their chunks sent, and finish them in a random order, as if 200 raced."""

    def __init__(self, seed):
        super().__init__(4)
        self.rng = random.Random(seed)

    def submit(self, task, *args, **more):
        return super().submit(self._late, pickle.dumps((task, args)), self.rng.random())

    @staticmethod
    def _late(sent, share):
        sleep(0.01 * share)
        task, args = pickle.loads(sent)
        return task(*args)


@pytest.mark.filterwarnings("ignore:.*samples are NaN")
@pytest.mark.parametrize("sampler", ["random", "lhs", "sobol", "halton"])
def test_same_bits_on_one_worker_two_hundred_and_threads(sampler):
    for keep, also in ((True, ()), (False, ("histogram", "covariance"))):
        given = {**COMMON, "sampler": sampler, "keep_samples": keep, "also": also}
        wanted = propagate(fn, INPUTS, **given)
        with ThreadPoolExecutor(3) as threads:
            for workers in (Shuffled(0), Shuffled(1), threads, map, threads.map):
                same(propagate(fn, INPUTS, workers=workers, **given), wanted)


@pytest.mark.filterwarnings("ignore:.*samples are NaN")
@pytest.mark.filterwarnings("ignore:.*multi-threaded, use of fork")
def test_same_bits_on_processes():
    wanted = propagate(fn, INPUTS, sampler="sobol", **COMMON)
    same(propagate(fn, INPUTS, sampler="sobol", workers=2, **COMMON), wanted)
    with multiprocessing.get_context("fork").Pool(1) as pool:
        same(propagate(fn, INPUTS, sampler="sobol", workers=pool.map, **COMMON), wanted)


class Client:
    """As much of a dask client as is asked of it: its map returns futures, its executor results."""

    def __init__(self, executor):
        self.executor = executor

    def map(self, *_):
        raise AssertionError("futures are no results")

    def nthreads(self):
        return {"one": 1, "two": 2}

    def get_executor(self):
        return self.executor


@pytest.mark.filterwarnings("ignore:.*samples are NaN")
def test_a_client_of_dask_is_asked_for_its_executor():
    wanted = propagate(fn, INPUTS, **COMMON)
    same(propagate(fn, INPUTS, workers=Client(ThreadPoolExecutor(2)), **COMMON), wanted)


def test_cuts_are_whole_blocks_with_what_is_left_over_in_the_last():
    assert cuts(10 * BLOCK + 1, BLOCK) == [(2 * k * BLOCK, 2 * (k + 1) * BLOCK) for k in range(4)] + [
        (8 * BLOCK, 10 * BLOCK + 1)
    ]
    assert cuts(5, 10**6) == [(0, 5)]
    assert cuts(5 * BLOCK, 2 * BLOCK) == [(0, 2 * BLOCK), (2 * BLOCK, 5 * BLOCK)]
    assert cuts(6 * BLOCK, 2 * BLOCK)[-1] == (4 * BLOCK, 6 * BLOCK)


@pytest.mark.parametrize("workers", [0, -2, True, "two", 2.5])
def test_what_are_no_workers_is_refused(workers):
    with pytest.raises(FrameError, match="workers is"):
        propagate(fn, INPUTS, workers=workers, **COMMON)


def test_a_function_that_cannot_be_sent_is_told_at_once(monkeypatch):
    monkeypatch.setitem(sys.modules, "cloudpickle", None)
    with pytest.raises(FrameError, match=r"cannot be sent to another process .* define it and what it uses at the top"):
        propagate(lambda a, b: a, INPUTS, workers=2, **COMMON)


def test_a_worker_that_dies_is_told():
    with ProcessPoolExecutor(1) as pool, pytest.raises(FrameError, match="a worker came to an end before its chunk"):
        propagate(dies, INPUTS, workers=pool, **COMMON)


def long_result(cut):
    return bytes(30_000_000)


def test_workers_that_are_ended_in_the_middle_of_a_result_leave_nothing_waiting():
    """The thread that reads the results once waited for the rest of one, and the process for the thread, for ever."""
    for _ in range(3):
        before = set(threading.enumerate())
        with pytest.raises(KeyboardInterrupt), processes(long_result, 2, None) as pool:  # noqa: PT012
            sent = [pool.submit(of_this_process, cut) for cut in range(4)]
            sent[0].result()
            raise KeyboardInterrupt
        for thread in set(threading.enumerate()) - before:
            thread.join(20.0)
            assert not thread.is_alive()


def test_a_map_that_returns_something_else():
    with pytest.raises(FrameError, match="returned a Future for a chunk"), ThreadPoolExecutor(1) as pool:
        propagate(fn, INPUTS, workers=lambda task, each: [pool.submit(task, one) for one in each], **COMMON)
    with pytest.raises(FrameError, match="returned 0 of 5 chunks"):
        propagate(fn, INPUTS, workers=lambda task, each: [], **COMMON)


def test_an_error_of_the_function_comes_through():
    def wrong(a, b):
        raise ZeroDivisionError("no such length")

    with ThreadPoolExecutor(2) as pool, pytest.raises(ZeroDivisionError, match="no such length"):
        propagate(wrong, INPUTS, workers=pool, **COMMON)


# -- progress ---------------------------------------------------------------------------------------------------------


def test_the_bar_tells_the_standard_error_so_far(monkeypatch, capsys):
    monkeypatch.setattr("linkframe.models.propagation.progress.DELAY", 0.0)
    monkeypatch.setattr("linkframe.models.propagation.progress.BETWEEN", 0.0)
    found = propagate(lambda a, b: (sleep(0.02), a)[1], INPUTS, **COMMON | {"progress": True})
    shown = capsys.readouterr().err
    assert "samples/s, standard error 0.0" in shown
    assert told(found.moments) == f"standard error {found.standard_error:.2g}"
    many = propagate(lambda a, b: np.stack([a, b], -1), INPUTS, **COMMON)
    assert told(many.moments) == f"standard error at most {many.standard_error.max():.2g}"


def test_no_bar_without_tqdm(monkeypatch, capsys):
    monkeypatch.setitem(sys.modules, "tqdm", None)
    propagate(lambda a, b: a, INPUTS, **COMMON | {"progress": True})
    assert not capsys.readouterr().err
