"""Progress bar of a run: samples done, their rate, and the standard error so far."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from time import monotonic
from typing import Any, Protocol

import numpy as np

from ..moments import Moments

# Seconds after which the bar appears, and between updates of the standard error.
DELAY, BETWEEN = 1.0, 0.5


class HasMoments(Protocol):
    """An object with the moments of all samples so far."""

    @property
    def moments(self) -> Moments | None:
        """The moments; None if there are no samples."""


class SampleBar:
    """A progress bar, or none if it is not wanted or tqdm is not installed.

    Parameters
    ----------
    bar
        The bar of tqdm, or None.
    """

    def __init__(self, bar: Any) -> None:
        self._bar = bar
        self._next = monotonic() + DELAY

    def advance(self, count: int, gathered: HasMoments) -> None:
        """Count samples, and update the standard error of the mean from time to time."""
        if self._bar is None:
            return
        if monotonic() >= self._next:
            self._next = monotonic() + BETWEEN
            if gathered.moments is not None:
                self._bar.set_postfix_str(told(gathered.moments), refresh=False)
        self._bar.update(count)


def told(moments: Moments) -> str:
    """Text with the standard error, the largest one of several results."""
    error = np.asarray(moments.standard_error)
    known = error[np.isfinite(error)]
    if not known.size:
        return ""
    return f"standard error {'at most ' * (error.size > 1)}{known.max():.2g}"


@contextmanager
def sample_bar(n: int, progress: bool) -> Iterator[SampleBar]:
    """A bar over `n` samples."""
    if not progress:
        yield SampleBar(None)
        return
    try:
        from tqdm import tqdm
    except ImportError:
        yield SampleBar(None)
        return
    with tqdm(total=n, desc="samples", unit=" samples", delay=DELAY, leave=False) as bar:
        yield SampleBar(bar)
