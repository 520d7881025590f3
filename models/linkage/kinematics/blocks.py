"""Division of a batch into blocks whose intermediate arrays fit the cache."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence, Set
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Shape
from .terms import Value

Block = tuple[slice, ...]
# Members of a block: about a hundred intermediate arrays of this length fit the cache.
MEMBERS = 4096
_WHOLE = slice(None)


def shape_of(*groups: Sequence[Value]) -> Shape:
    """Shape to which all values of some groups broadcast."""
    return common({x.shape for values in groups for x in values if isinstance(x, np.ndarray)})


def common(shapes: Set[Shape]) -> Shape:
    """Shape to which all broadcast, which is mostly the only one."""
    return next(iter(shapes)) if len(shapes) == 1 else np.broadcast_shapes(*shapes)


def blocks(shape: Shape, members: int = MEMBERS) -> Iterator[Block]:
    """Index ranges that cover an array of `shape`, each of at most about `members` entries."""
    whole, axis = 1, len(shape)
    while axis > 0 and whole * shape[axis - 1] <= members:
        axis -= 1
        whole *= shape[axis]
    if axis == 0:
        yield (_WHOLE,) * len(shape)
        return
    step = max(1, members // whole)
    ranges = [[slice(i, i + 1) for i in range(size)] for size in shape[: axis - 1]]
    ranges.append([slice(i, min(i + step, shape[axis - 1])) for i in range(0, shape[axis - 1], step)])
    for chosen in product(*ranges):
        yield (*chosen, *(_WHOLE,) * (len(shape) - axis))


def parts(shape: Shape, members: int = 4 * MEMBERS) -> Iterator[tuple[Block, int, slice]]:
    """Index ranges along the longest axis, each of about `members` entries; with the axis, and the range along it."""
    axis = int(np.argmax(shape))
    step = max(1, members * shape[axis] // max(1, math.prod(shape)))
    for start in range(0, shape[axis], step):
        chosen = slice(start, min(start + step, shape[axis]))
        yield (*(slice(None),) * axis, chosen), axis, chosen


def cut(value: Value, block: Block) -> Value:
    """The part of a value, which broadcasts with the batch, that belongs to a block."""
    if not isinstance(value, np.ndarray) or value.ndim == 0:
        return value
    chosen = block[len(block) - value.ndim :]
    return np.asarray(value[tuple(slice(None) if n == 1 else c for n, c in zip(value.shape, chosen, strict=True))])


def cut_all(values: Sequence[Value], block: Block) -> list[Value]:
    """`cut` of each value; the values themselves where the block is the whole batch."""
    return list(values) if block.count(_WHOLE) == len(block) else [cut(value, block) for value in values]


def taken(values: Sequence[Value], chosen: NDArray[np.intp] | NDArray[np.bool_] | slice) -> list[Value]:
    """The `chosen` members of values (members,); scalars are returned as they are."""
    return [x[chosen] if isinstance(x, np.ndarray) and x.ndim else x for x in values]


def members_of(values: Sequence[Value], chosen: NDArray[np.bool_]) -> list[Value]:
    """The `chosen` members of values that broadcast to the mask's shape, (members,); scalars are kept."""
    return [np.broadcast_to(x, chosen.shape)[chosen] if isinstance(x, np.ndarray) and x.ndim else x for x in values]
