"""Loops that determine other unknowns at some batch entries than at others, as one set of unknowns for all.

Entries are parted until one choice of pivots suits each part. Of the unknowns that any part determines, as many remain
as the part that determines fewest leaves free: each of these stands, at an entry, for one that is free there.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..batch import Shape
from ..entries import WHOLE, Entries, Index
from .disjoint_sets import DisjointSets
from .gauss_jordan import ALONE, SUITS_WELL, Constraint, Mask, Reduced, reduced
from .parts import Row, Value, unknowns

# Entries, by batch axis, and what they were solved for.
Part = tuple[tuple[Index, ...], Reduced]


def by_entry(given: dict[int, Constraint]) -> tuple[Reduced, dict[int, Value]]:
    """Solve constraints for other unknowns at some batch entries than at others.

    Parameters
    ----------
    given
        The constraints by number.

    Returns
    -------
    Reduced
        What is determined at some entry, by what is left to be free at any. A row may hold its own unknown, which then
        stands for another where it is determined.
    dict
        By unknown that is left, one at entries at which it stands for nothing and zero at the others.
    """
    whole, idle = Reduced(), dict[int, Value]()
    for loop in _loops(given):
        found = reduced(loop, WHOLE)
        if isinstance(found, Reduced):
            own, spare = found, dict[int, Value]()
        else:
            shape = _shape(loop.values())
            own, spare = _merged(_parted(loop, shape, found), shape)
        whole.rows |= own.rows
        whole.sources |= own.sources
        whole.left |= own.left
        whole.self_stresses |= own.self_stresses
        idle |= spare
    return whole, idle


def alone(given: dict[int, Constraint]) -> list[tuple[dict[int, Constraint], Shape, list[Part]]]:
    """Loops that vary over a batch, the shape over which they do, and parts of that in which each entry has the choice
    that it has alone."""
    out = []
    for loop in _loops(given):
        shape = _shape(loop.values())
        if np.prod(shape, dtype=np.int64) > 1:
            out.append((loop, shape, _solved(loop, np.nonzero(np.ones(shape, dtype=bool)), ALONE)))
    return out


def _loops(given: dict[int, Constraint]) -> list[dict[int, Constraint]]:
    """Constraints that have no unknown in common apart."""
    joined = DisjointSets[int]()
    keys = {index: unknowns(each.row) for index, each in given.items()}
    for met in keys.values():
        for key in met[1:]:
            joined.join(met[0], key)
    out: dict[int, dict[int, Constraint]] = {}
    for index, met in keys.items():
        out.setdefault(joined.find(met[0]) if met else -1, {})[index] = given[index]
    return list(out.values())


def _shape(given: Iterable[Constraint]) -> Shape:
    """Batch shape over which the coefficients vary."""
    arrays = [value.shape for each in given for value in each.row.values() if isinstance(value, np.ndarray)]
    return np.broadcast_shapes(*arrays)


def _parted(given: dict[int, Constraint], shape: Shape, suited: Mask) -> list[Part]:
    """All entries of a batch shape, of which one choice of pivots suits some, in parts that each have one."""
    everywhere = np.nonzero(np.ones(shape, dtype=bool))
    return _split(given, everywhere, np.broadcast_to(suited, shape).reshape(-1), SUITS_WELL)


def _solved(given: dict[int, Constraint], index: tuple[Index, ...], share: float) -> list[Part]:
    """Some entries, in parts as far as it takes."""
    found = reduced(given, Entries(index), share)
    if isinstance(found, Reduced):
        return [(index, found)]
    return _split(given, index, np.broadcast_to(found, index[0].shape), share)


def _split(given: dict[int, Constraint], index: tuple[Index, ...], suited: Mask, share: float) -> list[Part]:
    """Entries in two and more parts: those that a choice of pivots suits, and the others."""
    return [part for mask in (suited, ~suited) for part in _solved(given, tuple(each[mask] for each in index), share)]


def _merged(parts: list[Part], shape: Shape) -> tuple[Reduced, dict[int, Value]]:
    """Parts of the entries of a loop as one, and by unknown that is left where it stands for nothing."""
    pivots = list(dict.fromkeys(key for _, found in parts for key in found.rows))
    # the part with most free unknowns, the largest of these
    fewest = min(parts, key=lambda part: (len(part[1].rows), -len(part[0][0])))[1]
    kept = [key for key in pivots if key not in fewest.rows]
    rows, sources, left, self_stresses, idle = (_Spread(shape) for _ in range(5))
    for index, found in parts:
        place, spare = _placed([key for key in pivots if key not in found.rows], kept)
        for key in pivots:
            if key in place:
                rows.put(key, {place[key]: 1.0}, index)
                sources.put(key, {}, index)
                continue
            rows.put(key, {place.get(k, k): value for k, value in found.rows[key].items()}, index)
            sources.put(key, found.sources[key], index)
        for number, row in found.left.items():
            left.put(number, row, index)
            self_stresses.put(number, found.self_stresses[number], index)
        idle.put(0, dict.fromkeys(spare, 1.0), index)
    return Reduced(rows.rows, sources.rows, left.rows, self_stresses.rows), idle.rows[0]


def _placed(free: list[int], kept: list[int]) -> tuple[dict[int, int], list[int]]:
    """What stands for each free unknown, itself where it can; and what stands for none."""
    place = {key: key for key in free if key in kept}
    spare = [key for key in kept if key not in place]
    for key in free:
        if key not in place:
            place[key] = spare.pop(0)
    return place, spare


class _Spread:
    """Rows put together from those at parts of the entries of a batch shape; zero at the others."""

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        self.rows: dict[int, Row] = {}

    def put(self, number: int, row: Row, index: tuple[Index, ...]) -> None:
        """Put a row in at some entries."""
        own = self.rows.setdefault(number, {})
        for key, value in row.items():
            kind = np.result_type(value, own.get(key, 0.0))
            whole = np.asarray(own.get(key, np.zeros(self.shape))).astype(kind, copy=False)
            whole[index] = value
            own[key] = whole
