"""Ideal components of edges that close a loop: dependent unknowns, eliminated exactly and without penalty."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .errors import FrameError
from .parts import Knowns, Row, Value, add_row, combine, unknowns

if TYPE_CHECKING:
    from .tree import Edge

# A coefficient smaller than this share of what such coefficients are made of is rounding.
_ROUNDING = 1e-11


@dataclass
class Constraint:
    """``row = 0``, from one component of an edge.

    Attributes
    ----------
    row
        Over the unknowns and the known numbers.
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
        By dependent unknown: its row over the free unknowns and the known numbers.
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


def eliminate(knowns: Knowns, given: list[Constraint]) -> Elimination:
    """Gauss-Jordan elimination of constraints, each solved for its largest coefficient.

    Raises
    ------
    FrameError
        Where a redundant constraint contradicts the others.
    """
    out = Elimination(given=given)
    for index, constraint in enumerate(given):
        row = dict(out.substituted(constraint.row))
        source: Row = {index: 1.0}
        for key, value in constraint.row.items():
            if key in out.rows:
                add_row(source, out.sources[key], value)
        least = {key: float(np.min(np.abs(constraint.scaled(key, row[key])))) for key in unknowns(row)}
        pivot = max(least, key=lambda key: least[key], default=None)
        if pivot is None or least[pivot] <= _ROUNDING:
            _check_redundant(knowns, constraint, row)
            continue
        inverse = -1.0 / row.pop(pivot)
        new = {key: combine([(value, inverse)]) for key, value in row.items()}
        _substitute(out, pivot, new, {key: combine([(value, inverse)]) for key, value in source.items()})
    return out


def _substitute(out: Elimination, pivot: int, row: Row, source: Row) -> None:
    for key in out.rows:
        if pivot in out.rows[key]:
            factor = out.rows[key].pop(pivot)
            add_row(out.rows[key], row, factor)
            add_row(out.sources[key], source, factor)
    out.rows[pivot], out.sources[pivot] = row, source


def _check_redundant(knowns: Knowns, constraint: Constraint, row: Row) -> None:
    edge = constraint.edge
    what = f"{edge.kind} {edge.name!r}" if edge.name else edge.kind
    if any(_size(constraint.scaled(key, row[key])) > _ROUNDING for key in unknowns(row)):
        raise FrameError(
            f"component {constraint.component} of {what} closes a loop of ideal joints that is singular at some "
            "batch entries only: solve those apart, or give the joint a finite stiffness"
        )
    gaps = [(value, knowns.values[-1 - key]) for key, value in row.items() if key < 0]
    if _size(combine(gaps)) > _ROUNDING * max((_size(combine([gap])) for gap in gaps), default=0.0):
        raise FrameError(
            f"component {constraint.component} of {what} contradicts the other supports and ideal joints "
            f"by {_size(combine(gaps)):.3g}: release one of them"
        )


def _size(value: Value) -> float:
    return float(np.max(np.abs(value)))
