"""Worker processes that compute chunks, started for a run and ended with it."""

from __future__ import annotations

import gc
import os
import pickle
import signal
from collections.abc import Callable, Iterator
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from multiprocessing import get_context, parent_process
from threading import Thread
from typing import Any, TypeVar

from ...framework.interrupts import put_off

C = TypeVar("C")

# The task of this process, if it is a worker: it is sent once, however many chunks there are.
_of_worker: list[Callable[[Any], Any]] = []


@contextmanager
def processes(task: Callable[[Any], Any], count: int, start: str | None) -> Iterator[Executor]:
    """A pool of worker processes, ended with the body of the ``with`` statement.

    Parameters
    ----------
    task
        Work on each chunk; it is sent to each process once.
    count
        Number of processes.
    start
        As for `computed`.
    """
    # pickled here, so that a task that cannot be sent raises its error instead of a pool that waits forever
    pool = _Pool(count, get_context(start), initializer=_begin, initargs=(pickle.dumps(task),))
    try:
        yield pool
    except BaseException:
        results = getattr(getattr(pool, "_result_queue", None), "_writer", None)
        for process in list((getattr(pool, "_processes", None) or {}).values()):
            process.terminate()
        pool.shutdown(wait=False, cancel_futures=True)
        # A worker that is ended half way through a result leaves the thread that reads it waiting for the rest, and
        # this process for the thread. Once nobody can write any longer there is no rest.
        if results is not None:
            results.close()
        raise
    pool.shutdown()


class _Pool(ProcessPoolExecutor):
    """Worker processes that ignore keyboard interrupts, which go to the whole process group.

    The process that hands out the chunks answers them.
    """

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        # a process started here inherits the blocked signals until it can ignore them by itself
        with put_off("SIGINT", "SIGHUP"):
            return super().submit(fn, *args, **kwargs)


def _begin(task: bytes) -> None:
    """Make this process a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    Thread(target=_end_with_parent, daemon=True).start()
    _of_worker[:] = [pickle.loads(task)]
    # objects that exist now stay, so that later collections need not examine them
    gc.collect()
    gc.freeze()


def _end_with_parent() -> None:
    """End this worker when its parent ends, which cannot do so itself if it is killed."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def of_this_process(cut: C) -> tuple[C, Any]:
    """Run this worker's task on a chunk."""
    found: tuple[C, Any] = _of_worker[0](cut)
    return found
