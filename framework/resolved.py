"""What is regular, but singular to double precision: solved in extended precision.

A matrix whose least eigenvalue is that of rounding may belong to a frame that is not singular at all: the stiffness
squares what its deformations know, as ``S = A^T A`` with ``A = sqrt(k) B D``. So the rank is that of A, by its singular
values; and what has full rank is solved with S in extended precision, where that suffices.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .compliance import DenseCompliance
from .dense import Entries
from .equilibrium import Equilibrium, Statics
from .kinematics import Real, extended
from .parts import Extended, Row
from .plan import Plan

# Unknowns up to which it is worth the time.
MOST = 400
# Singular values of A that a matrix in extended precision can tell from zero.
_LEAST = 4.0 * float(np.sqrt(np.finfo(Extended).eps))
# Entries handled at a time.
_CHUNK = 256


class Resolved:
    """Entries of a batch that are singular to double precision, and are not.

    Parameters
    ----------
    plan
        The compiled frame.
    suspects
        Entries to look at, (...) of the batch shape.

    Attributes
    ----------
    mask
        Those that are solved, (...).
    """

    def __init__(self, plan: Plan, suspects: NDArray[np.bool_]) -> None:
        self.plan = plan
        self.unknowns = excited(plan)
        self.mask = np.zeros(plan.frame.shape, dtype=bool)
        self._values = extended(np.zeros((*plan.frame.shape, len(self.unknowns))))
        statics = Statics(plan)
        with np.errstate(all="ignore"):
            for index in groups(suspects):
                self._solve(statics, index)

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of `rows` over the unknowns and the known numbers at the solved entries, (m, rows)."""
        knowns = self.plan.knowns.values
        at = {k: number for number, k in enumerate(self.unknowns)}
        out = extended(np.zeros((*self.plan.frame.shape, len(rows))))
        for number, row in enumerate(rows):
            for k, factor in row.items():
                if k < 0:
                    out[..., number] += factor * extended(knowns[-1 - k])
                elif k in at:
                    out[..., number] += factor * self._values[..., at[k]]
        found: Real = out[self.mask]
        return found

    def _solve(self, statics: Statics, index: tuple[NDArray[np.int64], ...] | None) -> None:
        start = hard_state(statics, index, self.unknowns, None)
        rough = DenseCompliance(start.double, start.double_springs, start.stiffness, self.unknowns)
        near = np.atleast_1d(rough.distance() > _LEAST)
        if not near.any():
            return
        kept = index if index is None else tuple(each[near] for each in index)
        state, compliance = hard(statics, kept, self.unknowns, None)
        where: Any = () if kept is None else kept
        self.mask[where] = compliance.least > 0.0
        self._values[where] = state.values


def hard_state(
    statics: Statics, index: tuple[NDArray[np.int64], ...] | None, unknowns: Sequence[int], values: Real | None
) -> Equilibrium:
    """Some entries (m,) of a batch as a state of their own, from `values` (m, n) or from nothing."""
    shape = statics.plan.frame.shape
    count = () if index is None else (len(index[0]),)
    start = extended(np.zeros((*count, len(unknowns)))) if values is None else values
    return Equilibrium(statics, Entries(index).of, unknowns, start, len(shape) if index is None else 1)


def hard(
    statics: Statics, index: tuple[NDArray[np.int64], ...] | None, unknowns: Sequence[int], values: Real | None
) -> tuple[Equilibrium, DenseCompliance]:
    """Entries solved and inverted in extended precision."""
    state = hard_state(statics, index, unknowns, values)
    compliance = DenseCompliance(state.kinematics, state.springs, state.stiffness, unknowns, Extended)
    for _ in range(compliance.steps):
        state = state.corrected(compliance)
    return state, compliance


def excited(plan: Plan) -> list[int]:
    """Unknowns that the loads reach."""
    return [k for k in plan.unknowns if plan.component[k] in plan.excited]


def groups(mask: NDArray[np.bool_]) -> list[tuple[NDArray[np.int64], ...] | None]:
    """Indices of the entries in a mask, some at a time; None for the only entry of a batch without axes."""
    if not mask.ndim:
        return [None] if mask else []
    index = np.nonzero(mask)
    return [tuple(each[k : k + _CHUNK] for each in index) for k in range(0, len(index[0]), _CHUNK)]
