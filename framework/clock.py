"""Time that the stages of a solution take, for `explain`; and how far a long one is, for who watches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from time import perf_counter

# Told how many entries of a batch are solved.
Watcher = Callable[[int], None]
_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(by: Watcher) -> Iterator[None]:
    """Let `by` know how far a long solution is that is computed inside."""
    token = _watcher.set(by)
    try:
        yield
    finally:
        _watcher.reset(token)


def tell(solved: int) -> None:
    """Tell who watches how many entries are solved."""
    watcher = _watcher.get()
    if watcher is not None:
        watcher(solved)


@contextmanager
def timed(times: dict[str, float], stage: str) -> Iterator[None]:
    """Add the seconds spent inside to ``times[stage]``."""
    begin = perf_counter()
    try:
        yield
    finally:
        times[stage] = times.get(stage, 0.0) + perf_counter() - begin
