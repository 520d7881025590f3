"""Elements of many members described by one call: one element for each member, and groups that are checked together."""

from __future__ import annotations

from collections.abc import Hashable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, distinct
from ..errors import FrameError
from ..joint_protocol import JointElement
from ..protocol import LineElement, is_proven
from ..stacking import changed, unstacked


def alike(elements: Sequence[LineElement]) -> list[NDArray[np.int64]]:
    """Groups of members, as arrays of their numbers, whose elements can be stacked and checked in one call."""
    leaders, which = distinct(elements)
    found: dict[Hashable, int] = {}
    codes = []
    for number, k in enumerate(leaders):
        family = elements[k].family
        codes.append(found.setdefault((family, elements[k].shape) if family is not None else number, len(found)))
    code = np.array(codes, dtype=np.int64)[which]
    return np.split(np.argsort(code, kind="stable"), np.cumsum(np.bincount(code))[:-1])


def one_each(element: LineElement | JointElement, count: int) -> list[LineElement | JointElement]:
    """The element of each of `count` members, from one whose last batch axis runs over them; one element for all if it
    has no batch shape.
    """
    if not element.shape:
        return [element]
    if element.shape[-1] not in (1, count):
        text = f"(..., {count}) with one for each of them, or (..., 1)"
        raise FrameError(f"{type(element).__name__} for {count} members has batch shape {element.shape}: give {text}")
    if is_proven(element):
        return unstacked(element, count)

    def cut(k: int) -> LineElement | JointElement:
        def one(array: Array, trailing: int) -> Array:
            place = array.ndim - trailing - 1
            return array if place < 0 else np.take(array, k if array.shape[place] > 1 else 0, axis=place)

        found: LineElement | JointElement = changed(element, one)
        return found

    return [cut(k) for k in range(count)]
