"""Statistics of samples block by block, so that they do not depend on how the samples are divided into chunks."""

from __future__ import annotations

import math
import threading
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..moments import SUMS, Moments
from ..sampling import BLOCK
from . import block_code

Array = NDArray[np.float64]
# Slices of blocks and of rows, and their samples (rows, blocks, samples of a block).
Tile = tuple[slice, slice, Array]

# Blocks of a row that are processed at once: with two arrays of their size they fit the cache.
TILE = 64
# Number of blocks that are pooled into one set, and numbers that are collected so that many sets are pooled at once.
POOL = 16
WAITING = 2**18
_own = threading.local()


@dataclass(frozen=True, eq=False)
class BlockStatistics:
    """Statistics of the samples of a chunk.

    Parameters
    ----------
    numbers
        For each of the b blocks of samples: number of samples, mean, and sums of the second, third and fourth powers of
        the deviations from it, (5, b, ...).
    replicated
        The same for each replicate, (5, b, r, ...); None if there is one replicate.
    least, greatest
        Extremes of all samples, (...).
    """

    numbers: Array
    replicated: Array | None
    least: Array
    greatest: Array

    @classmethod
    def of(cls, results: Array, nan_policy: str, replicates: int = 1) -> BlockStatistics:
        """Statistics of samples (m, ...) of any memory layout."""
        # with axes in memory order, entries can be viewed as rows of samples without a copy
        order = sorted(range(1, results.ndim), key=lambda axis: -abs(results.strides[axis]))
        shape = [results.shape[axis] for axis in order]
        entries, blocks = math.prod(shape), -(-len(results) // BLOCK)
        lower, upper = _extremes(nan_policy)
        found = np.empty((7, blocks, entries))
        by_replicate = np.empty((5, blocks, replicates if replicates > 1 else 0, entries))
        compiled = block_code.serves(results.size)
        laid, *room = _own_memory()
        for which, where, tile in _tiles(results.transpose((*order, 0)), entries, laid, compiled):
            found[:, which, where] = _of_tile(tile, nan_policy, room, compiled).swapaxes(1, 2)
            if replicates > 1:
                turns = tile.reshape(*tile.shape[:-1], -1, replicates).swapaxes(-1, -2)
                each = Moments.of_rows(np.ascontiguousarray(turns), nan_policy)
                by_replicate[:, which, :, where] = np.moveaxis(_numbers(each), 1, -1)
        least, greatest = lower.reduce(found[0], axis=0), upper.reduce(found[1], axis=0)
        places = [order.index(axis) for axis in range(1, results.ndim)]

        def back(array: Array) -> Array:
            """An array (..., rows) with its rows as the entries of the results again."""
            lead = array.ndim - 1
            apart = array.reshape((*array.shape[:-1], *shape))
            return apart.transpose((*range(lead), *(lead + place for place in places)))

        replicated = back(by_replicate) if replicates > 1 else None
        return cls(back(found[2:]), replicated, back(least)[()], back(greatest)[()])

    @property
    def moments(self) -> Moments:
        """Moments of each block, (b, ...)."""
        return _moments(self.numbers)


def _extremes(nan_policy: str) -> tuple[np.ufunc, np.ufunc]:
    """The functions that find the least and the greatest number, with or without NaN."""
    return (np.fmin, np.fmax) if nan_policy == "omit" else (np.minimum, np.maximum)


def _of_tile(tile: Array, nan_policy: str, room: Sequence[Array], compiled: bool) -> Array:
    """Extremes, number of samples, mean and sums of powers, (7, rows, blocks), of samples (rows, blocks, m)."""
    if compiled and tile.shape[-1] == BLOCK:
        found = block_code.numbers_of_blocks(tile)
        lost = np.isnan(found[3])
        if lost.any():
            found[:, lost] = _of_tile(tile[lost][:, None], nan_policy, (), False)[..., 0]
        return found
    lower, upper = _extremes(nan_policy)
    rooms = (room[0][: tile.size].reshape(tile.shape), room[1][: tile.size].reshape(tile.shape)) if room else None
    moments = Moments.of_rows(tile, nan_policy, rooms)
    return np.concatenate([[lower.reduce(tile, axis=-1), upper.reduce(tile, axis=-1)], _numbers(moments)])


def _numbers(moments: Moments) -> Array:
    """Number of samples, mean and sums of powers, (5, ...)."""
    n = np.broadcast_to(moments.n, np.shape(moments.mean))
    return np.array([n, *(getattr(moments, key) for key in SUMS)])


def _moments(numbers: Array) -> Moments:
    return Moments(numbers[0].astype(np.int64), *numbers[1:])


def _own_memory() -> tuple[Array, Array, Array]:
    """Three arrays of the size of a tile, kept by thread: new memory for each chunk would cost more than the sums."""
    if not hasattr(_own, "memory"):
        _own.memory = np.empty(TILE * BLOCK), np.empty(TILE * BLOCK), np.empty(TILE * BLOCK)
    found: tuple[Array, Array, Array] = _own.memory
    return found


def _tiles(samples: Array, entries: int, room: Array, compiled: bool) -> Iterator[Tile]:
    """Samples (..., m) in pieces that fit the cache, each block contiguous; a piece is valid until the next one.

    Machine code reads each number once and takes contiguous samples as they are.
    """
    m = samples.shape[-1]
    rows = samples[..., :1].reshape(entries, 1)
    if np.may_share_memory(rows, samples):
        yield from _tiles_of_rows(samples.reshape(entries, m), 0, room, compiled)
        return
    # entries that cannot be viewed as rows are copied block by block
    laid = np.empty((*samples.shape[:-1], BLOCK))
    for block, start in enumerate(range(0, m, BLOCK)):
        size = min(BLOCK, m - start)
        laid[..., :size] = samples[..., start : start + size]
        yield from _tiles_of_rows(laid.reshape(entries, BLOCK)[:, :size], block, room, compiled)


def _tiles_of_rows(rows: Array, block: int, room: Array, compiled: bool) -> Iterator[Tile]:
    """Pieces of samples (e, m), the first of which belong to the given block."""
    entries, m = rows.shape
    full, rest = divmod(m, BLOCK)
    contiguous = rows.strides[1] == rows.itemsize
    for first, blocks, size in ((0, full, BLOCK), (full, min(rest, 1), rest)):
        if not blocks:
            continue
        if compiled and contiguous and size == BLOCK:
            yield slice(block, block + full), slice(0, entries), rows[:, : full * BLOCK].reshape(entries, full, BLOCK)
            continue
        # pieces extend along memory: over the samples of an entry, or over the entries of a sample
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
    """Moments of a stream of blocks, pooled in sets that depend on the index of the block alone.

    Memory grows with the logarithm of the number of blocks.
    """

    _levels: list[list[Array]] = field(default_factory=list)

    def add(self, blocks: Array) -> None:
        """Add the statistics of the next blocks, (5, b, ...)."""
        self._push(0, blocks)

    def _push(self, level: int, parts: Array) -> None:
        """Add the next parts of a level, (5, k, ...)."""
        if level == len(self._levels):
            self._levels.append([])
        self._levels[level].append(parts)
        if sum(part.size for part in self._levels[level]) >= WAITING:
            self._pool(level)

    def _pool(self, level: int) -> None:
        """Pool the complete sets of a level."""
        parts = np.concatenate(self._levels[level], axis=1)
        whole = parts.shape[1] // POOL
        self._levels[level] = [parts[:, whole * POOL :]]
        if whole:
            sets = parts[:, : whole * POOL].reshape(5, whole, POOL, *parts.shape[2:])
            self._push(level + 1, _numbers(Moments.pooled(_moments(sets.swapaxes(1, 2)))))

    @property
    def moments(self) -> Moments | None:
        """Moments of all blocks so far; None if there are none."""
        if not self._levels:
            return None
        level = 0
        while level < len(self._levels):
            self._pool(level)
            level += 1
        return Moments.pooled(_moments(np.concatenate([parts[0] for parts in self._levels[::-1]], axis=1)))
