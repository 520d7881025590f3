"""Time that the stages of a solution take, for `explain`; and how far a long one is, for who watches."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
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


@dataclass(slots=True)
class timed:
    """Adds the seconds spent inside to ``times[stage]``."""

    times: dict[str, float]
    stage: str
    begin: float = 0.0

    def __enter__(self) -> None:
        self.begin = perf_counter()

    def __exit__(self, *_: object) -> None:
        self.times[self.stage] = self.times.get(self.stage, 0.0) + perf_counter() - self.begin
