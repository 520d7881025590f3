"""Solver of batches: the broadcasting LDL^T of each connected component that a load reaches."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
from numpy.typing import NDArray

from ..clock import timed
from ..results.status import is_singular
from ..structure.parts import Row, Value, combine, unknowns
from .block import BlockFactor
from .plan import Plan

# A pivot below this share of the stiffness whose rounding it carries raises suspicion.
SUSPECT = 1e-11


class BroadcastSolver:
    """Components are assembled and factorised when first asked for.

    Parameters
    ----------
    plan
        The compiled frame.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._factors: dict[int, BlockFactor] = {}

    def only(self, plan: Plan) -> BroadcastSolver:
        """The same for a plan of a part, with the same factors."""
        twin = BroadcastSolver(plan)
        twin._factors = self._factors
        return twin

    def reaching(self, unknowns: Iterable[int]) -> BroadcastSolver:
        """The same where what these unknowns are coupled with counts as loaded, too; itself where it is."""
        plan = self.plan.reaching(unknowns)
        return self if plan is self.plan else self.only(plan)

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns."""
        rows = [self.plan.retained(row) for row in rows]
        split: dict[int, dict[int, Row]] = {}
        for index, row in enumerate(rows):
            for k in unknowns(row):
                name = self.plan.component[k]
                if name in self.plan.excited:
                    split.setdefault(name, {}).setdefault(index, {})[k] = row[k]
        factors = {name: self.factor(name) for name in split}
        knowns = self.plan.knowns.values
        terms = [[(value, knowns[-1 - k]) for k, value in row.items() if k < 0] for row in rows]
        with timed(self.plan.times, "solution"):
            for name, parts in split.items():
                for index, value in zip(parts, factors[name].values(list(parts.values())), strict=True):
                    terms[index].append((1.0, value))
            return [combine(term) for term in terms]

    def singular(self, *, excited: bool) -> NDArray[np.bool_]:
        """Whether the components that loads reach, or the others, are singular, (...) of the batch shape.

        Pivots no larger than the rounding of what they are made of raise the suspicion, eigenvalues confirm it.
        """
        names = self.plan.excited if excited else self.plan.components - self.plan.excited
        out = np.zeros(self.plan.frame.shape, dtype=bool)
        for name in names:
            suspects = ~(self.factor(name).margin() > SUSPECT)
            if suspects.any():
                out |= is_singular(self.plan, suspects, self.plan.members_of(name))
        return out

    def suspects(self) -> NDArray[np.bool_]:
        """Entries of which pivots alone tell that few digits of what loads move are left, (...) of the batch shape."""
        out = np.zeros(self.plan.frame.shape, dtype=bool)
        for name in self.plan.excited:
            out |= ~(self.factor(name).margin() > SUSPECT)
        return out

    def solved(self, component: int) -> bool:
        """Whether a component has been factorised."""
        return component in self._factors

    def negligible(self, component: int) -> int:
        """Couplings that a factorisation left out; 0 before it is made."""
        return self._factors[component].negligible if component in self._factors else 0

    def origin(self, component: int) -> str:
        """What of the factor of a component is that of the last solution, in words; empty for nothing."""
        return self._factors[component].origin if component in self._factors else ""

    def factor(self, component: int) -> BlockFactor:
        """Factorisation of a component."""
        if component not in self._factors:
            block = self.plan.block(component)
            kept = self.plan.factors.get(component)
            with timed(self.plan.times, "factorisation"):
                factor = BlockFactor(block) if kept is None else kept.loaded(block)
            self._factors[component] = factor
            if factor.light:
                self.plan.factors[component] = factor
        return self._factors[component]
