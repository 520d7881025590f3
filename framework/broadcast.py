"""Solver of batches: the broadcasting LDL^T of each connected component that a load reaches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from .batch import Array
from .block import Factor
from .parts import Row, Value, combine
from .plan import Plan

# A pivot below this many roundings of its assembled diagonal is none.
ROUNDINGS = 10.0


class BroadcastSolver:
    """Components are assembled and factorised when first asked for.

    Parameters
    ----------
    plan
        The compiled frame.
    """

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self._factors: dict[int, Factor] = {}

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns."""
        split: dict[int, list[Row]] = {}
        for index, row in enumerate(rows):
            for k, factor in row.items():
                name = self.plan.component[k]
                if name in self.plan.excited:
                    split.setdefault(name, [{} for _ in rows])[index][k] = factor
        found = [self.factor(name).values(part) for name, part in split.items()]
        return [combine([(1.0, part[index]) for part in found]) for index in range(len(rows))]

    def margin(self, *, excited: bool) -> Array:
        """Least pivot, in units of what counts as none, of the components that loads reach or of the others, (...)."""
        names = self.plan.excited if excited else self.plan.components - self.plan.excited
        out = np.full(self.plan.frame.shape, np.inf)
        for name in names:
            factor = self.factor(name)
            size = sum(len(order.pivots) for order in factor.block.orders)
            out = np.minimum(out, factor.margin() / (ROUNDINGS * np.sqrt(size) * np.finfo(float).eps))
        return out

    def factor(self, component: int) -> Factor:
        """Factorisation of a component."""
        if component not in self._factors:
            self._factors[component] = Factor(self.plan.block(component))
        return self._factors[component]
