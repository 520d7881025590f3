"""Ideal components of edges that close a loop: dependent unknowns, eliminated exactly and without penalty."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from .errors import FrameError
from .parts import Grid, Row, Value, add_row, combine

if TYPE_CHECKING:
    from .tree import Edge

# A row smaller than this share of what it was made of is a redundant constraint.
_REDUNDANT = 1e-11


@dataclass
class Constraint:
    """``row . q + gap = 0``, from one component of an edge."""

    row: Row
    gap: Value
    edge: Edge
    component: int


@dataclass
class Elimination:
    """Dependent unknowns as combinations of the free ones.

    Attributes
    ----------
    rows, knowns
        By dependent unknown: its row over the free unknowns, and its known part.
    sources
        By dependent unknown: the combination of the given constraints that determines it.
    given
        The constraints.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    knowns: dict[int, Value] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    given: list[Constraint] = field(default_factory=list)

    def substituted(self, row: Row) -> tuple[Row, Value]:
        """`row` over the free unknowns only, and its known part."""
        if not any(key in self.rows for key in row):
            return row, 0.0
        new: Row = {}
        known: Value = 0.0
        for key, value in row.items():
            if key in self.rows:
                add_row(new, self.rows[key], value)
                known = combine([(1.0, known), (value, self.knowns[key])])
            else:
                add_row(new, {key: 1.0}, value)
        return new, known


def eliminate(grid: Grid, given: list[Constraint]) -> Elimination:
    """Gauss-Jordan elimination of constraints, each solved for its largest coefficient.

    Raises
    ------
    FrameError
        Where a redundant constraint contradicts the others.
    """
    out = Elimination(given=given)
    for index, constraint in enumerate(given):
        row, known = out.substituted(constraint.row)
        gap = combine([(1.0, constraint.gap), (1.0, known)])
        source: Row = {index: 1.0}
        for key, value in constraint.row.items():
            if key in out.rows:
                add_row(source, out.sources[key], value)
        scale = max((_size(value) for value in constraint.row.values()), default=1.0)
        pivot = max(row, key=lambda key: float(np.min(np.abs(row[key]))), default=None)
        if pivot is None or float(np.min(np.abs(row[pivot]))) <= _REDUNDANT * scale:
            _check_redundant(constraint, row, gap, scale)
            continue
        inverse = -1.0 / row.pop(pivot)
        new = {key: combine([(value, inverse)]) for key, value in row.items()}
        _substitute(out, pivot, new, combine([(gap, inverse)]), {k: combine([(v, inverse)]) for k, v in source.items()})
    return out


def _substitute(out: Elimination, pivot: int, row: Row, known: Value, source: Row) -> None:
    for key in out.rows:
        if pivot in out.rows[key]:
            factor = out.rows[key].pop(pivot)
            add_row(out.rows[key], row, factor)
            add_row(out.sources[key], source, factor)
            out.knowns[key] = combine([(1.0, out.knowns[key]), (factor, known)])
    out.rows[pivot], out.knowns[pivot], out.sources[pivot] = row, known, source


def _check_redundant(constraint: Constraint, row: Row, gap: Value, scale: float) -> None:
    edge = constraint.edge
    what = f"{edge.kind} {edge.name!r}" if edge.name else edge.kind
    if any(_size(value) > _REDUNDANT * scale for value in row.values()):
        raise FrameError(
            f"component {constraint.component} of {what} closes a loop of ideal joints that is singular at some "
            "batch entries only: solve those apart, or give the joint a finite stiffness"
        )
    if _size(gap) > _REDUNDANT * max(scale, _size(constraint.gap)):
        raise FrameError(
            f"component {constraint.component} of {what} contradicts the other supports and ideal joints "
            f"by {_size(gap):.3g}: release one of them"
        )


def _size(value: Value) -> float:
    return float(np.max(np.abs(value)))
