"""How a batch is cut: what is done once for all of it, and along which axis the rest is done in chunks."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..program.combination import BLOCK
from ..structure.parts import Grid
from .order import Order

# Batch entries handled at a time, as many as make the calls of NumPy cheap; fewer where all that is held for them would
# take more bytes than so many, but not less than the last number.
CHUNK, ROOM, FEWEST = 2**14, 2**27, 2**11

# What varies over less than this share of the batch, and over no more than so many entries, is done all at once; so is
# all of a small batch.
_SHARE = 16
_MOST = 2**16
_SMALL = 2**10


def steps(grid: Grid, orders: Sequence[Order], chunk: int | None = None) -> tuple[int, int]:
    """The axis along which a batch is cut, and how many of its indices make a `chunk`."""
    shape = grid.shape
    if not shape:
        return 0, 1
    if chunk is None:
        chunk = int(np.clip(ROOM // (8 * max(1, storage(grid, orders))), FEWEST, CHUNK))
    # Along the first axis chunks lie whole in memory, if its entries are not too large.
    first = next((axis for axis, n in enumerate(shape) if n > 1), 0)
    axis = first if grid.sizes[-1] <= max(chunk, BLOCK) * shape[first] else int(np.argmax(shape))
    step = max(1, chunk * shape[axis] // max(1, grid.sizes[-1]))
    return axis, -(-step // BLOCK) * BLOCK if axis == len(shape) - 1 else step


def storage(grid: Grid, orders: Sequence[Order]) -> int:
    """Numbers that an elimination holds for an entry of the batch, of those that are not shared."""
    large = large_masks(grid)
    return sum(len(order.below[k]) + 2 for order in orders for k in order.pivots if large[order.masks[k]])


def large_masks(grid: Grid) -> list[bool]:
    """By mask, whether what varies so is left to the chunks: most of the batch, or too much for the cache."""
    whole = grid.sizes[-1]
    return [whole > _SMALL and size > 1 and (_SHARE * size > whole or size > _MOST) for size in grid.sizes]
