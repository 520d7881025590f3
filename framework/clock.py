"""Time taken by the stages of a solution, for `explain`, and progress of long ones, for a watcher."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from time import perf_counter

# Called with the number of batch entries solved so far.
Watcher = Callable[[int], None]
_watcher: ContextVar[Watcher | None] = ContextVar("watcher", default=None)


@contextmanager
def watched(by: Watcher) -> Iterator[None]:
    """Report the progress of a solution computed inside the context to `by`."""
    token = _watcher.set(by)
    try:
        yield
    finally:
        _watcher.reset(token)


def tell(solved: int) -> None:
    """Report to the watcher, if any, how many entries are solved."""
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
