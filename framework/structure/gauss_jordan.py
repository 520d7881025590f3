"""Gauss-Jordan elimination of the constraints of loops, over such batch entries as one choice of pivots suits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..entries import Entries
from .edge import Edge
from .parts import Row, Value, add_row, product, unknowns

# A coefficient smaller than this share of what such coefficients are made of is rounding.
ROUNDING = 1e-11
# A pivot may be this share of the largest coefficient of an entry: as much is lost of the digits there. First for one
# choice for all entries, then for that of parts of them. Of pivots that are one but for rounding the first is taken, so
# that an entry alone makes the choice that it makes beside others.
SUITS, SUITS_WELL, ALONE = 1e-3, 0.3, 1.0 - 1e-9

Mask = NDArray[np.bool_]
# A constraint, the unknown to solve it for, and entries that this suits.
Choice = tuple[int, int, Mask]
_EVERYWHERE = np.ones((), dtype=bool)


@dataclass
class Constraint:
    """``row = 0``, from one component of an edge.

    Attributes
    ----------
    row
        Over the unknowns and the right-hand-side parameters.
    edge, component
        Where it comes from.
    size
        Length that arms in the frame are made of.
    """

    row: Row
    edge: Edge
    component: int
    size: float

    def scaled(self, key: int, value: Value) -> Value:
        """A coefficient in units of what it is made of: direction cosines, or arms where a rotation displaces."""
        return value / self.size if self.component < 3 and key % 6 >= 3 else value


@dataclass
class Reduced:
    """Constraints solved for as many unknowns as they determine.

    Attributes
    ----------
    rows
        By dependent unknown: its row over the free unknowns and the right-hand-side parameters.
    sources
        By dependent unknown: the combination of the given constraints that determines it.
    left
        By the number of a constraint that follows from the others: what these leave of it.
    self_stresses
        By the same: the combination of the given constraints that is zero, forces that need no load.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    left: dict[int, Row] = field(default_factory=dict)
    self_stresses: dict[int, Row] = field(default_factory=dict)


def reduced(given: dict[int, Constraint], entries: Entries, share: float = SUITS) -> Reduced | Mask:
    """Solve constraints, at each turn the one with the largest coefficient left, for that.

    A coefficient counts by its least size over the entries. Constraints go in the order of their pivots, so that nearly
    dependent ones come last and spoil no others.

    Parameters
    ----------
    given
        The constraints by number.
    entries
        At which of the batch.
    share
        How small a pivot may be beside the largest coefficient of an entry; one for the choice of the entry alone.

    Returns
    -------
    Reduced or ndarray
        Where no pivot suits all entries, which of them one suits well.
    """
    out = Reduced()
    waiting = {index: _Waiting(each, _at(each.row, entries), {index: 1.0}) for index, each in given.items()}
    while waiting:
        index, pivot, suited = _pivot(waiting, share)
        if pivot is None:
            break
        if not suited.all():
            return suited
        chosen = waiting.pop(index)
        row = chosen.row
        inverse = -1.0 / row.pop(pivot)
        new = {key: product(value, inverse) for key, value in row.items()}
        source = {key: product(value, inverse) for key, value in chosen.source.items()}
        for dependent in out.rows:
            _substitute(out.rows[dependent], out.sources[dependent], pivot, new, source)
        for other in waiting.values():
            if _substitute(other.row, other.source, pivot, new, source):
                other.look()
        out.rows[pivot], out.sources[pivot] = new, source
    out.left = {index: each.row for index, each in waiting.items()}
    out.self_stresses = {index: each.source for index, each in waiting.items()}
    return out


class _Waiting:
    """A constraint that is yet to be solved, with the others put into it, and what it may best be solved for."""

    def __init__(self, constraint: Constraint, row: Row, source: Row) -> None:
        self.constraint, self.row, self.source = constraint, row, source
        self.look()

    def look(self) -> None:
        """Find the largest coefficient."""
        least = {key: float(np.min(size)) for key, size in self.sizes.items()}
        self.size = max(least.values(), default=0.0)
        self.pivot = min((key for key, size in least.items() if size >= ALONE * self.size), default=None)

    @property
    def sizes(self) -> Row:
        """Sizes of the coefficients of unknowns, scaled."""
        return {key: np.abs(self.constraint.scaled(key, self.row[key])) for key in unknowns(self.row)}


def _at(row: Row, entries: Entries) -> Row:
    return {key: entries(value, 0) if isinstance(value, np.ndarray) else value for key, value in row.items()}


def _pivot(waiting: dict[int, _Waiting], share: float) -> tuple[int, int | None, Mask]:
    """Constraint to go next, the unknown to solve it for (None where all that is left is rounding), and entries that it
    suits."""
    most = max(each.size for each in waiting.values())
    index, first = next((index, each) for index, each in waiting.items() if each.size >= ALONE * most)
    if first.pivot is not None and first.size >= share != ALONE:
        return index, first.pivot, _EVERYWHERE
    largest = np.zeros(())
    for each in waiting.values():
        for size in each.sizes.values():
            largest = np.maximum(largest, size)
    if np.all(largest <= ROUNDING):
        return index, None, _EVERYWHERE
    if first.pivot is not None and share != ALONE and _suited(first.sizes[first.pivot], largest, share).all():
        return index, first.pivot, _EVERYWHERE
    left = ((number, key, size) for number, each in waiting.items() for key, size in sorted(each.sizes.items()))
    choices = [(number, key, _suited(size, largest, max(share, SUITS_WELL))) for number, key, size in left]
    return max(_first(choices) if share == ALONE else choices, key=lambda choice: int(choice[2].sum()))


def _first(choices: list[Choice]) -> Iterator[Choice]:
    """Each choice at the entries that it is the first to suit."""
    taken: Mask = np.zeros((), dtype=bool)
    for index, key, suited in choices:
        yield index, key, suited & ~taken
        taken = taken | suited


def _suited(size: Value, largest: Array, share: float) -> Mask:
    """Entries at which a coefficient is as good a pivot as any but for a share, of the shape of `largest`."""
    return np.asarray((size >= share * largest) & (largest > ROUNDING))


def _substitute(row: Row, source: Row, pivot: int, new: Row, combination: Row) -> bool:
    """Put ``pivot = new`` into a row; whether the row had it."""
    if pivot not in row:
        return False
    factor = row.pop(pivot)
    add_row(row, new, factor)
    add_row(source, combination, factor)
    return True
