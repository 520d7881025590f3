"""Ideal components of edges that close a loop: dependent unknowns, eliminated exactly and without penalty."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from ..errors import FrameError
from .edge import Edge
from .parts import RightHandSideParameters, Row, Value, add_row, combine, product, unknowns

# A coefficient smaller than this share of what such coefficients are made of is rounding.
_ROUNDING = 1e-11


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
class Elimination:
    """Dependent unknowns as combinations of the free ones.

    Attributes
    ----------
    rows
        By dependent unknown: its row over the free unknowns and the right-hand-side parameters.
    sources
        By dependent unknown: the combination of the given constraints that determines it.
    given
        The constraints.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    given: list[Constraint] = field(default_factory=list)

    def substituted(self, row: Row) -> Row:
        """`row` over the free unknowns only."""
        if not any(key in self.rows for key in row):
            return row
        new: Row = {}
        for key, value in row.items():
            add_row(new, self.rows.get(key, {key: 1.0}), value)
        return new


def eliminate(rhs_parameters: RightHandSideParameters, given: list[Constraint]) -> Elimination:
    """Gauss-Jordan elimination of constraints, at each turn of the one with the largest coefficient left, for that.

    A coefficient counts by its least size over the batch. Constraints go in the order of their pivots, so that nearly
    dependent ones come last and spoil no others.

    Raises
    ------
    FrameError
        Where a redundant constraint contradicts the others.
    """
    out = Elimination(given=given)
    waiting = {
        index: _Waiting(constraint, dict(constraint.row), {index: 1.0}) for index, constraint in enumerate(given)
    }
    while waiting:
        index = max(waiting, key=lambda index: waiting[index].size)
        if waiting[index].size <= _ROUNDING:
            break
        chosen = waiting.pop(index)
        pivot, row = chosen.pivot, chosen.row
        assert pivot is not None  # its size is above zero
        inverse = -1.0 / row.pop(pivot)
        new = {key: product(value, inverse) for key, value in row.items()}
        source = {key: product(value, inverse) for key, value in chosen.source.items()}
        for dependent in out.rows:
            _substitute(out.rows[dependent], out.sources[dependent], pivot, new, source)
        for other in waiting.values():
            if _substitute(other.row, other.source, pivot, new, source):
                other.look()
        out.rows[pivot], out.sources[pivot] = new, source
    for left in waiting.values():
        _check_redundant(rhs_parameters, left.constraint, left.row)
    return out


class _Waiting:
    """A constraint that is yet to be solved, with the others put into it, and what it may best be solved for."""

    def __init__(self, constraint: Constraint, row: Row, source: Row) -> None:
        self.constraint, self.row, self.source = constraint, row, source
        self.look()

    def look(self) -> None:
        """Find the largest coefficient."""
        scaled = {key: self.constraint.scaled(key, self.row[key]) for key in unknowns(self.row)}
        least = {key: float(np.min(np.abs(value))) for key, value in scaled.items()}
        self.pivot = max(least, key=lambda key: least[key], default=None)
        self.size = 0.0 if self.pivot is None else least[self.pivot]


def _substitute(row: Row, source: Row, pivot: int, new: Row, combination: Row) -> bool:
    """Put ``pivot = new`` into a row; whether the row had it."""
    if pivot not in row:
        return False
    factor = row.pop(pivot)
    add_row(row, new, factor)
    add_row(source, combination, factor)
    return True


def _check_redundant(rhs_parameters: RightHandSideParameters, constraint: Constraint, row: Row) -> None:
    edge = constraint.edge
    what = f"{edge.kind} {edge.name!r}" if edge.name else edge.kind
    left = [np.abs(constraint.scaled(key, row[key])) for key in unknowns(row)]
    if any(_size(each) > _ROUNDING for each in left):
        turned = np.min(reduce(np.maximum, left)) > _ROUNDING
        raise FrameError(
            f"component {constraint.component} of {what} closes a loop of ideal joints that "
            + (
                "ties other coordinates at some batch entries than at others"
                if turned
                else "is singular at some batch entries only"
            )
            + ": solve those apart, or give the joint a finite stiffness"
        )
    gaps = [(value, rhs_parameters.values[-1 - key]) for key, value in row.items() if key < 0]
    if _size(combine(gaps)) > _ROUNDING * max((_size(combine([gap])) for gap in gaps), default=0.0):
        raise FrameError(
            f"component {constraint.component} of {what} contradicts the other supports and ideal joints "
            f"by {_size(combine(gaps)):.3g}: release one of them"
        )


def _size(value: Value) -> float:
    return float(np.max(np.abs(value)))
