"""The stages of a job: how far it is, and how long each took."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import perf_counter


class Stages:
    """The stages of a job: a progress bar on a terminal, and how long each took.

    Parameters
    ----------
    count
        Number of stages to come.
    """

    def __init__(self, count: int) -> None:
        from tqdm import tqdm

        self.bar = tqdm(total=count, disable=None, leave=False, bar_format="{desc:<20}{bar}| {elapsed}")
        self.seconds: dict[str, float] = {}

    @contextmanager
    def __call__(self, name: str) -> Iterator[None]:
        """Time the body as the stage `name`."""
        self.bar.set_description_str(name)
        start = perf_counter()
        yield
        self.seconds[name] = perf_counter() - start
        self.bar.update()

    @property
    def spent(self) -> str:
        """Time of the whole and of each stage, for a terminal."""
        split = ", ".join(f"{name} {seconds:.2f}" for name, seconds in self.seconds.items())
        return f"{sum(self.seconds.values()):.2f} s: {split}"
