"""Statically consistent mechanisms: frames with free motions on which the loads do no work.

A free motion costs no energy, so that all forces are unique, and so are the displacements that are not part of it. How
far the frame goes along it, nothing says. Where the loads do not act in its directions, that is zero: on unknowns that
they do not reach, and of a motion that at every node goes, and turns, across what the loads do there. That is the same
in all directions in which a frame may stand.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..elementwise import contracted
from ..entries import Entries, Selected
from ..error_bounds.equilibrium import Statics
from ..error_bounds.kinematic_edge import Real, extended
from ..error_bounds.resolved import MOST, At, combined, excited
from ..solvers.sparse import SparseSolver
from ..solvers.stacked import StackedSolver
from ..structure.parts import Row
from .constrained import ConstrainedSolution, large
from .constrained_batch import small
from .constrained_by_springs import carries, constrained_by_springs
from .motions_across import FreeMotions
from .reached import reached

# A displacement below this share of the largest one in a free motion counts as zero.
_STILL = 1e-10
# How often what lies along free motions is taken off: it may be much larger than what is left.
_PASSES = 2


def consistent_mechanisms(
    plan: Plan, solver: BroadcastSolver | StackedSolver | SparseSolver, suspects: NDArray[np.bool_]
) -> ConsistentMechanisms | None:
    """The statically consistent mechanisms among the entries with free motions; None for none.

    Parameters
    ----------
    plan
        The compiled frame.
    solver
        Its solver.
    suspects
        Mask of the entries with free motions, (...) of the batch shape.
    """
    if len(plan.unknowns) > MOST:
        if not isinstance(solver, SparseSolver):
            return None
        unknowns, entries = loaded(plan, solver), Selected.around(np.ones_like(suspects))
        found = ConsistentMechanisms(plan, unknowns, large(Statics(plan), solver), entries)
    else:
        unknowns = loaded(plan, solver)
        entries = Selected.around(suspects)
        statics = Statics(plan, determinate=True, entries=entries)
        parts = _solved(plan, solver, statics, entries, suspects, unknowns)
        found = ConsistentMechanisms(plan, unknowns, parts, entries)
        if found.mask.any():
            own = Statics(plan, entries=entries) if carries(statics) else statics
            found.rest_where_not(reached(plan, own, entries, found.mask, unknowns))
    if found.moving.any():
        found.rest_across()
    return found if found.mask.any() else None


def _solved(
    plan: Plan,
    solver: BroadcastSolver | StackedSolver | SparseSolver,
    statics: Statics,
    entries: Selected,
    suspects: NDArray[np.bool_],
    unknowns: list[int],
) -> list[ConstrainedSolution]:
    """Solutions of the `suspects`: in one batch where rounding leaves no doubt, the others separately."""
    left = entries.of_all(suspects).copy()
    found = (
        constrained_by_springs(plan, statics, entries, left, unknowns) if isinstance(solver, BroadcastSolver) else None
    )
    if found is None:
        return list(small(statics, left, unknowns))
    left[found.where] = False
    return [found, *small(statics, left, unknowns)]


def loaded(plan: Plan, solver: BroadcastSolver | StackedSolver | SparseSolver) -> list[int]:
    """Numbers of the unknowns that count as loaded; banded solvers take the coupling of any entry as that of all."""
    if isinstance(solver, BroadcastSolver):
        return excited(plan)
    reached = solver.excited if isinstance(solver, SparseSolver) else solver.loaded
    found: list[int] = solver.unknown[reached].tolist()
    return found


class ConsistentMechanisms:
    """Entries of a batch that are statically consistent mechanisms.

    Parameters
    ----------
    plan
        The compiled frame.
    unknowns
        Numbers of the loaded unknowns, (n,).
    parts
        Solutions of the candidates, part by part.
    entries
        The selection of batch entries that these solutions are for.

    Attributes
    ----------
    mask
        Mask of the consistent mechanisms, (...).
    moving
        Mask of those in which a loaded part has a free motion, (...); in the others, numbers that happen to be zero
        separate the moving part from the loads.
    """

    def __init__(
        self, plan: Plan, unknowns: Sequence[int], parts: Iterable[ConstrainedSolution], entries: Selected
    ) -> None:
        found, shape = list(parts), entries.shape
        self.plan, self.unknowns = plan, list(unknowns)
        own, length_scale = np.zeros(shape, dtype=bool), np.ones(shape)
        values = extended(np.zeros((*shape, len(self.unknowns))))
        motions = np.zeros((max((len(each.motions) for each in found), default=0), *values.shape))
        for each in found:
            own[each.where] = each.consistent
            length_scale[each.where] = each.length_scale
            values[each.where] = each.values
            motions[(slice(len(each.motions)), *each.where)] = each.motions
        # of these entries alone, in the order of the mask: (m,), (m, n), (motions, m, n)
        self.length_scale, self._values, self._motions = length_scale[own], values[own], motions[:, own]
        self.mask = np.zeros(plan.frame.shape, dtype=bool)
        self.mask[entries.where] = own
        self.moving = self.mask.copy()
        self._reached = np.zeros((0, len(self.unknowns)), dtype=bool)

    def values(self, rows: Sequence[Row]) -> Real:
        """Values of rows over unknowns and right-hand-side parameters at the m entries in `mask`, (m, rows)."""
        return combined(self.plan, self.unknowns, self._values, rows, self.mask)

    def rest_where_not(self, reached: NDArray[np.bool_]) -> None:
        """Set to zero the unknowns that loads do not reach at these entries, given a mask (m, n) of those reached."""
        self._values = np.where(reached, self._values, 0.0)
        self._motions = np.where(reached, self._motions, 0.0)
        weights = np.where(np.array(self.unknowns) % 6 < 3, 1.0, self.length_scale[:, None])
        self.moving[self.mask] = (np.abs(self._motions) * weights > _STILL).any(axis=(0, -1))
        self._reached = reached[~self.moving[self.mask]]

    def rest_across(self) -> None:
        """Set to zero what is moved along free motions that are across the other displacements at every node."""
        rows = [row for node in range(len(self.plan.topology.number)) for row in self.plan.tree.global_rows(node)]
        weights = np.where(np.arange(len(rows))[:, None] % 6 < 3, extended(1.0), self.length_scale)
        moved, values = np.swapaxes(self._moved(rows), 1, 2) * weights, self._values
        free = FreeMotions(moved)
        for _ in range(_PASSES):
            along = free.along(combined(self.plan, self.unknowns, values, rows, self.mask).T * weights)
            values = values - np.sum(along[..., None] * self._motions, axis=0)
        others, which = free.others(combined(self.plan, self.unknowns, values, rows, self.mask).T * weights)
        largest = np.abs(contracted("rsm,rkm->skm", others, moved)).max(axis=1)
        factors = others / np.where(largest > 0.0, largest, 1.0)
        motions = np.sum(factors[..., None] * self._motions[:, None], axis=0)
        self._values = np.where(which[:, None], values, self._values)
        self._motions = np.where(which[:, None], motions, self._motions)

    def apart(self, where: NDArray[np.bool_]) -> Iterator[tuple[At, list[int]]]:
        """Indices of entries whose loaded parts have no free motion, with the unknowns that loads reach there."""
        still = self.mask & ~self.moving
        kept = where[still]
        index = tuple(each[kept] for each in np.nonzero(still)) if still.ndim else ()
        patterns, which = np.unique(self._reached[kept], axis=0, return_inverse=True)
        for number, pattern in enumerate(patterns):
            here = which.reshape(-1) == number
            unknowns = [k for k, met in zip(self.unknowns, pattern.tolist(), strict=True) if met]
            yield (tuple(each[here] for each in index) if index else None), unknowns

    def motions(self, rows: Sequence[Row]) -> Array:
        """Values of rows in each free motion at the m entries in `mask`, (motions, m, rows)."""
        return self._moved(rows).astype(np.float64)

    def _moved(self, rows: Sequence[Row]) -> Real:
        at = {k: number for number, k in enumerate(self.unknowns)}
        motions, change = self._motions, Entries(np.nonzero(self.mask) if self.mask.ndim else ())
        out = extended(np.zeros((*motions.shape[:-1], len(rows))))
        for number, row in enumerate(rows):
            for k, factor in row.items():
                if k in at:
                    own = change(aligned(np.asarray(factor, dtype=np.float64), self.mask.ndim), 0)
                    out[..., number] += own * motions[..., at[k]]
        return out

    def masked(self, found: Array, moved: Array) -> bool:
        """Set displacements to NaN in place if they are part of a free motion; whether any are.

        Parameters
        ----------
        found
            ``ux uy uz rx ry rz`` of the whole batch, (..., 6) or (..., k, 6).
        moved
            Displacements of the same points in each free motion, (motions, m, 6) or (motions, m, k, 6).
        """
        length_scale = self.length_scale.reshape(-1, *(1,) * (moved.ndim - 2))
        weights = np.concatenate([np.ones((*length_scale.shape[:-1], 3)), np.repeat(length_scale, 3, axis=-1)], axis=-1)
        lost = (np.abs(moved) * weights > _STILL).any(axis=0)
        found[self.mask] = np.where(lost, np.nan, found[self.mask])
        return bool(lost.any())
