"""Constraints by ideal joints that close a loop: exact elimination of dependent unknowns, without penalty stiffness."""

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
from .varying_pivots import by_entry

__all__ = ["Constraint", "Contradiction", "Elimination", "eliminate"]


class Contradiction(FrameError):
    """Imposed displacements in loops of ideal joints contradict each other at some `entries`, a mask (...)."""

    def __init__(self, text: str, entries: NDArray[np.bool_]) -> None:
        super().__init__(text)
        self.entries = entries


@dataclass
class Elimination:
    """Dependent unknowns as linear combinations of the free ones.

    Where a loop makes other unknowns dependent at some batch entries than at others, `rows` holds all of them, over the
    remaining unknowns. A remaining unknown may have a row, too: where it is dependent, it represents another unknown
    that is free there.

    Attributes
    ----------
    rows
        For each unknown that is dependent at some entry: its row over free unknowns and right-hand-side parameters.
    sources
        For each of these unknowns: the combination of the given constraints that determines it.
    given
        The constraints.
    idle
        For each remaining unknown: one at entries at which it represents no displacement, because the loop has fewer
        free unknowns there, and zero at the others.
    self_stresses
        By number of a redundant constraint: the combination of constraints that vanishes, which is a state of
        self-stress; zero at entries at which the constraint is not redundant.
    """

    rows: dict[int, Row] = field(default_factory=dict)
    sources: dict[int, Row] = field(default_factory=dict)
    given: list[Constraint] = field(default_factory=list)
    idle: dict[int, Value] = field(default_factory=dict)
    self_stresses: dict[int, Row] = field(default_factory=dict)

    @property
    def count(self) -> int:
        """Number of unknowns that are eliminated at all entries."""
        kept = {key for row in self.rows.values() for key in row}
        return len(self.rows.keys() - kept)

    def substituted(self, row: Row) -> Row:
        """`row` with dependent unknowns replaced by free ones."""
        if not any(key in self.rows for key in row):
            return row
        new: Row = {}
        for key, value in row.items():
            add_row(new, self.rows.get(key, {key: 1.0}), value)
        return new


def eliminate(
    rhs_parameters: RightHandSideParameters, given: list[Constraint], absent: NDArray[np.bool_] | None
) -> Elimination:
    """Solve constraints for dependent unknowns, the same for all batch entries where possible.

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
    """Contradiction of a redundant constraint, (...): its imposed value less that by the others; zero if rounding."""
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
