"""Geometric nested dissection: the order of elimination of a large frame, and the cost of its factor.

Space is halved along its longest side repeatedly; at each cut the nodes that are coupled across it are eliminated after
both halves (George, SIAM J. Numer. Anal. 10, 1973, 345-363). All parts of a level are cut at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..structure.topology import Index

# Parts of up to this many nodes are not divided.
LEAF = 6


@dataclass(frozen=True)
class Dissection:
    """An elimination order of nodes.

    Attributes
    ----------
    order
        Node numbers (n,), the first eliminated first.
    operations
        Multiplications and additions of an LDL^T in this order, for six unknowns a node.
    entries
        Entries of its factor.
    """

    order: Index
    operations: float
    entries: float


def dissect(points: Array, pairs: Index) -> Dissection:
    """Nested dissection of a graph with known positions.

    Parameters
    ----------
    points
        Positions of the nodes (n, 3).
    pairs
        Joined nodes (m, 2), in any order and either direction.
    """
    i, j = np.concatenate([pairs, pairs[:, ::-1]]).T
    part = np.zeros(len(points), dtype=np.int64)
    done = np.zeros(len(points), dtype=bool)
    sides, operations, entries = [], 0.0, 0.0
    while not done.all():
        side = _halves(points, part, done)
        cut = (part[i] == part[j]) & (side[i] == 1) & (side[j] == 2)
        side[i[cut]] = 3
        sides.append(side)
        spent = _cost(part, done, (side == 0) | (side == 3), i, j)
        operations, entries = operations + spent[0], entries + spent[1]
        done |= (side == 0) | (side == 3)
        part = np.where(done, -1, 2 * part + (side == 2))
    return Dissection(np.lexsort(tuple(reversed(sides))), operations, entries)


def bisected(points: Array, size: int) -> Index:
    """Compact parts of at most `size` points: the part number of each of `points` (n, 3), (n,)."""
    part = np.zeros(len(points), dtype=np.int64)
    whole = np.zeros(len(points), dtype=bool)
    for _ in range(int(np.ceil(np.log2(max(len(points) / size, 1.0))))):
        part = 2 * part + (_halves(points, part, whole, leaf=1) == 2)
    return np.unique(part, return_inverse=True)[1].astype(np.int64)


def _halves(points: Array, part: Index, done: NDArray[np.bool_], leaf: int = LEAF) -> NDArray[np.int8]:
    """1 and 2 for the two halves of each part, cut across its longest side; 0 in parts that are not divided, (n,)."""
    at = np.flatnonzero(~done)
    at = at[np.argsort(part[at], kind="stable")]
    starts = np.flatnonzero(np.diff(part[at], prepend=-1))
    counts = np.diff(starts, append=len(at))
    which = np.repeat(np.arange(len(starts)), counts)
    x = points[at]
    longest = np.argmax(np.maximum.reduceat(x, starts) - np.minimum.reduceat(x, starts), axis=1)[which]
    rows = np.arange(len(at))
    # Ties are broken by the other coordinates, so that the result does not depend on the order of description.
    sort = np.lexsort((x[rows, longest - 2], x[rows, longest - 1], x[rows, longest], which))
    side = np.zeros(len(part), dtype=np.int8)
    side[at[sort]] = np.where(counts[which] <= leaf, 0, 1 + (2 * (rows - starts[which]) >= counts[which]))
    return side


def _cost(part: Index, done: NDArray[np.bool_], now: NDArray[np.bool_], i: Index, j: Index) -> tuple[float, float]:
    """Operations, and entries of the factor, of eliminating the nodes `now`, part by part, coupled with later ones."""
    at = np.flatnonzero(now & ~done)
    names, eliminated = np.unique(part[at], return_counts=True)
    inside = ~done[i] & done[j]
    border = np.unique(part[i[inside]] * len(part) + j[inside]) // len(part)
    first = 6.0 * eliminated
    later = 6.0 * (np.searchsorted(border, names, side="right") - np.searchsorted(border, names))
    operations = first**3 / 3.0 + first**2 * later + first * later**2
    return float(operations.sum()), float((first * (first / 2.0 + later)).sum())
