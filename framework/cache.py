"""All caches of the library in one place, so that descriptions and results hold nothing of them.

Data that depend on structure alone, such as an order of elimination, are cached by content, and the least recently used
are dropped (`Bounded`). Data with numbers, such as a factor, are kept as long as the description lives for which they
were computed, and compared with it before reuse (`LimitedCache`). Both are thread-safe; neither is copied or pickled:
copies arrive empty.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Callable, Hashable
from dataclasses import fields, is_dataclass
from functools import cache
from operator import is_
from threading import RLock
from typing import Any, Generic, TypeVar
from weakref import WeakKeyDictionary

import numpy as np

Key = TypeVar("Key", bound=Hashable)
Kept = TypeVar("Kept")

# Descriptions of which something is kept at a time.
_OWNERS = 256
# The package whose dataclasses hold nothing but their fields.
_OWN = __name__.rpartition("framework")[0]


class Bounded(Generic[Key, Kept]):
    """A cache by content of limited weight; the least recently used values are dropped.

    Parameters
    ----------
    room
        Greatest total weight of the values.
    """

    def __init__(self, room: int) -> None:
        self.room = room
        self._values: OrderedDict[Key, tuple[Kept, int]] = OrderedDict()
        self._weight = 0
        self._lock = RLock()

    def found(self, key: Key, make: Callable[[], Kept], weight: int | Callable[[Kept], int] = 1) -> Kept:
        """The value of a key, made where there is none.

        Parameters
        ----------
        key
            All that the value depends on.
        make
            Makes the value. Two threads may both make it; one of the two is kept.
        weight
            Weight of the value, or a function of the value that returns it; heavier values than `room` are not kept.
        """
        with self._lock:
            kept = self._values.get(key)
            if kept is not None:
                self._values.move_to_end(key)
                return kept[0]
        made = make()
        heavy = weight if isinstance(weight, int) else weight(made)
        with self._lock:
            if key not in self._values:
                self._values[key] = made, heavy
                self._weight += heavy
            made = self._values[key][0]
            while self._weight > self.room:
                self._weight -= self._values.popitem(last=False)[1][1]
        return made

    def __len__(self) -> int:
        return len(self._values)

    def clear(self) -> None:
        """Drop all values."""
        with self._lock:
            self._values.clear()
            self._weight = 0

    def __reduce__(self) -> tuple[type[Bounded[Key, Kept]], tuple[int]]:
        return type(self), (self.room,)


class LimitedCache(Generic[Kept]):
    """The last value of each living owner, for a limited number of the last owners."""

    def __init__(self) -> None:
        self._values: WeakKeyDictionary[object, Kept] = WeakKeyDictionary()
        self._lock = RLock()

    def get(self, owner: object) -> Kept | None:
        """The value kept for an owner; None without one."""
        with self._lock:
            return self._values.get(owner)

    def put(self, owner: object, value: Kept) -> None:
        """Keep a value for as long as its owner lives."""
        with self._lock:
            if self._values.pop(owner, None) is None:
                while len(self._values) >= _OWNERS:
                    oldest = next(iter(self._values), None)
                    self._values.pop(oldest, None)
            self._values[owner] = value

    def drop(self, owner: object) -> None:
        """Drop the value kept for an owner."""
        with self._lock:
            self._values.pop(owner, None)

    def __len__(self) -> int:
        return len(self._values)

    def __reduce__(self) -> tuple[type[LimitedCache[Kept]], tuple[()]]:
        return type(self), ()


def alike(one: Any, other: Any) -> bool:
    """Whether two values are the same object, or arrays, frozen dataclasses or dicts of equal numbers.

    Of other objects, such as a user's own element, only the object itself is known to be the same.

    Parameters
    ----------
    one, other
        The values.
    """
    if one is other:
        return True
    kind = type(one)
    if kind is not type(other):
        return False
    if kind is dict:
        if [*one] != [*other]:
            return False
        # most are the same objects, which takes no call of Python to see
        each = one.values(), other.values()
        return all(map(is_, *each)) or all(alike(a, b) for a, b in zip(*each, strict=True) if a is not b)
    if issubclass(kind, (list, tuple)):
        return len(one) == len(other) and (all(map(is_, one, other)) or all(map(alike, one, other)))
    if issubclass(kind, np.ndarray):
        return one.shape == other.shape and one.dtype == other.dtype and bool(one.tobytes() == other.tobytes())
    if issubclass(kind, (bool, int, float, str)):
        return bool(one == other)
    names = _fields(kind)  # type: ignore[arg-type]
    return names is not None and all(alike(getattr(one, name), getattr(other, name)) for name in names)


@cache
def _fields(kind: type) -> tuple[str, ...] | None:
    """Names of the fields of a dataclass of this package; None of other classes."""
    own = is_dataclass(kind) and kind.__module__.startswith(_OWN)
    return tuple(each.name for each in fields(kind)) if own else None


# Orders of elimination, by the pattern of what is eliminated; they weigh as many as that has entries.
ORDERS: Bounded[tuple[object, ...], Any] = Bounded(2**19)
# Patterns of graphs and matrices, by the numbers of what is coupled; they weigh as many.
PATTERNS: Bounded[tuple[object, ...], Any] = Bounded(2**20)
# Terms of the equations of batches, by what their members, joints and loads act on; they weigh as many numbers.
TERMS: Bounded[tuple[object, ...], Any] = Bounded(2**22)
# Operations of an elimination, by what is eliminated; they weigh as many as they are.
PROGRAMS: Bounded[tuple[object, ...], Any] = Bounded(2**19)
# What programs are compiled to, by their steps; they weigh as many.
KERNELS: Bounded[tuple[object, ...], Any] = Bounded(2**18)
# What is made of the formulas of a linkage, by its joints and by which of its dimensions are 0 or 1; they weigh as many
# as it has joints.
FORMULAS: Bounded[tuple[object, ...], Any] = Bounded(2**10)
# Matrices of members on a body, by element and chord in the axes of the body; they weigh as many as they have entries.
STACKS: Bounded[tuple[object, ...], Any] = Bounded(2**20)
# Of a frame its plan and factors; of a linkage its mechanism, and the inertia of its links. None of them refers to the
# description that it is kept for, which would then never go.
SOLVED: LimitedCache[Any] = LimitedCache()
# Of a frame with clearances the same with unit offsets in its joints.
OFFSET: LimitedCache[Any] = LimitedCache()
COMPILED: LimitedCache[Any] = LimitedCache()
INERTIAS: LimitedCache[Any] = LimitedCache()
