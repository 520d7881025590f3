"""The two stages of an elimination, as far as they have come, for the whole batch or for a chunk of it.

Matrix and loads go apart: what the elimination leaves of the matrix serves any load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..program.recording import Term
from ..structure.parts import (
    Factors,
    Row,
    Value,
    add_congruence,
    add_dyad,
    add_loads,
    add_row,
    add_squares,
    combine_each,
)
from .order import Masks, Order, Springs
from .stage import Forces, Stage, backward, carried, closure, mapped_forces, mapped_row

Wanted = Sequence[bool]


@dataclass
class PartialFactorisation:
    """Both stages and what turns the first into the second.

    Attributes
    ----------
    orders
        Elimination order of both stages.
    inner, outer
        The unknowns in the nodes' axes, and the joint-relative ones.
    rows, springs, rhs_parameters
        Displacements of nodes on joints, the springs on them, and the right-hand-side parameters.
    masks
        Batch axes over which rows and springs vary.
    imposed
        Load of known displacements on the second stage.
    complete
        Of both stages, whether all of the matrix that was come by could be done.
    """

    orders: tuple[Order, Order]
    inner: Stage
    outer: Stage
    rows: dict[int, Row]
    springs: Springs
    rhs_parameters: list[Value]
    masks: Masks
    imposed: Forces = field(default_factory=dict)
    complete: tuple[bool, bool] = (True, True)

    @classmethod
    def begun(
        cls,
        orders: tuple[Order, Order],
        assembled: Stage,
        rows: dict[int, Row],
        springs: Springs,
        rhs_parameters: list[Value],
        masks: Masks,
        wanted: Wanted,
    ) -> PartialFactorisation:
        """Both stages of what is `assembled`, eliminated and loaded as far as what varies so is `wanted`."""
        stage = assembled.copy()
        out = cls(orders, stage, Stage(), rows, springs, rhs_parameters, masks)
        out.factorise(wanted, given=True)
        out.load(wanted)
        return out

    # -- results ----------------------------------------------------------------------------------------------------

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows`, by back substitution of what they ask for."""
        inner, outer = self.orders
        asked = {k for row in rows for k in row if k >= 0}
        inside = closure(inner, asked & set(inner.below))
        ends = {a for a in inside if a not in inner.below}
        wanted = (asked - inside) | {k for a in ends for k in self.rows[a] if k >= 0}
        known = {-1 - s: value for s, value in enumerate(self.rhs_parameters)}
        backward(outer, closure(outer, wanted), known, self.outer, self.rhs_parameters)
        at_ends = dict(zip(ends, combine_each([self.rows[a] for a in ends], known), strict=True))
        backward(inner, inside, at_ends, self.inner, self.rhs_parameters)
        known.update({k: at_ends[k] for k in inside & set(inner.below)})
        return combine_each(rows, known)

    def carried(self, row: Row) -> Row:
        """`row` over the unknowns that are not eliminated yet and the right-hand-side parameters."""
        inner, outer = self.orders
        at_ends = carried(inner, row, self.inner)
        out: Row = {}
        for k, factor in at_ends.items():
            add_row(out, self.rows[k] if k not in row and k in self.rows else {k: 1.0}, factor)
        return carried(outer, out, self.outer)

    # -- what is kept of it -------------------------------------------------------------------------------------------

    @property
    def pivot_ratios(self) -> list[Value]:
        """Least pivot ratios found, by mask, in what was done on the way."""
        return [value for stage in (self.inner, self.outer) for value in stage.pivot_ratio.values()]

    @property
    def least(self) -> Value:
        """The least of them."""
        least: Value = np.inf
        for value in self.pivot_ratios:
            least = np.minimum(least, value)
        return least

    def mapped(self, change: Callable[[Value], Value]) -> PartialFactorisation:
        """What later reads and other loads need, with `change` applied to every number."""
        return replace(
            self,
            inner=self.inner.mapped(change),
            outer=self.outer.mapped(change),
            rows={a: mapped_row(row, change) for a, row in self.rows.items()},
            springs=[],
            rhs_parameters=[change(value) for value in self.rhs_parameters],
            imposed=mapped_forces(self.imposed, change),
        )

    def anew(self, take: Callable[[Value], Value]) -> PartialFactorisation:
        """What is done so far, with what stands for each number, to go on from."""
        inner, outer = self.inner.mapped(take), self.outer.mapped(take)
        rows = {a: mapped_row(row, take) for a, row in self.rows.items()}
        springs = [(mapped_row(row, take), take(stiffness)) for row, stiffness in self.springs]
        rhs_parameters = [take(value) for value in self.rhs_parameters]
        return PartialFactorisation(self.orders, inner, outer, rows, springs, rhs_parameters, self.masks)

    @property
    def terms(self) -> list[Term]:
        """All terms in that, each once, where it was recorded."""
        found: dict[int, Term] = {}

        def note(value: Value) -> Value:
            if isinstance(value, Term):
                found[value.number] = value
            return value

        self.mapped(note)
        return list(found.values())

    # -- the matrix -------------------------------------------------------------------------------------------------

    def factorise(self, wanted: Wanted, *, given: bool) -> None:
        """Eliminate as far as what varies so is `wanted`; springs as they were given are added where `given`."""
        inner, outer = self.orders
        self.inner.eliminate(inner, wanted)
        self._substitute(wanted)
        self._add_springs(wanted, given=given)
        self.outer.eliminate(outer, wanted)
        self.complete = self.inner.complete, self.outer.complete

    def forget(self) -> None:
        """Let go what only the elimination needed."""
        self.inner.matrix, self.inner.scale, self.outer.matrix, self.outer.scale = {}, {}, {}, {}

    def _substitute(self, wanted: Wanted) -> None:
        """Add T^T K T, - T^T K G and the diagonal's scale to the second stage."""
        inner, outer, rows = self.inner, self.outer, self._factors
        outer.complete &= add_congruence(outer.matrix, self.imposed, inner.matrix, rows, wanted)
        outer.complete &= add_squares(outer.scale, inner.scale, rows, wanted)

    @property
    def _factors(self) -> dict[int, Factors]:
        """The rows, each factor with the axes over which it varies."""
        masks = self.masks.rows
        return {a: [(k, factor, masks[a][k]) for k, factor in row.items()] for a, row in self.rows.items()}

    def _add_springs(self, wanted: Wanted, *, given: bool) -> None:
        """Add k r r^T and -k r times the known part of every spring to the second stage."""
        outer = self.outer
        for (row, stiffness), (masks, mask) in zip(self.springs, self.masks.springs, strict=True):
            factors, part = [(k, factor, masks[k]) for k, factor in row.items()], (mask, stiffness)
            # A stiffness as it was given is added whole, whatever its size: that costs nothing.
            outer.complete &= add_dyad(
                outer.matrix, self.imposed, part, factors, factors, wanted, given=given, scale=outer.scale
            )

    # -- the loads --------------------------------------------------------------------------------------------------

    def load(self, wanted: Wanted) -> None:
        """Carry the loads through what has been eliminated, as far as what varies so is `wanted`."""
        inner, outer = self.orders
        self.inner.forward(inner, wanted)
        for i, by_source in self.imposed.items():
            for source, parts in by_source.items():
                self.outer.force(i, source).update(parts)
        self.outer.complete &= add_loads(self.outer.forces, self.inner.forces, self._factors, wanted)
        self.outer.forward(outer, wanted)

    def loaded(self, inner: Forces, outer: Forces, rhs_parameters: list[Value]) -> PartialFactorisation:
        """The same elimination under other loads, which are yet to be carried through."""
        before, after = self.complete
        return replace(
            self,
            inner=replace(self.inner, forces=inner, complete=before),
            outer=replace(self.outer, forces=outer, complete=after),
            rhs_parameters=rhs_parameters,
        )
