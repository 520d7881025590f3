"""Pausing Python's garbage collection while many lasting objects are made."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_search() -> Iterator[None]:
    """Pause garbage collection in the context; also decorates a function.

    Every so many objects Python searches all those that it has made. Where many are made one after the other, and all
    of them stay, that takes as long as to make them.
    """
    searching = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if searching:
            gc.enable()


@contextmanager
def lasting(*, alone: bool) -> Iterator[None]:
    """Pause garbage collection in the context, as what is loaded and made there stays.

    Parameters
    ----------
    alone
        Whether it stays to the end of the process: then no later search goes through it, or anything older, again.
    """
    with without_search():
        yield
        if alone:
            gc.freeze()
