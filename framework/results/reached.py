"""Unknowns that loads reach at one entry of a batch: they may reach more at others, where other numbers are zero."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..batched.plan import Plan
from ..entries import Entries, Index, Selected
from ..error_bounds.compliance import by_units, resistances
from ..error_bounds.equilibrium import Statics, rounded
from ..error_bounds.resolved import At, distinct, geometry_shape, grouped, ill_conditioned_state, matrix_shape

# Entries handled at a time.
_MOST = 2**11


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
    if not mask.any():
        return np.zeros((0, len(unknowns)), dtype=bool)
    entries = Selected.around(mask)
    statics, own = Statics(plan, entries=entries), entries.of_all(mask)
    asked = np.isin(unknowns, list(plan.asked_unknowns))
    out = np.zeros((*own.shape, len(unknowns)), dtype=bool)
    for index, first, which in grouped(own, matrix_shape(statics), _MOST):
        deformed = _deformed(statics, first, unknowns)
        loaded = np.broadcast_to(_loaded(statics, index, unknowns) | asked, (len(which), len(unknowns)))
        # what is coupled with what, and loaded, is the same at almost all entries
        kind = _different(deformed.reshape(len(deformed), math.prod(deformed.shape[1:])))[1][which]
        one, like = _different(np.concatenate([kind[:, None].view(np.uint8), loaded.view(np.uint8)], axis=1))
        springs = np.unpackbits(deformed[which[one]], axis=-1, count=len(unknowns))
        out[... if index is None else index] = _coupled(springs.astype(np.float32), loaded[one])[like]
    return out[own]


def _different(rows: NDArray[np.uint8]) -> tuple[Index, Index]:
    """One of each of the rows (m, c) that differ, and which of these each row is like, (m,)."""
    if not rows.shape[1] or (rows == rows[:1]).all():
        return np.zeros(1, dtype=np.int64), np.zeros(len(rows), dtype=np.int64)
    whole = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.shape[1])))[:, 0]
    return np.unique(whole, return_index=True, return_inverse=True)[1:]


def _deformed(statics: Statics, index: At, unknowns: Sequence[int]) -> NDArray[np.uint8]:
    """Which springs are deformed by which unknowns at some entries (m,), (m, e, ...): eight unknowns in a number."""
    geometry, like = distinct(index or (), geometry_shape(statics))
    change, at = Entries(geometry or None), Entries(index)
    kinematics = statics.kinematics.mapped(change).mapped(rounded)
    rows = by_units(kinematics, [each.mapped(change).mapped(rounded) for each in statics.springs], unknowns, np.float64)
    columns = np.moveaxis(_in_rows(rows[0] != 0.0), 0, -1)
    springs, links = [each.mapped(at) for each in statics.springs], [at(each, 1) for each in statics.stiffness]
    resisted = resistances(statics.kinematics.mapped(at), springs, links, 1) != 0.0
    resisted = resisted.reshape(math.prod(resisted.shape[:-1]), resisted.shape[-1])
    found = np.packbits((columns if len(columns) == 1 else columns[like]) & resisted[..., None], axis=-1)
    return np.broadcast_to(found, (len(like), *found.shape[1:]))


def _loaded(statics: Statics, index: At, unknowns: Sequence[int]) -> NDArray[np.bool_]:
    """Which unknowns something acts on at some entries (m,), (m or 1, n)."""
    if any(each is not None for each in statics.imposed):
        balance = ill_conditioned_state(statics, index, unknowns).balance
        return np.asarray(balance.reshape(-1, len(unknowns)) != 0.0)
    shape = np.broadcast_shapes(geometry_shape(statics), statics.loads.forces.shape[:-2])
    first, like = distinct(index or (), shape)
    change = Entries(first or None)
    kinematics, loads = statics.kinematics.mapped(change), statics.loads.mapped(change)
    found = kinematics.reduced(list(unknowns), kinematics.generalised(loads.forces, [None] * len(kinematics.links)))
    acts = np.asarray(found != 0.0).reshape(-1, len(unknowns))
    return acts if len(acts) == 1 else acts[like]


def _in_rows(array: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """An array (n, ..., e) with one batch axis, (n, m, e)."""
    return array.reshape(len(array), math.prod(array.shape[1:-1]), array.shape[-1])


def _coupled(deformed: NDArray[np.float32], out: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """What springs (..., e, n), one where an unknown deforms them, couple with some of the unknowns (m, n)."""
    while True:
        strained = np.matmul(deformed, out[..., None].astype(np.float32)) > 0.0
        more = out | (np.matmul(np.swapaxes(deformed, -1, -2), strained.astype(np.float32)) > 0.0)[..., 0]
        if np.array_equal(more, out):
            return out
        out = more
