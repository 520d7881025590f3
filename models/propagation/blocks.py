"""Statistics of samples by blocks, so that they do not depend on the chunk in which the samples came."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..moments import SUMS, Moments
from ..sampling import BLOCK

Array = NDArray[np.float64]
# Blocks, rows of samples, and these samples (rows, blocks, samples of a block).
Tile = tuple[slice, slice, Array]

# Blocks of a row of samples that are worked on at once: with two arrays like them they fit into the processor's cache.
TILE = 64
# Sets of samples that are pooled at a time.
POOL = 16
_own = threading.local()


@dataclass(frozen=True, eq=False)
class BlockStatistics:
    """Statistics of the samples of a chunk.

    Parameters
    ----------
    moments
        Of each of the b blocks of samples, (b, ...).
    replicated
        Of each block by replicate, (b, r, ...); None where there is one replicate.
    least, greatest
        Extremes of all samples, (...).
    """

    moments: Moments
    replicated: Moments | None
    least: Array
    greatest: Array

    @classmethod
    def of(cls, results: Array, nan_policy: str, replicates: int = 1) -> BlockStatistics:
        """Of samples (m, ...), wherever they lie in memory."""
        # Entries in the order in which they lie there can be seen as rows of samples without a copy.
        order = sorted(range(1, results.ndim), key=lambda axis: -abs(results.strides[axis]))
        shape = [results.shape[axis] for axis in order]
        entries = math.prod(shape)
        lower, upper = (np.fmin, np.fmax) if nan_policy == "omit" else (np.minimum, np.maximum)
        blocks = -(-len(results) // BLOCK)
        found = np.empty((7, blocks, entries))
        by_replicate = np.empty((5, blocks, replicates if replicates > 1 else 0, entries))
        laid, *rooms = _own_memory()
        for which, where, tile in _tiles(results.transpose((*order, 0)), entries, laid):
            off, square = (room[: tile.size].reshape(tile.shape) for room in rooms)
            found[0, which, where] = lower.reduce(tile, axis=-1).T
            found[1, which, where] = upper.reduce(tile, axis=-1).T
            found[2:, which, where] = _numbers(Moments.of_rows(tile, nan_policy, (off, square))).swapaxes(1, 2)
            if replicates > 1:
                turns = tile.reshape(*tile.shape[:-1], -1, replicates).swapaxes(-1, -2)
                each = Moments.of_rows(np.ascontiguousarray(turns), nan_policy)
                by_replicate[:, which, :, where] = np.moveaxis(_numbers(each), 1, -1)
        least, greatest = lower.reduce(found[0], axis=0), upper.reduce(found[1], axis=0)
        places = [order.index(axis) for axis in range(1, results.ndim)]

        def back(array: Array) -> Array:
            """Rows (..., rows) as entries of the results."""
            lead = array.ndim - 1
            apart = array.reshape((*array.shape[:-1], *shape))
            return apart.transpose((*range(lead), *(lead + place for place in places)))

        replicated = _moments(back(by_replicate)) if replicates > 1 else None
        return cls(_moments(back(found[2:])), replicated, back(least)[()], back(greatest)[()])


def _numbers(moments: Moments) -> Array:
    """Number of samples, mean and sums, (5, ...)."""
    n = np.broadcast_to(moments.n, np.shape(moments.mean))
    return np.array([n, *(getattr(moments, key) for key in SUMS)])


def _moments(numbers: Array) -> Moments:
    return Moments(numbers[0].astype(np.int64), *numbers[1:])


def _own_memory() -> tuple[Array, Array, Array]:
    """Three arrays for a tile each, the thread's own: memory that is new for each chunk costs more than its sums."""
    if not hasattr(_own, "memory"):
        _own.memory = np.empty(TILE * BLOCK), np.empty(TILE * BLOCK), np.empty(TILE * BLOCK)
    found: tuple[Array, Array, Array] = _own.memory
    return found


def _tiles(samples: Array, entries: int, room: Array) -> Iterator[Tile]:
    """Samples (..., m) in contiguous pieces that fit into the cache, each to be used before the next one."""
    m = samples.shape[-1]
    rows = samples[..., :1].reshape(entries, 1)
    if np.may_share_memory(rows, samples):
        yield from _tiles_of_rows(samples.reshape(entries, m), 0, room)
        return
    # Entries that cannot be seen as rows are laid out block by block.
    laid = np.empty((*samples.shape[:-1], BLOCK))
    for block, start in enumerate(range(0, m, BLOCK)):
        size = min(BLOCK, m - start)
        laid[..., :size] = samples[..., start : start + size]
        yield from _tiles_of_rows(laid.reshape(entries, BLOCK)[:, :size], block, room)


def _tiles_of_rows(rows: Array, block: int, room: Array) -> Iterator[Tile]:
    """Samples (e, m) from a block on."""
    entries, m = rows.shape
    full, rest = divmod(m, BLOCK)
    contiguous = rows.strides[1] == rows.itemsize
    for first, blocks, size in ((0, full, BLOCK), (full, min(rest, 1), rest)):
        if not blocks:
            continue
        # Along memory first: samples of an entry lie side by side, or entries of a sample.
        wide = min(blocks, TILE if contiguous else max(1, TILE // max(entries, 1)))
        high = TILE // wide
        for i in range(0, entries, high):
            for b in range(first, first + blocks, wide):
                last = min(b + wide, first + blocks)
                part = rows[i : i + high, b * BLOCK : b * BLOCK + (last - b) * size]
                if not contiguous:
                    laid = room[: part.size].reshape(part.shape)
                    laid[...] = part
                    part = laid
                which, where = slice(block + b, block + last), slice(i, i + len(part))
                yield which, where, part.reshape(len(part), -1, size)


# -- blocks of all chunks ---------------------------------------------------------------------------------------------


@dataclass(eq=False)
class PooledMoments:
    """Moments of a stream of blocks, pooled in sets that depend on the number of the block alone.

    Memory grows with the logarithm of the number of blocks.
    """

    _levels: list[Array] = field(default_factory=list)

    def add(self, blocks: Moments) -> None:
        """Add the next blocks, (b, ...)."""
        self._push(0, _numbers(blocks))

    def _push(self, level: int, parts: Array) -> None:
        """Add the next parts of a level, (5, k, ...)."""
        if level == len(self._levels):
            self._levels.append(parts[:, :0])
        parts = np.concatenate([self._levels[level], parts], axis=1)
        whole = parts.shape[1] // POOL
        self._levels[level] = parts[:, whole * POOL :]
        if whole:
            sets = parts[:, : whole * POOL].reshape(5, whole, POOL, *parts.shape[2:])
            self._push(level + 1, _numbers(Moments.pooled(_moments(sets.swapaxes(1, 2)))))

    @property
    def moments(self) -> Moments | None:
        """Of all blocks so far; None of none."""
        if not self._levels:
            return None
        return Moments.pooled(_moments(np.concatenate(self._levels[::-1], axis=1)))
