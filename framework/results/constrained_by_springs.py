"""Statically consistent mechanisms in a long batch, solved with a spring on one unknown for each free motion.

As the load does no work on the motion, the spring carries no force: the frame with the spring is regular, and has the
forces and displacements of the frame without it. Free motions depend on the geometry alone, so that they are found once
for all entries of a geometry, and the entries are solved as a batch by broadcasting. Entries that rounding leaves
uncertain are left to `linkframe.framework.results.constrained_batch`.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..batched.broadcast import BroadcastSolver
from ..batched.plan import Plan
from ..described.at_entries import frame_at
from ..entries import Entries, Index, Selected
from ..error_bounds.equilibrium import EquilibriumResidual, Statics
from ..error_bounds.kinematic_edge import Real, extended
from ..error_bounds.resolved import alike, distinct, geometry_shape, matrix_shape
from ..error_bounds.tree_members import MEMBER
from ..structure.tree import JointTree, TreeSpring
from .constrained import COMPUTED, GIVEN, ConstrainedSolution, free, weighed
from .constrained_batch import (
    ConstrainedMatrices,
    MovingGeometries,
    imposed_at,
    imposed_components,
    same_constrained,
    stiffness_at,
)

# Least number of entries for which a separate batch is faster, and least number of them for each geometry.
_MANY, _FOR_EACH = 64, 4
# Work is certainly rounding if it is below this share of the bound on its rounding error.
_SURE = 0.9


def constrained_by_springs(
    plan: Plan, statics: Statics, entries: Selected, suspects: NDArray[np.bool_], unknowns: list[int]
) -> ConstrainedSolution | None:
    """The solution of those entries for which the method is certain to apply; None for none.

    Parameters
    ----------
    plan
        The plan of the frame, which is solved by broadcasting.
    statics, entries
        The equilibrium equations at a selection of batch entries, and that selection.
    suspects
        Mask of the entries to examine, (...).
    unknowns
        Numbers of the unknowns that count as loaded.
    """
    if suspects.sum() < _MANY or plan.asked_unknowns:
        return None
    index = np.nonzero(suspects)
    geometry, own = distinct(index, geometry_shape(statics))
    if carries(statics) or len(own) < _FOR_EACH * len(geometry[0]) or not alike(statics):
        return None
    motions = _SharedMotions(plan, statics, geometry, unknowns)
    fixed = motions.fixed & motions.sure[:, None]
    springs = {
        unknown: _spread(geometry_shape(statics), geometry, np.where(fixed[:, k], motions.diagonal[:, k], 0.0))
        for k, unknown in enumerate(unknowns)
        if fixed[:, k].any()
    }
    solver = _with_springs(plan, entries, springs) if springs else None
    if solver is None:
        return None
    known = motions.sure[own] & ~solver.suspects()[index]
    values = np.zeros((len(own), len(unknowns)))
    for k, value in enumerate(solver.values([{unknown: 1.0} for unknown in unknowns])):
        values[:, k] = Entries(index)(aligned(np.asarray(value, dtype=np.float64), suspects.ndim), 0)
    known &= motions.without_work(index, own, values)
    if not known.any():
        return None
    where, own, values = tuple(k[known] for k in index), own[known], values[known]
    moved, scale = motions.motions[:, own], motions.frames.length_scale[own]
    return ConstrainedSolution(where, extended(values), moved, scale, np.ones(len(own), dtype=bool))


def carries(statics: Statics) -> bool:
    """Whether coordinates differ from those of the frame, because one end of a member carries the other."""
    return any(link.edge.kind == MEMBER for link in statics.kinematics.links)


class _SharedMotions:
    """Free motions of g geometries of a frame.

    Attributes
    ----------
    motions
        Values of the unknowns, the largest displacement being one, (motions, g, n); zero where a geometry has fewer.
    fixed
        Mask of the unknowns whose springs prevent the motions, (g, n).
    diagonal
        Diagonal stiffness of each unknown, (g, n).
    sure
        Mask of the geometries with free motions that these springs certainly prevent, (g,).
    """

    def __init__(self, plan: Plan, statics: Statics, geometry: tuple[Index, ...], unknowns: list[int]) -> None:
        self.statics, self.frames = statics, MovingGeometries(statics, geometry, unknowns)
        frames, count, size = self.frames, self.frames.count, len(unknowns)
        k = np.broadcast_to(stiffness_at(statics, geometry), (count, frames.columns.shape[-2]))
        self.diagonal: Array = np.einsum("ge,gen->gn", k, frames.double**2)
        scaled, root = weighed(frames.double, frames.sizes, k)
        bases, ranks = free(scaled, count)
        self.motions = extended(np.zeros((int(ranks.max(initial=0)), count, size)))
        self.fixed, self.sure = np.zeros((count, size), dtype=bool), np.zeros(count, dtype=bool)
        # unknowns that no joint, tie or support moves cannot be given springs in the frame
        on_edges = np.array([unknown // 6 in plan.tree.rows for unknown in unknowns])
        for take, shapes, constrained in same_constrained(bases * on_edges, ranks):
            basis = bases[take, -len(constrained) :]
            group = ConstrainedMatrices(frames, np.delete(np.arange(size), constrained), take, k[take])
            self.motions[: len(constrained), take] = group.refined(
                np.moveaxis(basis * root[take][:, None], 1, 0), take
            )[:, take]
            self.fixed[np.ix_(take, constrained)] = True
            independent = np.linalg.svd(shapes[..., constrained], compute_uv=False)[..., -1]
            self.sure[take] = group.sure & (independent > 1.0 / size)

    def without_work(self, index: tuple[Index, ...], own: Index, values: Array) -> NDArray[np.bool_]:
        """Whether loads certainly do no work on the motions, (m,), at m entries with geometries `own` and values (m, n)
        of the unknowns.
        """
        forces, uncertain = self._loads(index)
        frames, kinematics, fine = self.frames, self.frames.kinematics, EquilibriumResidual.fine
        moved, most = frames.displaced(self.motions), np.abs(forces).astype(np.float64)
        forces_within, sizes_within = self._within(index, own, values)
        left = np.einsum("rme,me->rm", frames.strained(self.motions)[:, own], forces_within)
        work = np.abs(_products(moved[:, own], forces) - left)
        sizes = np.abs(moved).astype(np.float64)
        sizes[..., :3] += np.max(sizes[..., 3:], axis=-1, keepdims=True) * frames.extent[:, None, None]
        none: list[Real | None] = [None] * len(kinematics.links)
        coordinates = kinematics.coordinates(frames.unknowns, self.motions, none)
        spread, deformed = (
            kinematics.sizes(coordinates).astype(np.float64),
            frames.deformation_sizes(coordinates, sizes),
        )
        noise = _products(spread[:, own], uncertain + fine * most)
        strained = np.einsum("rgn,nge->rge", np.abs(self.motions).astype(np.float64), frames.sizes)
        noise += fine * np.einsum("rme,me->rm", strained[:, own], sizes_within)
        # rounded positions let a share of the internal forces do work on the motion
        could = _products(sizes[:, own], most)
        could += np.einsum("rme,me->rm", deformed.astype(np.float64)[:, own], np.abs(forces_within))
        least = GIVEN * could + COMPUTED * noise
        return np.asarray((work <= _SURE * least).all(axis=0))

    def _loads(self, index: tuple[Index, ...]) -> tuple[Real, Array]:
        """Forces on the nodes at m entries, and their error bounds, (m, nodes, 6) each."""
        loads = self.statics.loads
        first, like = distinct(index, np.broadcast_shapes(loads.acting.shape[:-2], loads.rounded.shape[:-2]))
        own = loads.mapped(Entries(first))
        forces, uncertain = own.forces, own.error_bound
        return forces if len(forces) == 1 else forces[like], uncertain if len(uncertain) == 1 else uncertain[like]

    def _within(self, index: tuple[Index, ...], own: Index, values: Array) -> tuple[Array, Array]:
        """Forces in springs at m entries for unknowns (m, n), and magnitudes of their terms, (m, e) each."""
        frames = self.frames
        first, like = distinct(index, matrix_shape(self.statics))
        stiffness = np.broadcast_to(stiffness_at(self.statics, first), (len(first[0]), frames.columns.shape[-2]))
        deformed, sizes = np.empty((2, len(own), frames.columns.shape[-2]))
        for geometry in range(frames.count):  # one product for all entries of each
            mine = own == geometry
            deformed[mine] = values[mine] @ frames.double[geometry].T
            sizes[mine] = np.abs(values[mine]) @ frames.sizes[:, geometry]
        if units := imposed_components(self.statics):
            amounts, (by_unit, size) = imposed_at(self.statics, index, units), frames.by_imposed(units)
            deformed += np.einsum("ume,um->me", by_unit[:, own], amounts)
            sizes += np.einsum("ume,um->me", size[:, own], np.abs(amounts))
        return deformed * stiffness[like], sizes * np.abs(stiffness)[like]


def _products(moved: Real, forces: Real) -> Real:
    """Work (r, m) of forces (m or 1, nodes, 6) on motions (r, m, nodes, 6)."""
    found: Real = np.einsum("rmuk,muk->rm", moved, np.broadcast_to(forces, moved.shape[1:]))
    return found


def _spread(shape: tuple[int, ...], index: tuple[Index, ...], values: Array) -> Array:
    """An array of a batch shape with numbers (g,) at some indices and zero elsewhere."""
    out = np.zeros(shape)
    out[tuple(k if size > 1 else 0 * k for k, size in zip(index, shape, strict=True))] = values
    return out


def _with_springs(plan: Plan, entries: Selected, springs: dict[int, Array]) -> BroadcastSolver | None:
    """The solver of the frame at some entries with springs on some unknowns; None if its unknowns differ there."""
    frame = frame_at(plan.frame, entries, entries.shape)
    frame.absent = None
    own = Plan(frame)
    if _joined(own.tree) is None or _joined(own.tree) != _joined(plan.tree) or own.unknowns != plan.unknowns:
        return None
    own.tree.springs += [TreeSpring({unknown: 1.0}, own.grid.value(values)) for unknown, values in springs.items()]
    return BroadcastSolver(own)


def _joined(tree: JointTree) -> list[object] | None:
    """The edges of the tree and of loops with their nodes, in order; None if they differ between entries."""
    branches: list[object] = [(each.edge.name, each.edge.kind, each.parent, each.child) for each in tree.branches]
    closing = [(edge.name, edge.kind, edge.first, edge.second) for edge, _ in tree.closing]
    return None if tree.exchanged else [*branches, *closing, *tree.elimination.rows]
