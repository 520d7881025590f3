"""The stages of a job: how far it is, and how long each took."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from threading import Event, Thread
from time import perf_counter
from typing import Self

# Seconds of work before a job that nobody watches on a terminal says how far it is; and between two such lines a share
# of what it has taken, up to this.
FIRST, SHARE, SELDOM = 1.0, 0.5, 30.0

Advance = Callable[[int], None]


class Stages:
    """The stages of a job: how far it is, as a bar on a terminal and as lines elsewhere, and how long each took.

    Parameters
    ----------
    count
        Number of stages to come.
    """

    def __init__(self, count: int) -> None:
        from tqdm import tqdm

        self.watched = sys.stderr.isatty()
        self.bar = tqdm(total=count, disable=not self.watched, leave=False, bar_format="{desc:<20}{bar}| {elapsed}")
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body as the stage `name`."""
        self.bar.set_description_str(name)
        start = perf_counter()
        yield
        self.seconds[name] = perf_counter() - start
        self.bar.update()

    @contextmanager
    def progress(self, what: str, total: int) -> Iterator[Advance]:
        """Lend what is told how much more is done, and tells how far the body is and how long it will take.

        Parameters
        ----------
        what
            What is counted.
        total
            How many there are.
        """
        from tqdm import tqdm

        if self.watched:
            with tqdm(total=total, desc=what, leave=False, unit_scale=True) as bar:
                yield lambda more: void(bar.update(more))
        else:
            with Lines(what, total) as lines:
                yield lines.count

    def close(self) -> None:
        """Clear the terminal."""
        self.bar.close()

    @property
    def spent(self) -> str:
        """Time of the whole and of each stage, for a terminal."""
        split = ", ".join(f"{name} {seconds:.2f}" for name, seconds in self.seconds.items())
        return f"{sum(self.seconds.values()):.2f} s: {split}"


class Lines:
    """How far a long loop is, in lines on the standard error; nothing of what is done at once.

    Parameters
    ----------
    what, total
        What is counted, and how many there are.
    """

    def __init__(self, what: str, total: int) -> None:
        self.what, self.total, self.done = what, total, 0
        self.start, self.ended = perf_counter(), Event()
        # A part may take long, and is told of all the same.
        self.thread = Thread(target=self._tell, daemon=True)

    def __enter__(self) -> Self:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        self.thread.join()

    def count(self, more: int) -> None:
        """Count what has been done."""
        self.done += more

    def _tell(self) -> None:
        pause = FIRST
        while not self.ended.wait(pause):
            spent = perf_counter() - self.start
            pause = min(max(FIRST, SHARE * spent), SELDOM)
            # Who does not listen is not told.
            with suppress(OSError, ValueError):
                print(self._line(spent), file=sys.stderr, flush=True)

    def _line(self, spent: float) -> str:
        told = "no estimate yet"
        if self.done:
            told = f"about {spent * (self.total - self.done) / self.done:.0f} s to go"
        return f"{self.done} of {self.total} {self.what} after {spent:.0f} s, {told}"


def void(_: object) -> None:
    """Nothing."""
