"""Entries that are certainly mechanisms, and those that loads certainly set in motion, from geometry and loads alone.

A free motion causes no deformation, so that it does not depend on stiffness: it is found once for all entries with the
same geometry. For each entry only the work of its loads on it has to be computed.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..batched.plan import Plan
from ..entries import Selected, picked
from ..error_bounds.equilibrium import Statics
from ..error_bounds.resolved import MOST, alike, geometry_shape, groups, ill_conditioned_state
from ..structure.parts import Row, Value, total
from .constrained import PLAIN, free_motions_of


def plain_mechanisms(
    plan: Plan, suspects: NDArray[np.bool_], unknowns: Sequence[int]
) -> tuple[NDArray[np.bool_], NDArray[np.bool_]]:
    """Masks of the `suspects` with certain free motions, and of those that loads certainly set in motion.

    Both are of the batch shape, (...). Others may be mechanisms as well, which needs a closer examination. Imposed
    displacements do not matter, as they do no work on a motion without deformations.

    Parameters
    ----------
    plan
        The compiled frame.
    suspects
        Mask of the entries to examine, (...) of the batch shape.
    unknowns
        Numbers of the unknowns that count as loaded.
    """
    moving, driven = np.zeros(suspects.shape, dtype=bool), np.zeros(suspects.shape, dtype=bool)
    if not (suspects.any() and plan.frame.size) or len(plan.unknowns) > MOST:
        return moving, driven
    entries = Selected.around(suspects)
    statics, suspects = Statics(plan, determinate=True, entries=entries), entries.of_all(suspects)
    if not alike(statics):
        return moving, driven
    shape = geometry_shape(statics)
    along = tuple(axis for axis, size in enumerate(shape) if size == 1)
    rows = [plan.tree.row(*divmod(dof, 6)) for dof in plan.forces]
    with np.errstate(all="ignore"):
        for index in groups(np.asarray(suspects.any(axis=along, keepdims=True))):
            # index in the batch of geometries, and one of its entries
            motions, largest = _motions(statics, index, unknowns, rows, entries)
            chosen = np.zeros(shape, dtype=np.int64)
            chosen[... if index is None else index] = 1 if index is None else np.arange(1, 1 + len(index[0]))
            here = suspects & (chosen > 0)
            places = np.nonzero(here) if here.ndim else ()
            found = np.broadcast_to(chosen, here.shape)[here] - 1
            places = entries.among_all(places)
            where = places or ...
            moving[where] = np.asarray((largest > 0.0).any(axis=0))[found]
            driven[where] = _driven(plan, motions[:, found], largest[:, found], places)
    return moving, driven


def at_rest(plan: Plan, suspects: NDArray[np.bool_]) -> NDArray[np.bool_]:
    """Mask of the `suspects` with neither loads nor imposed displacements, (...) of the batch shape.

    Parameters
    ----------
    plan
        The compiled frame.
    suspects
        Mask of the entries to examine, (...) of the batch shape.
    """
    out = np.zeros(suspects.shape, dtype=bool)
    if not suspects.any():
        return out
    places = np.nonzero(suspects) if suspects.ndim else ()
    values = plan.rhs_parameters.values
    loads = [(values[k], total(parts)[1]) for by_source in plan.forces.values() for k, parts in by_source.items()]
    imposed = [(values[-1 - k], factor) for row in _imposed(plan) for k, factor in row.items() if k < 0]
    acts = np.zeros(int(suspects.sum()), dtype=bool)
    for value, factor in [*loads, *imposed]:
        acts |= (_at(value, places) != 0.0) & (_at(factor, places) != 0.0)
    out[suspects] = ~acts
    return out


def _at(value: Value, places: tuple[NDArray[np.int64], ...]) -> Array:
    """A value at m entries, (m,), or (1,) where it is the same at all."""
    return picked(aligned(np.asarray(value, dtype=np.float64), len(places)), places)


def _imposed(plan: Plan) -> list[Row]:
    """Rows that depend on prescribed displacements or offsets."""
    rows = [*(row for six in plan.tree.rows.values() for row in six), *(spring.row for spring in plan.tree.springs)]
    return [row for row in rows if min(row, default=0) < 0]


def _motions(
    statics: Statics,
    index: tuple[NDArray[np.int64], ...] | None,
    unknowns: Sequence[int],
    rows: Sequence[Row],
    entries: Selected,
) -> tuple[Array, Array]:
    """Values of rows in each free motion of m entries, (motions, m, rows), and the largest displacements, (motions, m).

    Zero where an entry has no free motion, or motions that rounding cannot distinguish from free ones.
    """
    count = 1 if index is None else len(index[0])
    shapes, largest = free_motions_of(ill_conditioned_state(statics, index, unknowns), count)
    at = {k: number for number, k in enumerate(unknowns)}
    out = np.zeros((*shapes.shape[:2], len(rows)))
    for number, row in enumerate(rows):
        for k, factor in row.items():
            if k in at:
                value = entries(np.asarray(factor, dtype=np.float64), 0)
                out[..., number] += (value if index is None else picked(value, index)) * shapes[..., at[k]]
    return out, largest


def _driven(plan: Plan, moved: Array, largest: Array, places: tuple[NDArray[np.int64], ...]) -> NDArray[np.bool_]:
    """Whether the loads at m entries certainly do work on one of the motions (motions, m, dofs), (m,).

    They do if their work is no small share of that if every displacement were the `largest` of the motion,
    (motions, m).
    """
    work, could = np.zeros(moved.shape[:2]), np.zeros(moved.shape[:2])
    for number, (dof, by_source) in enumerate(plan.forces.items()):
        arm = 1.0 if dof % 6 < 3 else 1.0 / plan.frame.size
        for source, parts in by_source.items():
            own = _at(plan.rhs_parameters.values[source] * total(parts)[1], places)
            work += own * moved[..., number]
            could += np.abs(own) * arm * largest
    return np.asarray((np.abs(work) > PLAIN * could).any(axis=0))
