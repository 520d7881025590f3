"""Elimination order: at each turn the unknown that costs least, itself and by the links that it makes.

A pivot is computed once per thing that it depends on. What varies with nothing is cheap and goes before what varies
with the pose, that before what varies with the sample: substructuring comes of it by itself. But where a cheap pivot
would link many dear ones, as that between the joints of a long chain, it waits for them.
"""

from __future__ import annotations

import functools
import heapq
import operator
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass

from ..cache import ORDERS
from ..structure.parts import Grid, Matrix, Row, Value, masks_of

Pattern = dict[int, dict[int, int]]
Springs = list[tuple[Row, Value]]
# Sorts unknowns, which are its last item: what to eliminate first.
Key = Callable[[Pattern, int, Grid], tuple[int, int, int]]
# Unknowns up to which two ways of ordering are compared.
FEW = 60


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


@dataclass(frozen=True)
class Masks:
    """Batch axes over which the substitution and the springs vary."""

    rows: dict[int, dict[int, int]]
    springs: list[tuple[dict[int, int], int]]

    @classmethod
    def of(cls, rows: dict[int, Row], springs: Springs) -> Masks:
        """Those of these numbers."""
        (stiff,) = masks_of([dict(enumerate(k for _, k in springs))])
        own = zip(masks_of([row for row, _ in springs]), stiff.values(), strict=True)
        return cls(dict(zip(rows, masks_of(rows.values()), strict=True)), list(own))


def link(pattern: Pattern, i: int, j: int, mask: int) -> None:
    """Note that entry (i, j) is there and varies over `mask`."""
    row = pattern.setdefault(i, {})
    row[j] = pattern.setdefault(j, {})[i] = row.get(j, 0) | mask


def pattern_of(matrix: Matrix, substituted: Container[int]) -> Pattern:
    """Which entries of a matrix are there, and over what they vary: all diagonals but those of what is substituted."""
    pattern: Pattern = {}
    for i, row in matrix.items():
        for j, parts in row.items():
            if j >= i and (parts or (i == j and i not in substituted)):
                link(pattern, i, j, functools.reduce(operator.or_, parts, 0))
    return pattern


def two_stages(grid: Grid, pattern: Pattern, inner: list[int], left: list[int], masks: Masks) -> tuple[Order, Order]:
    """Orders of both stages of an elimination; frames of one topology have them in common.

    Parameters
    ----------
    grid
        The batch.
    pattern
        That of the stiffness of members, in the nodes' axes.
    inner, left
        Unknowns of the first and of the second stage.
    masks
        Over what the substitution and the springs vary, which make the second stage of the first.
    """
    ends = {a: _unknown(row) for a, row in masks.rows.items()}
    springs = [(_unknown(row), over) for row, over in masks.springs]
    key = (
        grid.shape,
        tuple((a, tuple(row.items())) for a, row in pattern.items()),
        tuple(inner),
        tuple(left),
        tuple((a, tuple(row.items())) for a, row in ends.items()),
        tuple((tuple(row.items()), over) for row, over in springs),
    )

    def ordered() -> tuple[Order, Order]:
        first = order(pattern, inner, grid)
        reduced: Pattern = {k: {k: 0} for k in left}
        for a, coupled in pattern.items():
            for b, over in coupled.items():
                if b >= a:
                    _link_rows(reduced, ends[a], ends[b], over)
        for spring, over in springs:
            _link_rows(reduced, spring, spring, over)
        return first, order(reduced, list(reduced), grid)

    found: tuple[Order, Order] = ORDERS.found(key, ordered, sum(map(len, pattern.values())))
    return found


def _unknown(masks: dict[int, int]) -> dict[int, int]:
    return {k: mask for k, mask in masks.items() if k >= 0}


def _link_rows(pattern: Pattern, left: dict[int, int], right: dict[int, int], over: int) -> None:
    if not right:
        return
    for i, first in left.items():
        row, of_first = pattern.setdefault(i, {}), over | first
        for j, second in right.items():
            row[j] = pattern.setdefault(j, {})[i] = row.get(j, 0) | of_first | second


def order(pattern: Pattern, candidates: Iterable[int], grid: Grid) -> Order:
    """Order the elimination of `candidates`; `pattern` becomes that of what is left, with its fill.

    Where they are few, ordering strictly by batch shape is tried too, and the cheaper way taken.
    """
    waiting = set(candidates)
    copied = {k: dict(row) for k, row in pattern.items()} if len(waiting) <= FEW else {}
    sizes = {grid.sizes[mask] for k in waiting for mask in pattern[k].values()}
    by_cost = _ordered(pattern, waiting, grid, _cost if len(sizes) > 1 else _shape)
    if not copied or len(sizes) == 1:
        return by_cost
    return min(by_cost, _ordered(copied, waiting, grid, _shape), key=lambda found: found.operations(grid))


def _ordered(pattern: Pattern, candidates: set[int], grid: Grid, key: Key) -> Order:
    """Eliminate `candidates` from `pattern`, least `key` first."""
    waiting = set(candidates)
    result = Order([], {}, {})
    keys = {k: key(pattern, k, grid) for k in waiting}
    heap = sorted(keys.values())
    while heap:
        entry = heapq.heappop(heap)
        k = entry[-1]
        if k not in waiting or keys[k] != entry:
            continue
        keys[k] = key(pattern, k, grid)
        if keys[k] > entry:
            heapq.heappush(heap, keys[k])
            continue
        waiting.remove(k)
        result.pivots.append(k)
        result.below[k], result.masks[k] = _eliminate(pattern, k)
        for i in waiting.intersection(result.below[k]):
            keys[i] = key(pattern, i, grid)
            heapq.heappush(heap, keys[i])
    return result


def _size(pattern: Pattern, k: int, grid: Grid) -> int:
    """Number of batch entries over which the column of k varies."""
    return grid.sizes[functools.reduce(operator.or_, pattern[k].values(), 0)]


def _shape(pattern: Pattern, k: int, grid: Grid) -> tuple[int, int, int]:
    """Batch shape, and degree within it."""
    return _size(pattern, k, grid), len(pattern[k]), k


def _cost(pattern: Pattern, k: int, grid: Grid) -> tuple[int, int, int]:
    """Operations of pivot k over the batch, and two more, of the dearest kind, for each link that it makes."""
    near = pattern[k].keys() - {k}
    present = sum(len(near & pattern[i].keys()) - (i in pattern[i]) for i in near)
    fill = (len(near) * (len(near) - 1) - present) // 2
    own = _size(pattern, k, grid) * len(near) * (len(near) + 3)
    return own + 2 * grid.sizes[-1] * fill, len(near), k


def _eliminate(pattern: Pattern, k: int) -> tuple[list[int], int]:
    """Take k out of the pattern, which is filled; return what is left in its column, and the axes it varies over."""
    row = pattern.pop(k)
    mask = row.pop(k)
    below = sorted(row)
    for j in below:
        del pattern[j][k]
    for a, i in enumerate(below):
        filled, own = pattern[i], row[i] | mask
        for j in below[a:]:
            filled[j] = pattern[j][i] = filled.get(j, 0) | own | row[j]
    return below, functools.reduce(operator.or_, row.values(), mask)
