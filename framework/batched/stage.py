"""LDL^T with broadcasting: every entry of the matrix and of the loads has a batch shape of its own.

The recurrence is that of `framework.ldl`, for entries that are sums of parts over different batch axes. It has a text
of its own because most columns hold few entries, many of them single numbers: a step then takes some ten microseconds,
and up to three times as long where its entries are first gathered for operations on whole columns. It also tracks the
scale of each diagonal entry, and eliminates only the steps that are wanted.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from ..structure.parts import (
    Loads,
    Matrix,
    Parts,
    Row,
    Value,
    add,
    add_row,
    collapsed_each,
    column,
    enter,
    total,
)
from .order import Order

# A pivot ratio below this suggests a singular matrix, which is then examined more closely.
SUSPECT = 1e-11

Forces = Loads


@dataclass(frozen=True)
class Pivot:
    """One step of LDL^T: its mask, the inverse pivot, and the column of L by unknown."""

    mask: int
    inverse: Value
    lower: dict[int, Value]


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
        for k in order.pivots:
            if wanted[order.masks[k]]:
                self._step(k, order.below[k], order.masks[k])

    def _step(self, k: int, below: list[int], mask: int) -> None:
        row = self.matrix.pop(k, {})
        (varying, pivot), (over, weight), columns = column(row, k, below, self.scale.pop(k, {}))
        inverse = reciprocal(pivot)
        lower = {j: value * inverse for j, _, value in columns}
        carried = weight * inverse
        self._judge(varying | over, carried)
        for a, (i, own, value) in enumerate(columns):
            del self.matrix[i][k]
            low = lower[i]
            filled = self.matrix.setdefault(i, {})
            taken = low * value
            scale, axes, term = self.scale.setdefault(i, {}), own | varying | over, taken * carried
            scale[axes] = scale[axes] + term if axes in scale else term
            for j, other, value in columns[a:]:
                if j not in filled:
                    filled[j] = self.matrix.setdefault(j, {})[i] = {}
                subtract(filled[j], own | other | varying, taken if j == i else low * value)
        self.pivots[k] = Pivot(mask, inverse, lower)

    def _judge(self, mask: int, carried: Value) -> None:
        """Update the least pivot ratio, where `carried` is the scale over the pivot.

        With the earlier unknowns relaxed, a unit motion of an unknown has a shape z; the pivot is its energy ``z.A z``,
        whose rounding is that of ``z.diag(A) z``. The scale is an upper bound on the latter.
        """
        ratio = reciprocal(carried)
        self.pivot_ratio[mask] = np.minimum(self.pivot_ratio[mask], ratio) if mask in self.pivot_ratio else ratio

    def forward(self, order: Order, wanted: Sequence[bool]) -> None:
        """Forward substitution of the loads of eliminated unknowns, as far as the mask of the result is `wanted`."""
        for k in order.pivots:
            if k not in self.pivots:
                continue
            step = self.pivots[k]
            for source, parts in self.forces.get(k, {}).items():
                for mask, value in parts.items():
                    if not wanted[mask | step.mask]:
                        self.complete = False
                        continue
                    for j, low in step.lower.items():
                        subtract(self.force(j, source), mask | step.mask, low * value)


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


def backward(
    order: Order, needed: set[int], known: dict[int, Value], stage: Stage, rhs_parameters: Sequence[Value]
) -> None:
    """Back substitution: add the values of the `needed` unknowns to those `known`."""
    pivots = [k for k in reversed(order.pivots) if k in needed]
    loads = collapsed_each([stage.forces.get(k, {}) for k in pivots], rhs_parameters)
    for k, load in zip(pivots, loads, strict=True):
        step = stage.pivots[k]
        value = load * step.inverse
        for j, low in step.lower.items():
            other = known[j]
            if isinstance(other, np.ndarray) or other != 0.0:
                value = value - low * other
        known[k] = value


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


def subtract(parts: Parts, mask: int, value: Value) -> None:
    """Subtract `value`, which varies over `mask`, from a sum of parts."""
    parts[mask] = parts[mask] - value if mask in parts else -value


def reciprocal(value: Value) -> Value:
    """1 / value; inf for an exact zero, which makes the pivot ratio zero."""
    return np.inf if not isinstance(value, np.ndarray) and value == 0.0 else 1.0 / value
