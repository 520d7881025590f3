"""Samples taken some at a time: memory holds what is asked for, not what it is computed from."""

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
# Told the range of a part and its results as soon as they are put to the others, in their order.
Check = Callable[[slice, Mapping[str, Array]], None]

# Poses times samples that are computed at once: some 100 MB.
ENTRIES = 4096
# The first part is by so much smaller, and the next ones grow: so it soon shows how long the rest will take.
FIRST, GROWTH = 32, 4


@dataclass(frozen=True, eq=False)
class PartTask:
    """What is computed of a part: results by name, as arrays that any process or file can pass on.

    Attributes
    ----------
    make
        Makes an object with the results for some of the samples, as attributes or methods.
    names
        Which of them are wanted.
    axis
        That of the samples.
    greatest
        Results of which the greatest over the samples is wanted.
    counted
        Results that are counts of texts.
    several
        Whether there are other parts, before which memory is rid of what this one left.
    """

    make: Make
    names: tuple[str, ...]
    axis: int
    greatest: frozenset[str] = frozenset()
    counted: frozenset[str] = frozenset()
    several: bool = False

    def __call__(self, cut: slice) -> dict[str, Array]:
        """Results of some of the samples by name, as `Parts.put` takes them."""
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
            # A frame and its solution hold each other, with arrays whose size Python does not see.
            del part
            gc.collect()
        return found


class Parts:
    """Results of samples at all poses, computed some samples at a time where there are many.

    Parameters
    ----------
    make
        Makes an object with the results (..., poses, some samples, ...) for some of the samples, as attributes or
        methods. Other processes can call it if it can be pickled.
    shape
        Number of poses, and of samples; before them what else each result has.
    soon
        Whether the first part is a small one even if all would fit into one, as each takes long.
    greatest
        Results of which only the greatest over the samples is held, (..., poses, 1, ...).
    counted
        Results that are counts of texts, of which the sums are held.
    check
        Told of each part, in their order.
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
        # Of what is being computed, and how many parts are still to come.
        self._begun: dict[str, Array] = {}
        self._left = 0

    def __getitem__(self, name: str) -> Array:
        """A result by its name, (..., poses, n, ...)."""
        for _ in self.steps([name]):
            pass
        return self._known[name]

    def knows(self, name: str) -> bool:
        """Whether a result is there."""
        return name in self._known

    def taken(self, name: str) -> Array:
        """A result by its name, (..., poses, n, ...), which is not held any longer."""
        found = self[name]
        del self._known[name]
        return found

    def count(self, name: str) -> Counter[str]:
        """Counts of texts by the name of that result."""
        return _as_counter(self[name])

    def steps(self, names: Sequence[str]) -> Iterator[int]:
        """Compute results, and tell after each part how many poses times samples it had."""
        task = self.begin(names)
        if not task.names:
            return
        with sparing_what_is_there(task.several):
            for cut in self.cuts:
                self.put(cut, task(cut))
                yield self.size(cut)

    def size(self, cut: slice) -> int:
        """How many poses times samples a part has."""
        return int(self.shape[-2] * (cut.stop - cut.start))

    def begin(self, names: Sequence[str]) -> PartTask:
        """What is to be computed of each part for some results; those that are known already are left out."""
        wanted = tuple(name for name in names if name not in self._known)
        self._begun, self._left = {}, len(self.cuts)
        return PartTask(self.make, wanted, self._axis, self.greatest, self.counted, self._left > 1)

    def put(self, cut: slice, found: Mapping[str, Array]) -> None:
        """Put the results of the next part to those before it; after the last one they are known."""
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
        """Put the results of a part where they belong; what does not vary with the samples is held once."""
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
    """Counts of texts as an array that a file can hold."""
    longest = max(map(len, counts), default=1) or 1
    return np.array(list(counts.items()), dtype=[("text", f"U{longest}"), ("count", np.int64)])


def _as_counter(counts: Array) -> Counter[str]:
    return Counter(dict(counts.tolist()))


@contextmanager
def sparing_what_is_there(several: bool) -> Iterator[None]:
    """Let what is looked for after each part be sought among what it made, and not among all that was there before.

    To look through the modules alone takes longer than a part. Where there are not several parts, nothing is looked
    for.
    """
    if not several or gc.get_freeze_count():  # or somebody else does so
        yield
        return
    gc.collect()
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()


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
