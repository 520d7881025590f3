"""Loops whose dependent unknowns differ between batch entries, with one set of unknowns for the whole batch.

The entries are divided until one choice of pivots suits each part. Of the unknowns that are dependent in any part, as
many remain as are free in the part with the fewest dependent ones; at each entry, a remaining unknown represents one of
those that are free there.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from ..batch import Shape
from ..entries import WHOLE, Entries, Index
from .disjoint_sets import DisjointSets
from .gauss_jordan import ALONE, SUITS_WELL, Constraint, Mask, Reduced, reduced
from .parts import Row, Value, unknowns

# Indices of batch entries, one array for each axis, and their solved constraints.
Part = tuple[tuple[Index, ...], Reduced]


def by_entry(given: dict[int, Constraint]) -> tuple[Reduced, dict[int, Value]]:
    """Solve constraints for unknowns that may differ between batch entries.

    Parameters
    ----------
    given
        The constraints by number.

    Returns
    -------
    Reduced
        Rows of all unknowns that are dependent at some entry, over the remaining ones. A row may contain its own
        unknown, which then represents another one where it is dependent.
    dict
        For each remaining unknown, one at entries at which it represents no displacement and zero at the others.
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
    """Loops whose coefficients vary, each with its batch shape and its parts, in which every entry makes the choice of
    pivots that it would make alone.
    """
    out = []
    for loop in _loops(given):
        shape = _shape(loop.values())
        if np.prod(shape, dtype=np.int64) > 1:
            out.append((loop, shape, _solved(loop, np.nonzero(np.ones(shape, dtype=bool)), ALONE)))
    return out


def _loops(given: dict[int, Constraint]) -> list[dict[int, Constraint]]:
    """Constraints divided into sets that have no unknown in common."""
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
    """All entries of a batch shape, divided into parts with one choice of pivots each; `suited` is the first part."""
    everywhere = np.nonzero(np.ones(shape, dtype=bool))
    return _split(given, everywhere, np.broadcast_to(suited, shape).reshape(-1), SUITS_WELL)


def _solved(given: dict[int, Constraint], index: tuple[Index, ...], share: float) -> list[Part]:
    """Some entries, divided into as many parts as are needed."""
    found = reduced(given, Entries(index), share)
    if isinstance(found, Reduced):
        return [(index, found)]
    return _split(given, index, np.broadcast_to(found, index[0].shape), share)


def _split(given: dict[int, Constraint], index: tuple[Index, ...], suited: Mask, share: float) -> list[Part]:
    """Entries divided into those that a choice of pivots suits and the others, and further if needed."""
    return [part for mask in (suited, ~suited) for part in _solved(given, tuple(each[mask] for each in index), share)]


def _merged(parts: list[Part], shape: Shape) -> tuple[Reduced, dict[int, Value]]:
    """The parts of a loop merged; and for each remaining unknown, where it represents no displacement."""
    pivots = list(dict.fromkeys(key for _, found in parts for key in found.rows))
    # the part with the most free unknowns; of several, the largest
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
    """For each free unknown the kept one that represents it, itself if kept; and the kept ones that represent none."""
    place = {key: key for key in free if key in kept}
    spare = [key for key in kept if key not in place]
    for key in free:
        if key not in place:
            place[key] = spare.pop(0)
    return place, spare


class _Spread:
    """Rows that are put together from values at parts of the batch entries; zero elsewhere."""

    def __init__(self, shape: Shape) -> None:
        self.shape = shape
        self.rows: dict[int, Row] = {}

    def put(self, number: int, row: Row, index: tuple[Index, ...]) -> None:
        """Set the factors of a row at some entries."""
        own = self.rows.setdefault(number, {})
        for key, value in row.items():
            kind = np.result_type(value, own.get(key, 0.0))
            whole = np.asarray(own.get(key, np.zeros(self.shape))).astype(kind, copy=False)
            whole[index] = value
            own[key] = whole
