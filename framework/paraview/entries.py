"""Choose what of a batch to show: one entry, or the entries along one axis."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..batch import Shape, one_entry
from ..errors import FrameError

Entry = int | Sequence[int]
Index = tuple[int | slice | None, ...]


def one(shape: Shape, entry: Entry | None, what: str) -> Index:
    """Index of one batch entry, as a batch of one.

    Parameters
    ----------
    shape
        Batch shape.
    entry
        Its indices; not needed where the batch holds one entry.
    what
        What will show it, for the error.
    """
    if entry is None and np.prod(shape) != 1:
        zeros = ", ".join("0" * len(shape)) + ("," if len(shape) == 1 else "")
        raise FrameError(
            f"{what} shows one pose but the batch shape is {shape}: save as .pvd for a series of poses, "
            f"or choose an entry with entry=({zeros})"
        )
    return (None, *_indices(shape, entry, what))


def series(shape: Shape, axis: int | None, entry: Entry | None, what: str) -> Index:
    """Index of the entries along `axis`, at `entry` of the other axes.

    Parameters
    ----------
    shape
        Batch shape.
    axis
        Batch axis; not needed where at most one is longer than 1.
    entry
        Indices into the other axes; not needed where these have size 1.
    what
        What will show them, for the error.
    """
    if not shape:
        return one(shape, entry, what)
    axis = _longest(shape, what) if axis is None else axis
    if axis not in range(-len(shape), len(shape)):
        raise FrameError(f"{what} was given axis={axis}, but the batch shape is {shape}: choose one of its axes")
    axis %= len(shape)
    others = shape[:axis] + shape[axis + 1 :]
    if entry is None and np.prod(others) != 1:
        raise FrameError(
            f"{what} shows the series along axis {axis} of the batch shape {shape}: "
            f"choose an entry of the other axes {others} with entry="
        )
    chosen = _indices(others, entry, what)
    return (*chosen[:axis], slice(None), *chosen[axis:])


def _longest(shape: Shape, what: str) -> int:
    if sum(n > 1 for n in shape) > 1:
        raise FrameError(
            f"{what} shows a series along one axis but the batch shape is {shape}: "
            "choose axis= for the series and entry= for the other axes"
        )
    return shape.index(max(shape))


def _indices(shape: Shape, entry: Entry | None, what: str) -> tuple[int, ...]:
    return (0,) * len(shape) if entry is None else one_entry(shape, entry, what)
