"""Samples taken some at a time: memory holds what is asked for, not what it is computed from."""

from __future__ import annotations

import gc
from collections.abc import Callable, Collection, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Make = Callable[[slice], object]

# Poses times samples that are computed at once: some 100 MB.
ENTRIES = 4096
# The first part is by so much smaller, and the next ones grow: so it soon shows how long the rest will take.
FIRST, GROWTH = 32, 4


class Parts:
    """Results of samples at all poses, computed some samples at a time where there are many.

    Parameters
    ----------
    make
        Makes an object with the results (poses, some samples, ...) for some of the samples, as attributes or methods.
    shape
        Number of poses, and of samples.
    soon
        Whether the first part is a small one even if all would fit into one, as each takes long.
    greatest
        Results of which only the greatest over the samples is held, (poses, 1, ...).
    """

    def __init__(
        self, make: Make, shape: tuple[int, int], *, soon: bool = False, greatest: Collection[str] = ()
    ) -> None:
        self.shape, self.greatest = shape, greatest
        self.make = make
        self.cuts = cuts(*shape, soon=soon)
        self._known: dict[str, Array] = {}

    def __getitem__(self, name: str) -> Array:
        """A result by its name, (poses, n, ...)."""
        for _ in self.steps([name]):
            pass
        return self._known[name]

    def taken(self, name: str) -> Array:
        """A result by its name, (poses, n, ...), which is not held any longer."""
        found = self[name]
        del self._known[name]
        return found

    def steps(self, names: Sequence[str]) -> Iterator[int]:
        """Compute results, and tell after each part how many poses times samples it had."""
        wanted = [name for name in names if name not in self._known]
        if not wanted:
            return
        out: dict[str, Array] = {}
        for cut in one_by_one(self.cuts):
            part = self.make(cut)
            for name in wanted:
                found = getattr(part, name)
                self._put(out, name, cut, found() if callable(found) else found)
            yield self.shape[0] * (cut.stop - cut.start)
        for name, found in out.items():
            self._known[name] = np.broadcast_to(found, (len(found), self._width(name), *found.shape[2:]))

    def _width(self, name: str) -> int:
        return 1 if name in self.greatest else self.shape[1]

    def _put(self, out: dict[str, Array], name: str, cut: slice, found: Array) -> None:
        """Put the results of a part where they belong; what does not vary with the samples is held once."""
        after = found.shape[2:]
        if name in self.greatest:
            most = np.broadcast_to(found.max(axis=1, keepdims=True), (self.shape[0], 1, *after))
            out[name] = np.maximum(out[name], most) if name in out else most
        elif found.shape[1] == 1:
            out[name] = np.broadcast_to(found, (self.shape[0], 1, *after))
        else:
            if name not in out:
                out[name] = np.empty((*self.shape, *after), dtype=found.dtype)
            out[name][:, cut] = found


def one_by_one(parts: Sequence[slice]) -> Iterator[slice]:
    """The parts, and after each of several memory is rid of what it left.

    A frame and its solution hold each other, with arrays whose size Python does not see.
    """
    for part in parts:
        yield part
        if len(parts) > 1:
            gc.collect()


def cuts(poses: int, samples: int, *, soon: bool = False) -> list[slice]:
    """The samples in parts, none of a single one, whose results would not be held as a batch."""
    most = max(2, ENTRIES // max(poses, 1))
    if samples <= most and not soon:
        return [slice(0, samples)]
    # Where each takes long, so does a part of few: it takes as many iterations as its slowest sample.
    size, growth = (2, most) if soon else (max(2, most // FIRST), GROWTH)
    start, out = 0, []
    while start < samples:
        stop = start + size if samples - start - size >= 2 else samples
        out.append(slice(start, stop))
        start, size = stop, min(most, growth * size)
    return out
