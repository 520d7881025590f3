"""Order of elimination: at each step the unknown with the least cost, that of its own operations and of its fill.

A pivot is computed once for each value of the batch axes on which it depends. Pivots that are constant are cheap and
come before those that vary with the pose, which come before those that vary with the sample: this amounts to
substructuring. But a cheap pivot that would couple many costly ones, such as one between the joints of a long chain,
comes after them.
"""

from __future__ import annotations

import functools
import heapq
import operator
from collections.abc import Callable, Container, Iterable
from dataclasses import dataclass
from typing import Any

from ..cache import ORDERS
from ..structure.parts import Grid, Matrix, Row, Value, masks_of

Pattern = dict[int, dict[int, int]]
Springs = list[tuple[Row, Value]]
# Sort key of an unknown, which is its last item; the smallest key is eliminated first.
Key = tuple[int, int, int]
# Up to this many unknowns two ways of ordering are compared.
FEW = 60
# Up to this many unknowns sets of them are bits of numbers, which are intersected in a third of the time.
_BITS = 4096


@dataclass(frozen=True)
class Order:
    """An order of elimination.

    Attributes
    ----------
    pivots
        Unknowns in order of elimination.
    below
        For each pivot the unknowns in its column that are not yet eliminated, fill included.
    masks
        For each pivot the mask of batch axes over which its column varies.
    """

    pivots: list[int]
    below: dict[int, list[int]]
    masks: dict[int, int]

    def operations(self, grid: Grid, *, shared: bool = True) -> int:
        """Number of multiplications and subtractions of the factorisation over the batch.

        With `shared` False it is that of factorising each batch entry on its own.
        """
        return sum(
            (grid.sizes[self.masks[k]] if shared else grid.sizes[-1]) * len(self.below[k]) * (len(self.below[k]) + 2)
            for k in self.pivots
        )


@dataclass(frozen=True)
class Masks:
    """Masks of the factors in rows: those of the substitution, and of each spring with the mask of its stiffness."""

    rows: dict[int, dict[int, int]]
    springs: list[tuple[dict[int, int], int]]

    @classmethod
    def of(cls, rows: dict[int, Row], springs: Springs) -> Masks:
        """The masks of given rows and springs."""
        (stiff,) = masks_of([dict(enumerate(k for _, k in springs))])
        own = zip(masks_of([row for row, _ in springs]), stiff.values(), strict=True)
        return cls(dict(zip(rows, masks_of(rows.values()), strict=True)), list(own))


def link(pattern: Pattern, i: int, j: int, mask: int) -> None:
    """Add the entry (i, j), which varies over `mask`, to a pattern."""
    row = pattern.setdefault(i, {})
    row[j] = pattern.setdefault(j, {})[i] = row.get(j, 0) | mask


def pattern_of(matrix: Matrix, substituted: Container[int]) -> Pattern:
    """Masks of the entries of a matrix, with every diagonal entry except those of substituted displacements."""
    pattern: Pattern = {}
    for i, row in matrix.items():
        for j, parts in row.items():
            if j >= i and (parts or (i == j and i not in substituted)):
                link(pattern, i, j, functools.reduce(operator.or_, parts, 0))
    return pattern


def two_stages(grid: Grid, pattern: Pattern, inner: list[int], left: list[int], masks: Masks) -> tuple[Order, Order]:
    """Orders of elimination of both stages, cached for frames of the same topology.

    Parameters
    ----------
    grid
        The batch.
    pattern
        Pattern of the stiffness of members, in the nodes' axes.
    inner, left
        Unknowns of the first and of the second stage.
    masks
        Masks of the substitution and of the springs, by which the second stage follows from the first.
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
    """Order the elimination of `candidates`; `pattern` is reduced to that of the remaining unknowns, with its fill.

    For few candidates, ordering strictly by batch shape is tried as well, and the cheaper order taken.
    """
    waiting = set(candidates)
    copied = {k: dict(row) for k, row in pattern.items()} if len(waiting) <= FEW else {}
    sizes = {grid.sizes[mask] for k in waiting for mask in pattern[k].values()}
    if len(sizes) <= 1:
        return _ordered(pattern, waiting, _ByShape(pattern, grid))
    by_cost = _ordered(pattern, waiting, _ByCost(pattern, grid))
    if not copied:
        return by_cost
    return min(by_cost, _ordered(copied, waiting, _ByShape(copied, grid)), key=lambda found: found.operations(grid))


def in_turn(pattern: Pattern, pivots: Iterable[int]) -> Order:
    """The elimination of `pivots` one after the other; `pattern` is reduced as by `order`."""
    result = Order([], {}, {})
    for k in pivots:
        _eliminate(pattern, k, result)
    return result


def _ordered(pattern: Pattern, candidates: set[int], by: _ByShape) -> Order:
    """Eliminate `candidates` from `pattern`, the one with the least key first."""
    waiting = set(candidates)
    result = Order([], {}, {})
    keys = {k: by.key(k) for k in waiting}
    heap = sorted(keys.values())
    while heap:
        entry = heapq.heappop(heap)
        k = entry[-1]
        if k not in waiting or keys[k] != entry:
            continue
        keys[k] = by.key(k)
        if keys[k] > entry:
            heapq.heappush(heap, keys[k])
            continue
        waiting.remove(k)
        _eliminate(pattern, k, result)
        by.follow(k, result.below[k])
        for i in waiting.intersection(result.below[k]):
            keys[i] = by.key(i)
            heapq.heappush(heap, keys[i])
    return result


class _ByShape:
    """Keys by the number of batch entries over which the column varies, then by the length of the column."""

    def __init__(self, pattern: Pattern, grid: Grid) -> None:
        self.pattern, self.sizes = pattern, grid.sizes

    def key(self, k: int) -> Key:
        """Key of unknown k in the pattern as it is now."""
        row = self.pattern[k]
        return self.sizes[functools.reduce(operator.or_, row.values(), 0)], len(row), k

    def follow(self, k: int, below: list[int]) -> None:
        """Take note that k has been eliminated, with the unknowns `below` in its column."""


class _ByCost(_ByShape):
    """Keys by cost: operations of a pivot over the batch, and two over the whole batch for each fill entry.

    The unknowns that are coupled with another one are a set: the bits of a number, or a set of Python where that number
    would be long.
    """

    def __init__(self, pattern: Pattern, grid: Grid) -> None:
        super().__init__(pattern, grid)
        few = len(pattern) <= _BITS
        self.single: dict[int, Any] = {k: 1 << place if few else {k} for place, k in enumerate(pattern)}
        self.count: Callable[[Any], int] = int.bit_count if few else len
        none: Any = 0 if few else set()
        self.coupled = {
            k: functools.reduce(operator.or_, [self.single[i] for i in row if i != k], none)
            for k, row in pattern.items()
        }

    def key(self, k: int) -> Key:
        size, length, _ = super().key(k)
        own, count = self.coupled[k], length - 1
        present = sum([self.count(own & self.coupled[i]) for i in self.pattern[k]]) - count
        fill = (count * (count - 1) - present) // 2
        return size * count * (count + 3) + 2 * self.sizes[-1] * fill, count, k

    def follow(self, k: int, below: list[int]) -> None:
        for i in below:
            self.coupled[i] = (self.coupled[i] | self.coupled[k]) ^ self.single[i] ^ self.single[k]


def _eliminate(pattern: Pattern, k: int, order: Order) -> None:
    """Add pivot k to an order: remove it from the pattern, to which its fill is added."""
    row = pattern.pop(k)
    mask = row.pop(k)
    below = sorted(row)
    for j in below:
        del pattern[j][k]
    for a, i in enumerate(below):
        filled, own = pattern[i], row[i] | mask
        for j in below[a:]:
            filled[j] = pattern[j][i] = filled.get(j, 0) | own | row[j]
    order.pivots.append(k)
    order.below[k], order.masks[k] = below, functools.reduce(operator.or_, row.values(), mask)
