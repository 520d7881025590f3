"""Who computes the chunks: this process, others, threads, or the machines of a cluster."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from contextlib import contextmanager
from typing import Any

from ...framework.errors import FrameError
from .chunk import ChunkResult, ChunkTask

Cut = tuple[int, int]
# An integer, a map-like callable, an executor, or a client of dask, which need not be there.
Workers = Any
# Chunks that are handed out ahead for each worker, and how far they may run ahead of the first one that is not done.
AHEAD, APART = 2, 8


def computed(task: ChunkTask, cuts: Sequence[Cut], workers: Workers) -> Iterator[ChunkResult]:
    """Chunks as they are done, in whatever order.

    Parameters
    ----------
    task
        What to do.
    cuts
        Ranges of samples, one a chunk.
    workers
        As `propagate` takes it.

    Yields
    ------
    ChunkResult
        Of one of the cuts.

    Raises
    ------
    FrameError
        If the workers cannot be meant, or one of them came to an end.
    """
    if isinstance(workers, bool) or (isinstance(workers, int) and (workers == 0 or workers < -1)):
        raise FrameError(f"workers is {workers!r}: give their number, or -1 for all processors")
    if isinstance(workers, int):
        count = processors() if workers == -1 else workers
        if count == 1 or len(cuts) < 2:
            yield from map(task, cuts)
        else:
            with _processes(task, min(count, len(cuts))) as pool:
                yield from _by_executor(task, cuts, pool, count)
    elif hasattr(workers, "get_executor"):
        # The map of a dask Client returns futures: its executor is what behaves as those of Python do.
        with workers.get_executor() as executor:
            yield from _by_executor(task, cuts, executor, _threads(workers))
    elif isinstance(workers, Executor) or hasattr(workers, "submit"):
        yield from _by_executor(task, cuts, workers, getattr(workers, "_max_workers", None) or processors())
    elif callable(workers):
        yield from _by_map(task, cuts, workers)
    else:
        raise FrameError(
            f"workers is {workers!r}: give a number, a callable like map, a concurrent.futures.Executor "
            "or a dask Client"
        )


def processors() -> int:
    """Number of processors that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def _threads(client: Any) -> int:
    """Number of threads of all workers of a dask client at the moment."""
    return max(1, int(sum(client.nthreads().values())))


@contextmanager
def _processes(task: ChunkTask, count: int) -> Iterator[Executor]:
    """Processes of our own, ended with this run."""
    from concurrent.futures import ProcessPoolExecutor

    _ = task.__reduce__()  # what cannot be sent is told here, not by a pool that waits for ever
    pool = ProcessPoolExecutor(count, initializer=_leave_interrupts)
    try:
        yield pool
    except BaseException:
        for process in list((getattr(pool, "_processes", None) or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        raise
    pool.shutdown()


def _leave_interrupts() -> None:
    """An interrupt from the keyboard goes to the whole group; the process that hands out the chunks answers it."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def _by_executor(task: ChunkTask, cuts: Sequence[Cut], executor: Executor, count: int) -> Iterator[ChunkResult]:
    waiting: dict[Future[ChunkResult], int] = {}
    handed = 0
    try:
        while handed < len(cuts) or waiting:
            behind = min(waiting.values(), default=handed)
            while handed < len(cuts) and len(waiting) < AHEAD * count and handed - behind < APART * count:
                waiting[executor.submit(task, cuts[handed])] = handed
                handed += 1
            done, _ = wait(waiting, return_when=FIRST_COMPLETED)
            for future in sorted(done, key=lambda each: waiting[each]):
                del waiting[future]
                yield future.result()
    except CancelledError as error:
        raise FrameError(
            "a chunk was cancelled before it was done: the executor, or the cluster with its client, was shut down"
        ) from error
    except Exception as error:
        if not _lost(error):
            raise
        raise FrameError(
            f"a worker came to an end before its chunk was done ({error}): it was killed, or memory ran out; "
            "give fewer workers, or a smaller chunk"
        ) from error
    finally:
        for future in waiting:
            future.cancel()


def _lost(error: Exception) -> bool:
    """Whether a worker was lost; on a cluster of dask as many as it allows were, one after the other, by one chunk."""
    return isinstance(error, BrokenExecutor) or any(kind.__name__ == "KilledWorker" for kind in type(error).__mro__)


def _by_map(
    task: ChunkTask, cuts: Sequence[Cut], mapped: Callable[..., Iterable[ChunkResult]]
) -> Iterator[ChunkResult]:
    count = 0
    for found in mapped(task, cuts):
        if not isinstance(found, ChunkResult):
            raise FrameError(
                f"workers {mapped!r} returned a {type(found).__name__} for a chunk: give a callable that returns the "
                "results as map does, or an executor"
            )
        count += 1
        yield found
    if count != len(cuts):
        raise FrameError(f"workers {mapped!r} returned {count} of {len(cuts)} chunks: give a callable like map")
