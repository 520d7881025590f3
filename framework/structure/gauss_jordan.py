"""Gauss-Jordan elimination of loop constraints, with one choice of pivots for as many batch entries as possible."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..entries import Entries
from .edge import Edge
from .parts import Row, Value, add_row, product, unknowns

# A scaled coefficient smaller than this is rounding.
ROUNDING = 1e-11
# Least ratio of a pivot to the largest coefficient of a batch entry, which bounds the loss of digits: SUITS for one
# choice for all entries, SUITS_WELL for parts of them. Coefficients that agree within ALONE count as equal, and the
# first of them is taken, so that an entry makes the same choice alone as in a batch.
SUITS, SUITS_WELL, ALONE = 1e-3, 0.3, 1.0 - 1e-9

Mask = NDArray[np.bool_]
# Number of a constraint, the unknown to solve it for, and a mask of the entries at which that is a good pivot.
Choice = tuple[int, int, Mask]
_EVERYWHERE = np.ones((), dtype=bool)


@dataclass
class Constraint:
    """The equation ``row = 0`` of one ideal component of an edge that closes a loop.

    Attributes
    ----------
    row
        Row over unknowns and right-hand-side parameters.
    edge, component
        The edge and the index of its component.
    size
        Size of the frame, by which coefficients of rotations are scaled.
    """

    row: Row
    edge: Edge
    component: int
    size: float

    def scaled(self, key: int, value: Value) -> Value:
        """A coefficient made dimensionless: that of a displacement by a rotation, an arm, is divided by `size`."""
        return value / self.size if self.component < 3 and key % 6 >= 3 else value


@dataclass
class Reduced:
    """Constraints solved for as many unknowns as they determine.

    Attributes
    ----------
    rows
        For each dependent unknown: its row over free unknowns and right-hand-side parameters.
    sources
        For each dependent unknown: the combination of the given constraints that determines it.
    left
        By number of a redundant constraint: what remains of its row after elimination.
    self_stresses
        By number of a redundant constraint: the combination of constraints that vanishes, a state of self-stress.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    left: dict[int, Row] = field(default_factory=dict)
    self_stresses: dict[int, Row] = field(default_factory=dict)


def reduced(given: dict[int, Constraint], entries: Entries, share: float = SUITS) -> Reduced | Mask:
    """Solve constraints, in each step the one with the largest coefficient, for the unknown of that coefficient.

    The size of a coefficient is its least over the entries. Nearly dependent constraints have small pivots and come
    last, so that they do not spoil the others.

    Parameters
    ----------
    given
        The constraints by number.
    entries
        The batch entries to consider.
    share
        Least ratio of a pivot to the largest coefficient of an entry; `ALONE` for the choice of each entry alone.

    Returns
    -------
    Reduced or ndarray
        The solved constraints; or, where no pivot suits all entries, a mask of entries that one pivot suits well.
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
    """A constraint that is not yet solved, the solved ones being substituted, and the best unknown to solve it for."""

    def __init__(self, constraint: Constraint, row: Row, source: Row) -> None:
        self.constraint, self.row, self.source = constraint, row, source
        self.look()

    def look(self) -> None:
        """Find the largest coefficient and its unknown."""
        least = {key: float(np.min(size)) for key, size in self.sizes.items()}
        self.size = max(least.values(), default=0.0)
        self.pivot = min((key for key, size in least.items() if size >= ALONE * self.size), default=None)

    @property
    def sizes(self) -> Row:
        """Absolute values of the scaled coefficients of unknowns."""
        return {key: np.abs(self.constraint.scaled(key, self.row[key])) for key in unknowns(self.row)}


def _at(row: Row, entries: Entries) -> Row:
    return {key: entries(value, 0) if isinstance(value, np.ndarray) else value for key, value in row.items()}


def _pivot(waiting: dict[int, _Waiting], share: float) -> tuple[int, int | None, Mask]:
    """The next constraint, the unknown to solve it for (None if only rounding is left), and the entries it suits."""
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
    """The choices, each restricted to the entries that no earlier one suits."""
    taken: Mask = np.zeros((), dtype=bool)
    for index, key, suited in choices:
        yield index, key, suited & ~taken
        taken = taken | suited


def _suited(size: Value, largest: Array, share: float) -> Mask:
    """Entries at which a coefficient is at least `share` of the largest, of the shape of `largest`."""
    return np.asarray((size >= share * largest) & (largest > ROUNDING))


def _substitute(row: Row, source: Row, pivot: int, new: Row, combination: Row) -> bool:
    """Substitute ``pivot = new`` in a row; whether the row contained the pivot."""
    if pivot not in row:
        return False
    factor = row.pop(pivot)
    add_row(row, new, factor)
    add_row(source, combination, factor)
    return True
