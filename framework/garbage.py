"""Python's search for garbage, which pauses while much is made of which nothing is."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from contextlib import contextmanager


@contextmanager
def without_search() -> Iterator[None]:
    """Let what is made inside be made without a search for circles of references; also decorates a function.

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
