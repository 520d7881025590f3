"""Samples computed some at a time, so that memory holds the results but not all that they are computed from."""

from __future__ import annotations

import gc
from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Make = Callable[[slice], object]
# Called with the range and the results of each part, in order, as soon as they are stored.
Check = Callable[[slice, Mapping[str, Array]], None]

# Number of poses times samples that are computed together, in some 100 MB.
ENTRIES = 4096
# The first part is smaller by this factor, and each next one larger by this one, so that the time of the rest is soon
# known.
FIRST, GROWTH = 32, 4


@dataclass(frozen=True, eq=False)
class PartTask:
    """Computation of a part: results by name, as arrays that can be sent between processes and stored.

    Attributes
    ----------
    make
        Function of a range of samples that returns an object with their results, as attributes or methods.
    names
        Names of the results that are needed.
    axis
        Axis of the samples.
    greatest
        Results of which the largest over the samples is needed.
    counted
        Results that are counts of texts.
    several
        Whether there are other parts, before which the memory of this one is freed.
    """

    make: Make
    names: tuple[str, ...]
    axis: int
    greatest: frozenset[str] = frozenset()
    counted: frozenset[str] = frozenset()
    several: bool = False

    def __call__(self, cut: slice) -> dict[str, Array]:
        """Results of a range of samples by name, for `Parts.put`."""
        part, found = self.make(cut), dict[str, Array]()
        for name in self.names:
            value = getattr(part, name)
            value = value() if callable(value) else value
            if name in self.counted:
                value = _as_array(value)
            elif name in self.greatest:
                value = value.max(axis=self.axis, keepdims=True)
            found[name] = value
        if self.several:
            # a frame and its solution refer to each other, and Python does not see the size of their arrays
            del part
            gc.collect()
        return found


class Parts:
    """Results of samples at all poses, computed some samples at a time if there are many.

    Parameters
    ----------
    make
        Function of a range of samples that returns an object with their results (..., poses, samples, ...), as
        attributes or methods. Other processes can call it if it can be pickled.
    shape
        Shape of the results: further axes, the number of poses, and the number of samples.
    soon
        Whether the first part is small even if all samples would fit into one, as each takes long.
    greatest
        Results of which only the largest over the samples is kept, (..., poses, 1, ...).
    counted
        Results that are counts of texts, of which the sums are kept.
    check
        Called with each part, in order.
    """

    def __init__(
        self,
        make: Make,
        shape: tuple[int, ...],
        *,
        soon: bool = False,
        greatest: Collection[str] = (),
        counted: Collection[str] = (),
        check: Check | None = None,
    ) -> None:
        self.shape, self.greatest, self.counted = shape, frozenset(greatest), frozenset(counted)
        self.make, self.check = make, check
        self.cuts = cuts(*shape[-2:], soon=soon)
        self._known: dict[str, Array] = {}
        # results that are being computed, and the number of parts still to come
        self._begun: dict[str, Array] = {}
        self._left = 0

    def __getitem__(self, name: str) -> Array:
        """A result by its name, (..., poses, n, ...)."""
        for _ in self.steps([name]):
            pass
        return self._known[name]

    def knows(self, name: str) -> bool:
        """Whether a result is computed."""
        return name in self._known

    def taken(self, name: str) -> Array:
        """A result by its name, (..., poses, n, ...), which is removed from memory here."""
        found = self[name]
        del self._known[name]
        return found

    def count(self, name: str) -> Counter[str]:
        """Counts of texts, of the result with that name."""
        return _as_counter(self[name])

    def steps(self, names: Sequence[str]) -> Iterator[int]:
        """Compute results; yields the number of poses times samples of each part when it is done."""
        task = self.begin(names)
        if not task.names:
            return
        with sparing_what_is_there(task.several):
            for cut in self.cuts:
                self.put(cut, task(cut))
                yield self.size(cut)

    def size(self, cut: slice) -> int:
        """Number of poses times samples of a part."""
        return int(self.shape[-2] * (cut.stop - cut.start))

    def begin(self, names: Sequence[str]) -> PartTask:
        """Computation of each part for some results, without those that are known already."""
        wanted = tuple(name for name in names if name not in self._known)
        self._begun, self._left = {}, len(self.cuts)
        return PartTask(self.make, wanted, self._axis, self.greatest, self.counted, self._left > 1)

    def put(self, cut: slice, found: Mapping[str, Array]) -> None:
        """Store the results of the next part; after the last part they are known."""
        for name, values in found.items():
            self._put(name, cut, values)
        if self.check is not None:
            self.check(cut, found)
        self._left -= 1
        if not self._left:
            self._known |= {name: self._whole(name, values) for name, values in self._begun.items()}
            self._begun = {}

    @property
    def _axis(self) -> int:
        return len(self.shape) - 1

    def _whole(self, name: str, values: Array) -> Array:
        if name in self.counted:
            return values
        width = 1 if name in self.greatest else self.shape[-1]
        return np.broadcast_to(values, (*values.shape[: self._axis], width, *values.shape[self._axis + 1 :]))

    def _put(self, name: str, cut: slice, found: Array) -> None:
        """Store the results of a part; results that do not vary with the samples are stored once."""
        out, axis = self._begun, self._axis
        after = found.shape[axis + 1 :]
        once = *self.shape[:-1], 1, *after
        if name in self.counted:
            out[name] = _as_array(_as_counter(out[name]) + _as_counter(found)) if name in out else found
        elif name in self.greatest:
            most = np.broadcast_to(found, once)
            out[name] = np.maximum(out[name], most) if name in out else most
        elif found.shape[axis] == 1:
            out[name] = np.broadcast_to(found, once)
        else:
            if name not in out:
                out[name] = np.empty((*self.shape, *after), dtype=found.dtype)
            out[name][(slice(None),) * axis + (cut,)] = found


def _as_array(counts: Mapping[str, int]) -> Array:
    """Counts of texts as an array that can be stored in a file."""
    longest = max(map(len, counts), default=1) or 1
    return np.array(list(counts.items()), dtype=[("text", f"U{longest}"), ("count", np.int64)])


def _as_counter(counts: Array) -> Counter[str]:
    return Counter(dict(counts.tolist()))


@contextmanager
def sparing_what_is_there(several: bool) -> Iterator[None]:
    """Exclude all existing objects from the garbage collections after each part.

    Searching the modules alone takes longer than computing a part. With a single part there is no collection.
    """
    if not several or gc.get_freeze_count():  # or this is done by somebody else
        yield
        return
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


def one_by_one(parts: Sequence[slice]) -> Iterator[slice]:
    """The parts, with a garbage collection after each of several.

    A frame and its solution refer to each other, and Python does not see the size of their arrays.
    """
    for part in parts:
        yield part
        if len(parts) > 1:
            gc.collect()


def cuts(poses: int, samples: int, *, soon: bool = False) -> list[slice]:
    """Ranges of samples, none of a single sample, whose results would have no batch axis."""
    most = max(2, ENTRIES // max(poses, 1))
    if samples <= most and not soon:
        return [slice(0, samples)]
    # if samples take long, so does a part of few, which takes as many iterations as its slowest sample
    size, growth = (2, most) if soon else (max(2, most // FIRST), GROWTH)
    start, out = 0, []
    while start < samples:
        stop = start + size if samples - start - size >= 2 else samples
        out.append(slice(start, stop))
        start, size = stop, min(most, growth * size)
    return out
