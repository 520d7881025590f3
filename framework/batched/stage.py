"""Equations in the course of their elimination: each entry of matrix and loads has a batch shape of its own.

The steps, of which only those are carried out that are wanted, are those of `framework.ldl`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from ..ldl import Pivot, eliminated_parts, forward_parts
from ..structure.parts import Loads, Matrix, Parts, Row, Value, add, add_row, enter, total
from .order import Order

# A pivot ratio below this suggests a singular matrix, which is then examined more closely.
SUSPECT = 1e-11

Forces = Loads


@dataclass
class Stage:
    """A symmetric system of equations in the course of its elimination.

    Attributes
    ----------
    matrix
        Parts of the entries that are not yet eliminated.
    forces
        By unknown and right-hand-side parameter: parts of the load per unit of that parameter. The load of an
        eliminated unknown stays here for the back substitution.
    scale
        Parts of the scale of each diagonal entry: the assembled diagonal, growing with the elimination.
    pivots
        Steps that are done, by unknown.
    pivot_ratio
        Least pivot ratio by mask: zero to rounding where the matrix is singular.
    complete
        Whether all operations so far were wanted, and none was left to the chunks.
    """

    matrix: Matrix = field(default_factory=dict)
    forces: Forces = field(default_factory=dict)
    scale: dict[int, Parts] = field(default_factory=dict)
    pivots: dict[int, Pivot] = field(default_factory=dict)
    pivot_ratio: Parts = field(default_factory=dict)
    complete: bool = True

    def put(self, i: int, j: int, mask: int, value: Value) -> None:
        """Add a part to the entry (i, j), and to the scale if it is on the diagonal."""
        enter(self.matrix, i, j, mask, value)
        if i == j:
            add(self.scale.setdefault(i, {}), mask, value)

    def force(self, i: int, source: int) -> Parts:
        """Parts of the load on unknown i per unit of a right-hand-side parameter, created if missing."""
        return self.forces.setdefault(i, {}).setdefault(source, {})

    def copy(self) -> Stage:
        """A copy without the pivot ratios."""
        new = Stage(forces={i: {s: dict(parts) for s, parts in by.items()} for i, by in self.forces.items()})
        for i, row in self.matrix.items():
            for j, parts in row.items():
                if j >= i:
                    new.matrix.setdefault(i, {})[j] = new.matrix.setdefault(j, {})[i] = dict(parts)
        new.scale = {i: dict(parts) for i, parts in self.scale.items()}
        new.pivots = dict(self.pivots)
        return new

    def mapped(self, change: Callable[[Value], Value]) -> Stage:
        """A copy with `change` applied to every number, without the pivot ratios."""
        copy = Stage()
        for i, row in self.matrix.items():
            for j, parts in row.items():
                if j >= i:
                    new = {mask: change(value) for mask, value in parts.items()}
                    copy.matrix.setdefault(i, {})[j] = new
                    copy.matrix.setdefault(j, {})[i] = new
        copy.scale = {i: {m: change(v) for m, v in parts.items()} for i, parts in self.scale.items()}
        copy.forces, copy.pivots = mapped_forces(self.forces, change), self._mapped_pivots(change)
        return copy

    def mapped_steps(self, change: Callable[[Value], Value]) -> Stage:
        """A copy of steps, loads and pivot ratios alone, with `change` applied to every number."""
        pivot_ratio = {mask: change(value) for mask, value in self.pivot_ratio.items()}
        forces, pivots = mapped_forces(self.forces, change), self._mapped_pivots(change)
        return Stage(forces=forces, pivots=pivots, pivot_ratio=pivot_ratio, complete=self.complete)

    def _mapped_pivots(self, change: Callable[[Value], Value]) -> dict[int, Pivot]:
        return {
            k: Pivot(p.mask, change(p.inverse), {j: change(v) for j, v in p.lower.items()})
            for k, p in self.pivots.items()
        }

    def eliminate(self, order: Order, wanted: Sequence[bool]) -> None:
        """Carry out the steps of `order` whose mask is `wanted`."""
        steps = [(k, order.below[k], order.masks[k]) for k in order.pivots if wanted[order.masks[k]]]
        if steps:
            self.pivots |= eliminated_parts(self.matrix, self.scale, self.pivot_ratio, steps)

    def forward(self, order: Order, wanted: Sequence[bool]) -> None:
        """Forward substitution of the loads of eliminated unknowns, as far as the mask of the result is `wanted`."""
        steps = [(k, self.pivots[k]) for k in order.pivots if k in self.pivots]
        if any(self.forces.get(k) for k, _ in steps):
            self.complete &= forward_parts(steps, self.forces, wanted)


def mapped_forces(forces: Forces, change: Callable[[Value], Value]) -> Forces:
    """Loads with `change` applied to every number."""
    return {i: {s: {m: change(v) for m, v in parts.items()} for s, parts in by.items()} for i, by in forces.items()}


def mapped_row(row: Row, change: Callable[[Value], Value]) -> Row:
    """A row with `change` applied to every factor."""
    return {k: change(value) for k, value in row.items()}


def closure(order: Order, wanted: set[int]) -> set[int]:
    """The `wanted` unknowns and all unknowns that their back substitution needs."""
    needed = set(wanted)
    for k in order.pivots:
        if k in needed:
            needed.update(order.below[k])
    return needed


def carried(order: Order, row: Row, stage: Stage) -> Row:
    """`row` with the unknowns that `stage` has eliminated expressed in the others and the right-hand-side parameters.

    This is the transpose of the back substitution, carried out for the rows wanted instead of for the loads.
    """
    out = dict(row)
    for k in order.pivots:
        if k in out and k in stage.pivots:
            factor = out.pop(k)
            step = stage.pivots[k]
            if by_source := stage.forces.get(k):
                loads = {-1 - source: total(parts)[1] for source, parts in by_source.items()}
                add_row(out, loads, factor * step.inverse)
            for j, low in step.lower.items():
                term = low * factor
                out[j] = out[j] - term if j in out else -term
    return out
