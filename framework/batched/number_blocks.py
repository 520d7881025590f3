"""The numbers of a batch in blocks: which are zero at all entries, and all of them as a table for machine code."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Hashable, Iterator, Sequence
from itertools import groupby, pairwise
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, any_of
from ..lazily import cached_property
from ..structure.parts import Grid, Value, mask_of_shape

# So many numbers, all entries counted, are looked at together.
_FEW = 2**17


class Blocks:
    """Numbers that vary over a batch, in blocks of those that belong together.

    Parameters
    ----------
    grid
        The batch.

    Attributes
    ----------
    blocks
        Arrays (m, ...) with all batch axes.
    masks
        For each block the mask of the axes over which it varies.
    starts
        For each block, the index of its first number among all numbers.
    count
        How many numbers there are.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid, self.count = grid, 0
        self.blocks: list[NDArray[Any]] = []
        self.masks: list[int] = []
        self.starts: list[int] = []
        self._ndim, self._whole = len(grid.shape), mask_of_shape(grid.shape)

    def put(self, block: NDArray[Any]) -> int:
        """Add numbers (m, ...) that belong together; the index of the first."""
        start, missing = self.count, self._ndim + 1 - block.ndim
        if missing > 0:
            block = block.reshape(len(block), *(1,) * missing, *block.shape[1:])
        self.blocks.append(block)
        self.masks.append(self._whole if block.shape[1:] == self.grid.shape else mask_of_shape(block.shape[1:]))
        self.starts.append(start)
        self.count += len(block)
        return start

    def one(self, number: Array) -> int:
        """Add a number (...); its index."""
        return self.put(number[None])

    @cached_property
    def used(self) -> list[bool]:
        """Which numbers are not zero at all entries, once all are added."""
        if self.count * self.grid.sizes[-1] <= _FEW:
            return [*(self.table != 0.0).any(axis=0).tolist()]
        first: Any = (slice(None), *(0,) * self._ndim)
        found = [number != 0.0 for block in self.blocks for number in block[first].tolist()]
        # most are not zero at the first entry, and need no second look
        for block, mask, start in zip(self.blocks, self.masks, self.starts, strict=True):
            own = found[start : start + len(block)]
            if mask and False in own:
                for a, b in _zeros(own):
                    if any_of(rest := block[a:b]):
                        found[start + a : start + b] = map(any_of, rest)
        return found

    @property
    def pattern(self) -> Hashable:
        """What varies over which axes, and which numbers are zero at all entries."""
        return (*self.masks, *self.starts), bytes(self.used)

    def values(self, wanted: Sequence[int]) -> list[Value]:
        """Some of the numbers by index, in order, contiguous, each of the shape over which it varies."""
        found: list[Value] = []
        ends = np.searchsorted(wanted, [*self.starts, self.count]).tolist()
        for block, mask, start, (a, b) in zip(self.blocks, self.masks, self.starts, pairwise(ends), strict=True):
            if b == a:
                continue
            numbers = np.ascontiguousarray(block) if mask else block.reshape(-1)
            found += [numbers[k - start] for k in wanted[a:b]]
        return found

    def value(self, k: int) -> Value:
        """The number of an index, of the shape over which it varies."""
        place = bisect_right(self.starts, k) - 1
        block, k = self.blocks[place], k - self.starts[place]
        found: Value = np.ascontiguousarray(block[k]) if self.masks[place] else block.reshape(-1)[k]
        return found

    @cached_property
    def table(self) -> Array:
        """All numbers at each entry, once all are added: (entries, count)."""
        out = np.empty((self.grid.sizes[-1], self.count))
        columns = out.T.reshape(self.count, *self.grid.shape)
        for start, block in zip(self.starts, self.blocks, strict=True):
            columns[start : start + len(block)] = block
        return out


def _zeros(used: list[bool]) -> Iterator[tuple[int, int]]:
    """Where those begin and end that are not used, one run after the other."""
    start = 0
    for some, run in groupby(used):
        stop = start + len([*run])
        if not some:
            yield start, stop
        start = stop
