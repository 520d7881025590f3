"""Elimination order: least batch shape first, least degree within it.

A pivot is then computed once per thing that it depends on: what varies with nothing before what varies with the pose,
that before what varies with the sample. Substructuring comes of it by itself.
"""

from __future__ import annotations

import heapq
from collections.abc import Iterable
from dataclasses import dataclass

from .parts import Grid

Pattern = dict[int, dict[int, int]]


@dataclass(frozen=True)
class Order:
    """Pivots in turn.

    Attributes
    ----------
    pivots
        Unknowns in order of elimination.
    below
        By pivot: the unknowns that are left in its column.
    masks
        By pivot: the batch axes over which its column varies.
    """

    pivots: list[int]
    below: dict[int, list[int]]
    masks: dict[int, int]

    def operations(self, grid: Grid, *, shared: bool = True) -> int:
        """Multiplications and subtractions of the factorisation over the batch, as it is or with nothing `shared`."""
        return sum(
            (grid.sizes[self.masks[k]] if shared else grid.sizes[-1]) * len(self.below[k]) * (len(self.below[k]) + 2)
            for k in self.pivots
        )


def link(pattern: Pattern, i: int, j: int, mask: int) -> None:
    """Note that entry (i, j) is there and varies over `mask`."""
    pattern.setdefault(i, {})
    pattern.setdefault(j, {})
    pattern[i][j] = pattern[j][i] = pattern[i].get(j, 0) | mask


def order(pattern: Pattern, candidates: Iterable[int], grid: Grid) -> Order:
    """Order the elimination of `candidates`; `pattern` becomes that of what is left, with its fill."""
    waiting = set(candidates)
    result = Order([], {}, {})

    def key(k: int) -> tuple[int, int, int]:
        mask = 0
        for other in pattern[k].values():
            mask |= other
        return grid.sizes[mask], len(pattern[k]), k

    keys = {k: key(k) for k in waiting}
    heap = sorted(keys.values())
    while heap:
        entry = heapq.heappop(heap)
        k = entry[2]
        if k not in waiting or keys[k] != entry:
            continue
        waiting.remove(k)
        row = pattern.pop(k)
        mask = row.pop(k)
        below = sorted(row)
        for j in below:
            del pattern[j][k]
        for a, i in enumerate(below):
            for j in below[a:]:
                link(pattern, i, j, row[i] | row[j] | mask)
        for i in below:
            mask |= row[i]
            if i in waiting:
                keys[i] = key(i)
                heapq.heappush(heap, keys[i])
        result.pivots.append(k)
        result.below[k] = below
        result.masks[k] = mask
    return result
