"""Division of a batch into chunks: what is computed once for the whole batch, and along which axis the rest is cut."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ..program.combination import BLOCK
from ..structure.parts import Grid
from .order import Order

# Batch entries in a chunk: enough to make the overhead of NumPy's calls small; fewer where the numbers held for a chunk
# would take more than ROOM bytes, but at least FEWEST.
CHUNK, ROOM, FEWEST = 2**14, 2**27, 2**11

# Numbers that vary over at most one in _SHARE of the batch entries, and over at most _MOST entries, are computed for
# the whole batch at once; so are all numbers of a batch of up to _SMALL entries.
_SHARE = 16
_MOST = 2**16
_SMALL = 2**10


def steps(grid: Grid, orders: Sequence[Order], chunk: int | None = None) -> tuple[int, int]:
    """The axis along which a batch is divided, and the number of its indices in a chunk of `chunk` entries."""
    shape = grid.shape
    if not shape:
        return 0, 1
    if chunk is None:
        chunk = int(np.clip(ROOM // (8 * max(1, storage(grid, orders))), FEWEST, CHUNK))
    # Chunks along the first axis are contiguous in memory; another is taken if one index of it holds too many entries.
    first = next((axis for axis, n in enumerate(shape) if n > 1), 0)
    axis = first if grid.sizes[-1] <= max(chunk, BLOCK) * shape[first] else int(np.argmax(shape))
    step = max(1, chunk * shape[axis] // max(1, grid.sizes[-1]))
    return axis, -(-step // BLOCK) * BLOCK if axis == len(shape) - 1 else step


def storage(grid: Grid, orders: Sequence[Order]) -> int:
    """Count of numbers that the elimination stores for each batch entry, without those computed for the whole batch."""
    large = large_masks(grid)
    return sum(len(order.below[k]) + 2 for order in orders for k in order.pivots if large[order.masks[k]])


def large_masks(grid: Grid) -> list[bool]:
    """For each mask, whether numbers that vary over it are left to the chunks: too many to be computed all at once."""
    whole = grid.sizes[-1]
    return [whole > _SMALL and size > 1 and (_SHARE * size > whole or size > _MOST) for size in grid.sizes]
