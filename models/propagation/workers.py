"""Workers that compute the chunks: this process, other processes, threads, or machines of a cluster."""

from __future__ import annotations

import os
from collections.abc import Callable, Generator, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, BrokenExecutor, CancelledError, Executor, Future, wait
from dataclasses import dataclass
from typing import Any, Generic, TypeVar

from ...framework.errors import FrameError
from . import processes

# A number, a callable like map, an executor, or a client of dask, which need not be installed.
Workers = Any
C = TypeVar("C")
R = TypeVar("R")
# Chunks handed out in advance to each worker, and how far ahead of the first unfinished one, by worker.
AHEAD, APART = 2, 8


@dataclass(frozen=True, eq=False)
class _Told(Generic[C, R]):
    """A task that returns its chunk with the result, so that chunks may come in any order."""

    task: Callable[[C], R]

    def __call__(self, cut: C) -> tuple[C, R]:
        return cut, self.task(cut)


def computed(
    task: Callable[[C], R], cuts: Sequence[C], workers: Workers, start: str | None = None, here: int = 0
) -> Generator[tuple[C, R], None, None]:
    """Chunks as they are done, in whatever order.

    Parameters
    ----------
    task
        Work on each chunk; it is sent to the workers.
    cuts
        The chunks.
    workers
        As `propagate` takes it.
    start
        How processes are started, as `multiprocessing` calls it: ``"spawn"`` where this process has threads, which a
        copy of it would not; None for what is usual.
    here
        Number of chunks that this process computes itself while the worker processes start.

    Yields
    ------
    tuple
        A chunk and its result.

    Raises
    ------
    FrameError
        If the workers cannot be meant, or one of them came to an end.
    """
    if isinstance(workers, bool) or (isinstance(workers, int) and (workers == 0 or workers < -1)):
        raise FrameError(f"workers is {workers!r}: give their number, or -1 for all processors")
    told = _Told(task)
    if isinstance(workers, int):
        count = processors() if workers == -1 else workers
        if count == 1 or len(cuts) < 2:
            yield from map(told, cuts)
        else:
            with processes.processes(told, min(count, len(cuts)), start) as pool:
                here = min(here, len(cuts) - 1)
                yield from _by_executor(processes.of_this_process, cuts[here:], pool, count, map(told, cuts[:here]))
    elif hasattr(workers, "get_executor"):
        # the map of a dask Client returns futures, so its executor is used, which behaves like Python's
        with workers.get_executor() as executor:
            yield from _by_executor(told, cuts, executor, _threads(workers))
    elif isinstance(workers, Executor) or hasattr(workers, "submit"):
        yield from _by_executor(told, cuts, workers, getattr(workers, "_max_workers", None) or processors())
    elif callable(workers):
        yield from _by_map(told, cuts, workers)
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


def _by_executor(
    task: Callable[[C], tuple[C, R]],
    cuts: Sequence[C],
    executor: Executor,
    count: int,
    meanwhile: Iterable[tuple[C, R]] = (),
) -> Iterator[tuple[C, R]]:
    waiting: dict[Future[tuple[C, R]], int] = {}
    handed = 0
    try:
        while handed < len(cuts) or waiting:
            behind = min(waiting.values(), default=handed)
            while handed < len(cuts) and len(waiting) < AHEAD * count and handed - behind < APART * count:
                waiting[executor.submit(task, cuts[handed])] = handed
                handed += 1
            yield from meanwhile
            meanwhile = ()
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
    """Whether the error means that a worker was lost; dask raises it after several were lost to the same chunk."""
    return isinstance(error, BrokenExecutor) or any(kind.__name__ == "KilledWorker" for kind in type(error).__mro__)


def _by_map(
    task: Callable[[C], tuple[C, R]], cuts: Sequence[C], mapped: Callable[..., Iterable[tuple[C, R]]]
) -> Iterator[tuple[C, R]]:
    count = 0
    for found in mapped(task, cuts):
        if not isinstance(found, tuple):
            raise FrameError(
                f"workers {mapped!r} returned a {type(found).__name__} for a chunk: give a callable that returns the "
                "results as map does, or an executor"
            )
        count += 1
        yield found
    if count != len(cuts):
        raise FrameError(f"workers {mapped!r} returned {count} of {len(cuts)} chunks: give a callable like map")
