"""Unknowns that loads reach at one entry of a batch: they may reach more at others, where other numbers are zero."""

from __future__ import annotations

from collections.abc import Sequence
from math import prod

import numpy as np
from numpy.typing import NDArray

from ..batched.plan import Plan
from ..error_bounds.compliance import by_unknowns
from ..error_bounds.equilibrium import Statics
from ..error_bounds.resolved import groups, ill_conditioned_state


def reached(plan: Plan, mask: NDArray[np.bool_], unknowns: Sequence[int]) -> NDArray[np.bool_]:
    """Which unknowns the loads of some entries reach, (m, n): loaded ones or asked for, and what is coupled with them.

    Parameters
    ----------
    plan
        The compiled frame.
    mask
        The entries, (...) of the batch shape.
    unknowns
        Numbers of the unknowns that count as loaded at any entry (n,).
    """
    statics, found = Statics(plan), []
    asked = np.isin(unknowns, list(plan.asked_unknowns))
    for index in groups(mask):
        state = ill_conditioned_state(statics, index, unknowns)
        columns, _, stiffness = by_unknowns(
            state.double, state.double_springs, state.stiffness, state.unknowns, np.float64
        )
        count = 1 if index is None else len(index[0])
        deformed = ((columns != 0.0) & (stiffness != 0.0)[..., None]).astype(np.float32)
        loaded = np.broadcast_to((state.balance != 0.0).reshape(-1, len(unknowns)) | asked, (count, len(unknowns)))
        found.append(_coupled(deformed.reshape(prod(deformed.shape[:-2]), *deformed.shape[-2:]), loaded))
    return np.concatenate([np.zeros((0, len(unknowns)), dtype=bool), *found])


def _coupled(deformed: NDArray[np.float32], out: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What springs (..., e, n), one where an unknown deforms them, couple with some of the unknowns (m, n)."""
    while True:
        strained = np.matmul(deformed, out[..., None].astype(np.float32)) > 0.0
        more = out | (np.matmul(np.swapaxes(deformed, -1, -2), strained.astype(np.float32)) > 0.0)[..., 0]
        if np.array_equal(more, out):
            return out
        out = more
