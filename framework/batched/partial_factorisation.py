"""An elimination in two stages that is carried out as far as wanted, for the whole batch or for a chunk of it.

The matrix is factorised apart from the loads, so that its factor serves any load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..ldl import backward_parts
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
from .stage import Forces, Stage, carried, closure, mapped_forces, mapped_row

Wanted = Sequence[bool]


@dataclass
class PartialFactorisation:
    """Both stages of an elimination, and the substitution that leads from the first to the second.

    Attributes
    ----------
    orders
        Orders of elimination of both stages.
    inner, outer
        The first stage, of unknowns in the nodes' axes, and the second, of joint-relative unknowns.
    rows, springs, rhs_parameters
        Rows of the displacements of nodes on joints, rows and stiffnesses of joint springs, and right-hand-side
        parameters.
    masks
        Masks of rows and springs.
    imposed
        Load of prescribed displacements and offsets on the second stage.
    complete
        For both stages, whether all matrix operations so far were wanted, and none was left to the chunks.
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
        """The `assembled` equations, eliminated and loaded as far as the masks of results are `wanted`."""
        stage = assembled.copy()
        out = cls(orders, stage, Stage(), rows, springs, rhs_parameters, masks)
        out.factorise(wanted, given=True)
        out.load(wanted)
        return out

    # -- results ----------------------------------------------------------------------------------------------------

    def values(self, rows: Sequence[Row], parameters: Sequence[Value] | None = None) -> list[Value]:
        """Values of rows, by back substitution of the unknowns that they need; for other `parameters` if given."""
        given = self.rhs_parameters if parameters is None else parameters
        inner, outer = self.orders
        asked = {k for row in rows for k in row if k >= 0}
        inside = closure(inner, asked & set(inner.below))
        ends = {a for a in inside if a not in inner.below}
        wanted = (asked - inside) | {k for a in ends for k in self.rows[a] if k >= 0}
        known = {-1 - s: value for s, value in enumerate(given)}
        needed = closure(outer, wanted)
        stage, pivots = self.outer, [k for k in outer.pivots if k in needed]
        backward_parts(pivots, stage.pivots, stage.forces, given, known)
        at_ends = dict(zip(ends, combine_each([self.rows[a] for a in ends], known), strict=True))
        stage, pivots = self.inner, [k for k in inner.pivots if k in inside]
        backward_parts(pivots, stage.pivots, stage.forces, given, at_ends)
        known.update({k: at_ends[k] for k in inside & set(inner.below)})
        return combine_each(rows, known)

    def carried(self, row: Row) -> Row:
        """`row` expressed in the unknowns that are not eliminated yet and the right-hand-side parameters."""
        inner, outer = self.orders
        at_ends = carried(inner, row, self.inner)
        out: Row = {}
        for k, factor in at_ends.items():
            add_row(out, self.rows[k] if k not in row and k in self.rows else {k: 1.0}, factor)
        return carried(outer, out, self.outer)

    # -- numbers that are kept ----------------------------------------------------------------------------------------

    @property
    def pivot_ratios(self) -> list[Value]:
        """Least pivot ratios of the steps so far, one for each stage and mask."""
        return [value for stage in (self.inner, self.outer) for value in stage.pivot_ratio.values()]

    @property
    def least(self) -> Value:
        """The least of the pivot ratios."""
        least: Value = np.inf
        for value in self.pivot_ratios:
            least = np.minimum(least, value)
        return least

    def mapped(self, change: Callable[[Value], Value]) -> PartialFactorisation:
        """A copy of what later results and other loads need, with `change` applied to every number."""
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
        """A copy of the state so far, with `take` applied to every number, on which the elimination can continue."""
        inner, outer = self.inner.mapped(take), self.outer.mapped(take)
        rows = {a: mapped_row(row, take) for a, row in self.rows.items()}
        springs = [(mapped_row(row, take), take(stiffness)) for row, stiffness in self.springs]
        rhs_parameters = [take(value) for value in self.rhs_parameters]
        return PartialFactorisation(self.orders, inner, outer, rows, springs, rhs_parameters, self.masks)

    @property
    def terms(self) -> list[Term]:
        """All terms of a recording among the numbers of `mapped`, each once."""
        found: dict[int, Term] = {}

        def note(value: Value) -> Value:
            if isinstance(value, Term):
                found[value.number] = value
            return value

        self.mapped(note)
        return list(found.values())

    # -- the matrix -------------------------------------------------------------------------------------------------

    def factorise(self, wanted: Wanted, *, given: bool) -> None:
        """Eliminate as far as masks are `wanted`; the constant stiffness of joint springs is added only if `given`."""
        inner, outer = self.orders
        self.inner.eliminate(inner, wanted)
        self._substitute(wanted)
        self._add_springs(wanted, given=given)
        self.outer.eliminate(outer, wanted)
        self.complete = self.inner.complete, self.outer.complete

    def forget(self) -> None:
        """Drop the numbers that only the elimination needed."""
        self.inner.matrix, self.inner.scale, self.outer.matrix, self.outer.scale = {}, {}, {}, {}

    def _substitute(self, wanted: Wanted) -> None:
        """Add ``T^T K T``, ``-T^T K G`` and the scale of the diagonal to the second stage."""
        inner, outer, rows = self.inner, self.outer, self._factors
        outer.complete &= add_congruence(outer.matrix, self.imposed, inner.matrix, rows, wanted)
        outer.complete &= add_squares(outer.scale, inner.scale, rows, wanted)

    @property
    def _factors(self) -> dict[int, Factors]:
        """The rows, each factor with its mask."""
        masks = self.masks.rows
        return {a: [(k, factor, masks[a][k]) for k, factor in row.items()] for a, row in self.rows.items()}

    def _add_springs(self, wanted: Wanted, *, given: bool) -> None:
        """Add ``k r r^T``, and ``-k r`` times its part in right-hand-side parameters, of every spring to stage two."""
        outer = self.outer
        for (row, stiffness), (masks, mask) in zip(self.springs, self.masks.springs, strict=True):
            factors, part = [(k, factor, masks[k]) for k, factor in row.items()], (mask, stiffness)
            # A term that is the given stiffness itself is added at once, whatever its size: that costs nothing.
            outer.complete &= add_dyad(
                outer.matrix, self.imposed, part, factors, factors, wanted, given=given, scale=outer.scale
            )

    # -- the loads --------------------------------------------------------------------------------------------------

    def load(self, wanted: Wanted) -> None:
        """Forward substitution of the loads, as far as the masks of results are `wanted`."""
        inner, outer = self.orders
        if self.inner.pivots:
            self.inner.forward(inner, wanted)
        for i, by_source in self.imposed.items():
            for source, parts in by_source.items():
                self.outer.force(i, source).update(parts)
        self.outer.complete &= add_loads(self.outer.forces, self.inner.forces, self._factors, wanted)
        self.outer.forward(outer, wanted)

    def loaded(self, inner: Forces, outer: Forces, rhs_parameters: list[Value]) -> PartialFactorisation:
        """The same factorisation with other loads, whose forward substitution is still to be done."""
        before, after = self.complete
        return replace(
            self,
            inner=replace(self.inner, forces=inner, complete=before),
            outer=replace(self.outer, forces=outer, complete=after),
            rhs_parameters=rhs_parameters,
        )
