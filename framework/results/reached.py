"""The unknowns that loads reach at single batch entries; which ones may differ with the numbers that are zero there."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..batched.plan import Plan
from ..entries import Entries, Index, Selected
from ..error_bounds.compliance import by_units, resistances
from ..error_bounds.equilibrium import Statics, rounded
from ..error_bounds.kinematic_edge import extended
from ..error_bounds.resolved import At, distinct, geometry_shape, grouped, matrix_shape
from .constrained_batch import deformed_by_imposed, imposed_at, imposed_components, units_of

# Number of entries handled at a time.
_MOST = 2**11


def reached(
    plan: Plan, statics: Statics, entries: Selected, mask: NDArray[np.bool_], unknowns: Sequence[int]
) -> NDArray[np.bool_]:
    """Mask (m, n) of the unknowns that loads reach at m entries: loaded or requested, and coupled with such.

    Parameters
    ----------
    plan
        The compiled frame.
    statics, entries
        The equilibrium equations at a selection of batch entries, in the frame's own coordinates; that selection.
    mask
        Mask of the m entries among these, (...) of the batch shape.
    unknowns
        Numbers of the unknowns that count as loaded at any entry, (n,).
    """
    own = entries.of_all(mask)
    asked, imposed = np.isin(unknowns, list(plan.asked_unknowns)), imposed_components(statics)
    out = np.zeros((*own.shape, len(unknowns)), dtype=bool)
    for index, first, which in grouped(own, matrix_shape(statics), _MOST):
        geometry, like = distinct(first or (), geometry_shape(statics))
        columns, given = _deformed(statics, geometry, unknowns, imposed)
        at, resisted = like[which] if len(columns) > 1 else 0 * which, _resisted(statics, first)
        resisted = (
            resisted[which] if len(resisted) > 1 else np.broadcast_to(resisted, (len(which), *resisted.shape[1:]))
        )
        loaded = np.broadcast_to(_loaded(statics, index, unknowns) | asked, (len(which), len(unknowns)))
        moved = (imposed_at(statics, index or (), imposed) != 0.0).T
        # the coupling and the loaded unknowns are the same at almost all entries
        parts = at[:, None].view(np.uint8), resisted.view(np.uint8), loaded.view(np.uint8), moved.view(np.uint8)
        one, alike = _different(np.concatenate(parts, axis=1))
        springs = columns[at[one]] & resisted[one][..., None]
        strained = (moved[one][..., None] & np.moveaxis(given[:, at[one]], 0, 1)).any(axis=1)
        acted = loaded[one] | (springs & strained[..., None]).any(axis=1)
        out[... if index is None else index] = _coupled(springs.astype(np.float32), acted)[alike]
    return out[own]


def _different(rows: NDArray[np.uint8]) -> tuple[Index, Index]:
    """Index of one of each of the distinct rows of (m, c), and for each row the number of the distinct one, (m,)."""
    if not rows.shape[1] or (rows == rows[:1]).all():
        return np.zeros(1, dtype=np.int64), np.zeros(len(rows), dtype=np.int64)
    whole = np.ascontiguousarray(rows).view(np.dtype((np.void, rows.shape[1])))[:, 0]
    return np.unique(whole, return_index=True, return_inverse=True)[1:]


def _deformed(
    statics: Statics, index: tuple[Index, ...], unknowns: Sequence[int], imposed: Sequence[tuple[int, int]]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the springs that each unknown deforms in g geometries, (g, e, n), and that each imposed displacement
    deforms, (u, g, e).
    """
    change, links = Entries(index or None), len(statics.kinematics.links)
    kinematics = statics.kinematics.mapped(change).mapped(rounded)
    springs = [each.mapped(change).mapped(rounded) for each in statics.springs]
    columns = np.moveaxis(_in_rows(by_units(kinematics, springs, unknowns, np.float64)[0] != 0.0), 0, -1)
    if not imposed:
        return columns, np.zeros((0, *columns.shape[:2]), dtype=bool)
    rest, units = extended(np.zeros((len(imposed), 1, len(unknowns)))), units_of(imposed, links)
    given = deformed_by_imposed(kinematics, springs, list(unknowns), rest, units)[1]
    return columns, np.broadcast_to(_in_rows(given != 0.0), (len(imposed), *columns.shape[:2]))


def _resisted(statics: Statics, index: At) -> NDArray[np.bool_]:
    """Mask of the deformations with a spring stiffness at m entries, (m or 1, e)."""
    at = Entries(index)
    springs, links = [each.mapped(at) for each in statics.springs], [at(each, 1) for each in statics.stiffness]
    found = resistances(statics.kinematics.mapped(at), springs, links, 1) != 0.0
    return np.asarray(found.reshape(math.prod(found.shape[:-1]), found.shape[-1]))


def _loaded(statics: Statics, index: At, unknowns: Sequence[int]) -> NDArray[np.bool_]:
    """Mask of the unknowns on which loads act at m entries, (m or 1, n)."""
    shape = np.broadcast_shapes(geometry_shape(statics), statics.loads.acting.shape[:-2])
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
    """Mask of the unknowns that springs couple with those in `out` (m, n); `deformed` (..., e, n) is one if an unknown
    deforms a spring.
    """
    while True:
        strained = np.matmul(deformed, out[..., None].astype(np.float32)) > 0.0
        more = out | (np.matmul(np.swapaxes(deformed, -1, -2), strained.astype(np.float32)) > 0.0)[..., 0]
        if np.array_equal(more, out):
            return out
        out = more
