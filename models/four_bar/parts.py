"""Samples taken some at a time: memory holds what is asked for, not what it is computed from."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from .accuracy import Accuracy

Array = NDArray[np.float64]
Make = Callable[[slice], Accuracy]

# Poses times samples that are computed at once: some 100 MB.
ENTRIES = 4096
# The first part is by so much smaller, and the next ones grow: so it soon shows how long the rest will take.
FIRST, GROWTH = 32, 4


class Parts:
    """Results of samples at all poses, computed some samples at a time where there are many.

    Parameters
    ----------
    make
        Makes the accuracy (poses, some samples) for some of the samples.
    shape
        Number of poses, and of samples.
    soon
        Whether parts begin small even if all would fit into one, as each takes long.
    """

    def __init__(self, make: Make, shape: tuple[int, int], *, soon: bool = False) -> None:
        self.whole, self.shape = make(slice(None)), shape
        self._make = make
        self.cuts = cuts(*shape, soon=soon)
        self._known: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        """A result of `Accuracy` by its name, (poses, n, ...)."""
        for _ in self.steps([name]):
            pass
        return self._known[name]

    def steps(self, names: Sequence[str]) -> Iterator[int]:
        """Compute results, and tell after each part how many poses times samples it had."""
        wanted = [name for name in names if name not in self._known]
        if not wanted:
            return
        out: dict[str, Array] = {}
        for cut in self.cuts:
            size = cut.stop - cut.start
            part = self.whole if len(self.cuts) == 1 else self._make(cut)
            for name in wanted:
                found = getattr(part, name)
                found = found() if callable(found) else found
                if name not in out:
                    out[name] = np.empty((*self.shape, *found.shape[2:]), dtype=found.dtype)
                out[name][:, cut] = np.broadcast_to(found, (self.shape[0], size, *found.shape[2:]))
            yield self.shape[0] * size
        self._known |= out


def cuts(poses: int, samples: int, *, soon: bool = False) -> list[slice]:
    """The samples in parts, none of a single one, whose results would not be held as a batch."""
    most = max(2, ENTRIES // max(poses, 1))
    if samples <= most and not soon:
        return [slice(0, samples)]
    size, start, out = max(2, most // FIRST), 0, []
    while start < samples:
        stop = start + size if samples - start - size >= 2 else samples
        out.append(slice(start, stop))
        start, size = stop, min(most, GROWTH * size)
    return out
