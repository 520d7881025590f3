"""Ideal components of edges that close a loop: dependent unknowns, eliminated exactly and without penalty."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import reduce

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..entries import WHOLE
from ..errors import FrameError
from .gauss_jordan import ROUNDING, Constraint, Reduced, reduced
from .parts import RightHandSideParameters, Row, Value, add_row, combine, product
from .turned import by_entry

__all__ = ["Constraint", "Contradiction", "Elimination", "eliminate"]


class Contradiction(FrameError):
    """What is imposed on loops of ideal joints fits no motion at some `entries`, (...)."""

    def __init__(self, text: str, entries: NDArray[np.bool_]) -> None:
        super().__init__(text)
        self.entries = entries


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


def eliminate(
    rhs_parameters: RightHandSideParameters, given: list[Constraint], absent: NDArray[np.bool_] | None
) -> Elimination:
    """Solve constraints for unknowns, by one choice of these for all batch entries where one suits all.

    Raises
    ------
    Contradiction
        Where a redundant constraint contradicts the others, at entries that are not `absent`.
    """
    numbered = dict(enumerate(given))
    found, idle = reduced(numbered, WHOLE), dict[int, Value]()
    if not isinstance(found, Reduced):
        found, idle = by_entry(numbered)
    gaps = {number: _gap(rhs_parameters, row) for number, row in found.left.items()}
    wrong = {number: gap > 0.0 if absent is None else (gap > 0.0) & ~absent for number, gap in gaps.items()}
    contradicting = [number for number, where in wrong.items() if where.any()]
    if contradicting:
        first, entries = contradicting[0], reduce(np.logical_or, wrong.values())
        raise Contradiction(_contradiction(given[first], wrong[first], gaps[first]), entries)
    return Elimination(found.rows, found.sources, given, idle, found.self_stresses)


def _gap(rhs_parameters: RightHandSideParameters, row: Row) -> Array:
    """What is imposed on a constraint beyond what follows from the others, (...); zero where that is rounding."""
    known = [np.asarray(product(value, rhs_parameters.values[-1 - key])) for key, value in row.items() if key < 0]
    if not known:
        return np.zeros(())
    gap = np.abs(combine((1.0, each) for each in known))
    return np.where(gap > ROUNDING * reduce(np.maximum, map(np.abs, known)), gap, 0.0)


def _contradiction(constraint: Constraint, wrong: NDArray[np.bool_], gap: Array) -> str:
    edge = constraint.edge
    what = f"{edge.kind} {edge.name!r}" if edge.name else edge.kind
    where = f" at batch entry {tuple(np.argwhere(wrong)[0].tolist())}" if wrong.size > 1 and not wrong.all() else ""
    return (
        f"component {constraint.component} of {what} contradicts the other supports and ideal joints{where} "
        f"by {np.max(np.where(wrong, gap, 0.0)):.3g}: release one of them"
    )
