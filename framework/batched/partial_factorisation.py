"""The two stages of an elimination, as far as they have come, for the whole batch or for a chunk of it.

Matrix and loads go apart: what the elimination leaves of the matrix serves any load.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from ..program.recording import Term
from ..structure.parts import Row, Value, add, add_all, add_row, combine, dyad, enter_terms, product, scaled, unknowns
from .order import Masks, Order, Springs
from .stage import Forces, Stage, backward, carried, closure, mapped_forces, mapped_row, subtract

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
        stage = assembled.mapped(lambda value: value)
        out = cls(orders, stage, Stage(), rows, springs, rhs_parameters, masks)
        out.factorise(wanted, given=True)
        out.load(wanted)
        return out

    # -- results ----------------------------------------------------------------------------------------------------

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows`, by back substitution of what they ask for."""
        inner, outer = self.orders
        asked = {k for row in rows for k in unknowns(row)}
        inside = closure(inner, asked & set(inner.below))
        ends = {a for a in inside if a not in inner.below}
        wanted = (asked - inside) | {k for a in ends for k in unknowns(self.rows[a])}
        known = {-1 - s: value for s, value in enumerate(self.rhs_parameters)}
        backward(outer, closure(outer, wanted), known, self.outer, self.rhs_parameters)
        at_ends = {a: _sum(self.rows[a], known) for a in ends}
        backward(inner, inside, at_ends, self.inner, self.rhs_parameters)
        known.update({k: at_ends[k] for k in inside & set(inner.below)})
        return [_sum(row, known) for row in rows]

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
        inner, outer = self.inner, self.outer
        for a, row in self.rows.items():
            for b, parts in inner.matrix.get(a, {}).items():
                if b >= a and b in self.rows:
                    for mask, value in parts.items():
                        self._congruence((a, row), (b, self.rows[b]), (mask, value), wanted)
            for i in unknowns(row):
                over = self.masks.rows[a][i]
                now = {m: value for m, value in inner.scale.get(a, {}).items() if _is(outer, wanted, m | over)}
                twice = scaled(scaled(now, row[i]), row[i])
                add_all(outer.scale, ((i, mask | over, term) for mask, term in twice.items()))

    def _congruence(
        self, left: tuple[int, Row], right: tuple[int, Row], part: tuple[int, Value], wanted: Wanted
    ) -> None:
        (a, row), (b, other), (mask, value) = left, right, part
        first, second = self.masks.rows[a], self.masks.rows[b]
        twice = a != b
        pairs = []
        for i, factor in row.items():
            of_first = mask | first[i]
            met = other if twice else {j: known for j, known in other.items() if i >= 0 and (j >= i or j < 0)}
            now = {j: known for j, known in met.items() if wanted[of_first | second[j]]}
            if len(now) < len(met):
                self.outer.complete = False
            if now:
                pairs.append((i, factor, now))
        self._put([(i, j, mask | first[i] | second[j], term) for i, j, term in dyad(value, pairs)], twice)

    def _add_springs(self, wanted: Wanted, *, given: bool) -> None:
        """Add k r r^T and -k r times the known part of every spring to the second stage."""
        outer = self.outer
        for (row, stiffness), (masks, mask) in zip(self.springs, self.masks.springs, strict=True):
            for i in unknowns(row):
                half = product(row[i], stiffness)
                for j, second in row.items():
                    over = mask | masks[i] | masks[j]
                    # A stiffness as it was given is added whole, whatever its size: that costs nothing.
                    now = _is(outer, wanted, over) if masks[i] | masks[j] else given
                    if now and (j >= i or j < 0):
                        term = product(second, half)
                        self._put([(i, j, over, term)], False)
                        if i == j:
                            add(outer.scale.setdefault(i, {}), over, term)

    def _put(self, terms: list[tuple[int, int, int, Value]], twice: bool) -> None:
        """Add terms of the stiffness to the matrix or, where they meet a right-hand-side parameter, to the load."""
        own = [(i, j, mask, 2.0 * term if twice and i == j else term) for i, j, mask, term in terms if min(i, j) >= 0]
        enter_terms(self.outer.matrix, own)
        for i, j, mask, term in terms:
            if min(i, j) < 0 <= max(i, j):
                subtract(self.imposed.setdefault(max(i, j), {}).setdefault(-1 - min(i, j), {}), mask, term)

    # -- the loads --------------------------------------------------------------------------------------------------

    def load(self, wanted: Wanted) -> None:
        """Carry the loads through what has been eliminated, as far as what varies so is `wanted`."""
        inner, outer = self.orders
        self.inner.forward(inner, wanted)
        for i, by_source in self.imposed.items():
            for source, parts in by_source.items():
                self.outer.force(i, source).update(parts)
        self._push(wanted)
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

    def _push(self, wanted: Wanted) -> None:
        """Add T^T f to the second stage."""
        for a, row in self.rows.items():
            for i in unknowns(row):
                over, factor = self.masks.rows[a][i], row[i]
                for source, pushed in self.inner.forces.get(a, {}).items():
                    for mask, value in pushed.items():
                        if _is(self.outer, wanted, mask | over):
                            add(self.outer.force(i, source), mask | over, product(factor, value))


def _is(stage: Stage, wanted: Wanted, mask: int) -> bool:
    """Whether a term is wanted now; a stage that leaves some out is not complete."""
    if not wanted[mask]:
        stage.complete = False
    return wanted[mask]


def _sum(row: Row, known: dict[int, Value]) -> Value:
    return combine([(factor, known[k]) for k, factor in row.items()])
