"""The stages of a job, with their progress and times."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from threading import Event, Thread
from time import perf_counter
from typing import TYPE_CHECKING, NoReturn, Self

from ...framework.clock import watched

if TYPE_CHECKING:
    from tqdm import tqdm

# Without a terminal: seconds before the first line on the progress, which must also be left to be done; time between
# two lines as a share of the time so far; and largest such time, seconds.
FIRST, SHARE, SELDOM = 1.0, 0.5, 30.0
# Longest time that the first line waits for an estimate, and time between two looks for it, seconds.
WAIT, MOMENT = 3.0, 0.05

# Called with the name of a kind of work, and the amount that was done of it.
Advance = Callable[[str, int], None]


class Stages:
    """The stages of a job, with their progress, as a bar on a terminal and as lines elsewhere, and their times.

    Parameters
    ----------
    count
        Number of stages to come.
    begun
        Start of the program on the clock of `perf_counter`; the time since then is the stage "start". None if it is not
        known.
    """

    def __init__(self, count: int, begun: float | None = None) -> None:
        self.watched = sys.stderr.isatty()
        self.bar: tqdm[NoReturn] | None = None
        if self.watched:
            from tqdm import tqdm

            self.bar = tqdm(total=count, leave=False, bar_format="{desc:<20}{bar}| {elapsed}")
        self.seconds: dict[str, float] = {} if begun is None else {"start": perf_counter() - begun}

    @contextmanager
    def __call__(self, name: str, work: Mapping[str, int] | None = None) -> Iterator[Advance]:
        """Time the body as the stage `name`, and show its progress if it takes long.

        Parameters
        ----------
        name
            Name of the stage.
        work
            Amount of work, by kind. The body calls the yielded function with the amounts done, and with 0 when it
            starts a part; parts that it did not start were done by an earlier run, whose time is not known.
        """
        if self.bar is not None:
            self.bar.set_description_str(name)
        start, progress = perf_counter(), Progress(work or {})
        with self._shown(name, progress) as advance, watched(progress.inside):
            yield advance
        self.seconds[name] = perf_counter() - start
        if self.bar is not None:
            self.bar.update()

    @contextmanager
    def _shown(self, name: str, progress: Progress) -> Iterator[Advance]:
        if not self.watched:
            with Lines(name, progress):
                yield progress.count
        elif not progress.total:
            yield progress.count
        else:
            from tqdm import tqdm

            form = "{desc:<20}{bar}| {n_fmt}/{total_fmt} {elapsed}{postfix}"
            with tqdm(total=sum(progress.total.values()), leave=False, unit_scale=True, bar_format=form) as bar:

                def advance(what: str, more: int) -> None:
                    progress.count(what, more)
                    bar.set_postfix_str(progress.estimate, refresh=False)
                    bar.update(more)

                yield advance

    def close(self) -> None:
        """Clear the terminal."""
        if self.bar is not None:
            self.bar.close()

    @property
    def spent(self) -> str:
        """Total time and that of each stage, for a terminal."""
        split = ", ".join(f"{name} {seconds:.2f}" for name, seconds in self.seconds.items())
        return f"{sum(self.seconds.values()):.2f} s: {split}"


class Progress:
    """Progress of several kinds of work that take different times, with an estimate of the remaining time.

    Parameters
    ----------
    total
        Amount of work, by kind.
    """

    def __init__(self, total: Mapping[str, int]) -> None:
        self.total = {what: count for what, count in total.items() if count}
        self.done = dict.fromkeys(self.total, 0)
        self._parts: dict[str, list[tuple[int, float]]] = {what: [] for what in self.total}
        self._last = perf_counter()
        # the kind that is being done, and the amount of its part that is done already
        self._doing: str | None = None
        self._inside = 0

    def inside(self, solved: int) -> None:
        """Note the amount that is done of the part that is being computed."""
        self._inside = max(solved, self._inside)

    def count(self, what: str, more: int) -> None:
        """Count the amount done since the part started; 0 starts a part."""
        now, begun = perf_counter(), self._doing == what
        if more:
            self.done[what] += more
            if begun:
                self._parts[what].append((more, now - self._last))
        self._last, self._doing, self._inside = now, None if more else what, 0

    @property
    def left(self) -> float | None:
        """Estimated time of the rest, seconds; None as long as some kind has no estimate."""
        rests = [self._rest(what) for what in self.total]
        return None if None in rests else sum(filter(None, rests))

    def _rest(self, what: str) -> float | None:
        # the first part includes the time to set up, which must not count for the others
        parts = self._parts[what][1:] or self._parts[what]
        done, seconds = sum(more for more, _ in parts), sum(each for _, each in parts)
        whole = self.done[what]
        if what == self._doing and self._inside:
            done, seconds = done + self._inside, seconds + perf_counter() - self._last
            whole += self._inside
        return seconds / done * max(self.total[what] - whole, 0) if done else None

    @property
    def estimate(self) -> str:
        """`left` in words."""
        left = self.left
        return "no estimate yet" if left is None else f"about {left:.0f} s to go"

    def __str__(self) -> str:
        return ", ".join(f"{self.done[what]} of {total} {what}" for what, total in self.total.items())


class Lines:
    """Progress of a long stage, in lines on the standard error.

    Parameters
    ----------
    name
        Name of the stage.
    progress
        Its progress; without any work the lines only have the time so far.
    """

    def __init__(self, name: str, progress: Progress) -> None:
        self.name, self.progress = name, progress
        self.start, self.ended = perf_counter(), Event()
        # a thread, as a part may take longer than the time between two lines
        self.thread = Thread(target=self._tell, daemon=True)

    def __enter__(self) -> Self:
        self.thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        self.ended.set()
        self.thread.join()

    def _tell(self) -> None:
        pause = FIRST
        while not self.ended.wait(pause):
            spent = perf_counter() - self.start
            left = self.progress.left if self.progress.total else None
            if left is None and self.progress.total and spent < WAIT:
                # the first line comes with an estimate, if it is soon there
                pause = MOMENT
                continue
            pause = min(max(FIRST, SHARE * spent), SELDOM)
            if left is None or left > FIRST:
                # the standard error may be closed
                with suppress(OSError, ValueError):
                    print(self._line(spent), file=sys.stderr, flush=True)

    def _line(self, spent: float) -> str:
        if not self.progress.total:
            return f"{self.name}: {spent:.0f} s so far"
        return f"{self.name}: {self.progress} after {spent:.0f} s, {self.progress.estimate}"
