"""Processes that compute chunks, started for a run and ended with it."""

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

# What this process does with chunks, if it is a worker: sent to it once, however many chunks there are.
_of_worker: list[Callable[[Any], Any]] = []


@contextmanager
def processes(task: Callable[[Any], Any], count: int, start: str | None) -> Iterator[Executor]:
    """Processes that do a task, ended with the body.

    Parameters
    ----------
    task
        What they do with each chunk; it is sent to each of them once.
    count
        How many there are.
    start
        As for `computed`.
    """
    # What cannot be sent is told here, not by a pool that waits for ever.
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
    """Processes that an interrupt from the keyboard does not reach: it goes to the whole group, and who answers it is
    the process that hands out the chunks."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        # A process that is started meanwhile begins without interrupts, before it could ignore them by itself.
        with put_off("SIGINT", "SIGHUP"):
            return super().submit(fn, *args, **kwargs)


def _begin(task: bytes) -> None:
    """Make this process a worker."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    signal.signal(signal.SIGTERM, signal.SIG_DFL)
    Thread(target=_end_with_parent, daemon=True).start()
    _of_worker[:] = [pickle.loads(task)]
    # What is there now stays; a task that rids memory of what a chunk left need not look through it.
    gc.collect()
    gc.freeze()


def _end_with_parent() -> None:
    """A process that is killed cannot end its workers, which would wait for chunks for ever."""
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def of_this_process(cut: C) -> tuple[C, Any]:
    """What the task of this worker makes of a chunk."""
    found: tuple[C, Any] = _of_worker[0](cut)
    return found
