"""Dataclasses whose arrays have batch axes: selected at entries, stacked into one, and taken apart again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import fields, is_dataclass
from functools import cache
from itertools import repeat
from operator import attrgetter, is_
from typing import Any, TypeVar

import numpy as np

from .batch import aligned
from .entries import Change
from .errors import FrameError

_Stacked = TypeVar("_Stacked")
_WITHOUT_ARRAYS = {float, int, bool, str, type(None)}


def changed(described: Any, change: Change) -> Any:
    """A dataclass with its arrays changed, and those of the dataclasses in it; its numbers are not checked again."""
    if not is_dataclass(described):
        kind = type(described).__name__
        text = "make it one, or give it its own method cut(change)"
        raise FrameError(f"{kind} holds a batch but is no dataclass: {text}")
    clone = object.__new__(type(described))
    for name, trailing in _numbers(type(described)):  # type: ignore[arg-type]
        value = getattr(described, name)
        if isinstance(value, np.ndarray):
            value = change(value, trailing)
        elif type(value) in _WITHOUT_ARRAYS:
            pass
        elif hasattr(value, "cut"):
            value = value.cut(change)
        elif is_dataclass(value):
            value = changed(value, change)
        object.__setattr__(clone, name, value)
    return clone


def stacked(elements: Sequence[_Stacked], ndim: int) -> _Stacked:
    """Dataclasses of one family as one, each number that differs an array (n, ...) with `ndim` batch axes behind."""
    kind = type(elements[0])
    clone = object.__new__(kind)
    for name, trailing in _numbers(kind):  # type: ignore[arg-type]
        values = list(map(attrgetter(name), elements))
        one = values[0]
        # most fields hold one and the same object for all elements: comparing identities is enough, and quick
        together = one if all(map(is_, values, repeat(one))) else _together(values, ndim, trailing)
        object.__setattr__(clone, name, together)
    return clone


@cache
def _numbers(kind: type) -> list[tuple[str, int]]:
    """Names of the fields of a dataclass, and how many axes behind the batch each has."""
    return [(each.name, each.metadata.get("trailing", 0)) for each in fields(kind)]


def _together(values: list[Any], ndim: int, trailing: int) -> Any:
    one = values[0]
    if is_dataclass(one):
        return stacked(values, ndim)
    if set(map(type, values)) == {float}:
        return one if len(set(values)) == 1 else np.array(values).reshape(-1, *(1,) * ndim)
    if type(one) is np.ndarray and one.ndim == ndim + trailing and all(_alike(each, one) for each in values):
        return np.array(values)  # in a fifth of the time of what follows
    if isinstance(one, (float, np.ndarray)):
        arrays = [aligned(np.asarray(value), ndim, trailing) for value in values]
        return np.stack(np.broadcast_arrays(*arrays))
    return one  # names, switches and counts, which a family has in common or does not look at


def _alike(value: Any, one: np.ndarray[Any, Any]) -> bool:
    """Whether a value is an array of floats of the shape of another one."""
    return type(value) is np.ndarray and value.shape == one.shape and value.dtype == one.dtype


def unstacked(element: Any, count: int) -> list[Any]:
    """A dataclass whose arrays have so many entries, or one, along their last batch axis as that many, one for each."""
    names, columns = [], []
    for each in fields(element):
        names.append(each.name)
        columns.append(_apart(getattr(element, each.name), count, each.metadata.get("trailing", 0)))
    out = []
    for values in zip(*columns, strict=True):
        clone = object.__new__(type(element))
        vars(clone).update(zip(names, values, strict=True))
        out.append(clone)
    return out


def _apart(value: Any, count: int, trailing: int) -> Iterable[Any]:
    if is_dataclass(value):
        return unstacked(value, count) if getattr(value, "shape", ()) else repeat(value, count)
    if not isinstance(value, np.ndarray) or value.ndim <= trailing:
        return repeat(value, count)
    entries = np.moveaxis(value, value.ndim - trailing - 1, 0)
    if len(entries) == 1:
        return repeat(_plain(entries[0]), count)
    return entries.tolist() if entries.ndim == 1 else list(entries)


def _plain(value: Any) -> Any:
    return value if np.ndim(value) else float(value)
