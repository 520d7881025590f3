"""Ideal components of edges that close a loop: dependent unknowns, eliminated exactly and without penalty."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce

import numpy as np

from ..entries import WHOLE
from ..errors import FrameError
from .gauss_jordan import ROUNDING, Constraint, Reduced, reduced
from .parts import RightHandSideParameters, Row, Value, add_row, combine, product
from .turned import by_entry

__all__ = ["Constraint", "Elimination", "eliminate"]


@dataclass
class Elimination:
    """Dependent unknowns as combinations of the free ones.

    Where a loop determines other unknowns at some batch entries than at others, `rows` has all of them, each over the
    unknowns that are left; one that is left may have a row, too, as it stands for another where it is determined.

    Attributes
    ----------
    rows
        By unknown that is dependent at some entry: its row over the free unknowns and the right-hand-side parameters.
    sources
        By the same: the combination of the given constraints that determines it.
    given
        The constraints.
    idle
        By unknown that is left, one at entries at which it stands for nothing, as the loop determines more there, and
        zero at the others.
    self_stresses
        By number of a constraint that follows from others: the combination of them that is zero, forces that need no
        load; zero at entries at which it follows from none.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    given: list[Constraint] = field(default_factory=list)
    idle: dict[int, Value] = field(default_factory=dict)
    self_stresses: dict[int, Row] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of unknowns that all entries have less."""
        kept = {key for row in self.rows.values() for key in row}
        return len(self.rows.keys() - kept)

    def substituted(self, row: Row) -> Row:
        """`row` over the free unknowns only."""
        if not any(key in self.rows for key in row):
            return row
        new: Row = {}
        for key, value in row.items():
            add_row(new, self.rows.get(key, {key: 1.0}), value)
        return new


def eliminate(rhs_parameters: RightHandSideParameters, given: list[Constraint]) -> Elimination:
    """Solve constraints for unknowns, by one choice of these for all batch entries where one suits all.

    Raises
    ------
    FrameError
        Where a redundant constraint contradicts the others.
    """
    numbered = dict(enumerate(given))
    found, idle = reduced(numbered, WHOLE), dict[int, Value]()
    if not isinstance(found, Reduced):
        found, idle = by_entry(numbered)
    for number, row in found.left.items():
        _check_redundant(rhs_parameters, given[number], row)
    return Elimination(found.rows, found.sources, given, idle, found.self_stresses)


def _check_redundant(rhs_parameters: RightHandSideParameters, constraint: Constraint, row: Row) -> None:
    """Refuse a constraint that follows from the others but for what is imposed on it."""
    known = [product(value, rhs_parameters.values[-1 - key]) for key, value in row.items() if key < 0]
    if not known:
        return
    gap = np.abs(combine((1.0, each) for each in known))
    wrong = np.asarray(gap > ROUNDING * reduce(np.maximum, map(np.abs, known)))
    if not wrong.any():
        return
    edge = constraint.edge
    what = f"{edge.kind} {edge.name!r}" if edge.name else edge.kind
    where = f" at batch entry {tuple(np.argwhere(wrong)[0].tolist())}" if wrong.size > 1 and not wrong.all() else ""
    raise FrameError(
        f"component {constraint.component} of {what} contradicts the other supports and ideal joints{where} "
        f"by {np.max(np.where(wrong, gap, 0.0)):.3g}: release one of them"
    )
