"""Solution of a mechanism by constraining one unknown for each free motion, the one with the largest displacement.

``K`` without these rows and columns is regular. If the constraint forces are zero, so that the load does no work on any
free motion, the solution is one of ``K u = f``, and all others differ from it by free motions.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from ..error_bounds.compliance import by_unknowns
from ..error_bounds.equilibrium import EquilibriumResidual, Solver, Statics
from ..error_bounds.kinematic_edge import Real, extended, norm
from ..error_bounds.resistance import displaced, resisted
from ..error_bounds.resolved import rest
from ..error_bounds.sparse_compliance import Factored
from ..solvers.sparse import SparseSolver
from ..structure.parts import Extended
from ..structure.topology import Index

# Singular values of sqrt(k) B, its columns of length one, are zero below ZERO times the square root of their number; a
# motion is surely resisted above _RESISTED.
ZERO = 16.0 * float(np.finfo(np.float64).eps)
_RESISTED = 4.0 * float(np.sqrt(np.finfo(Extended).eps))
# The threshold in place of _RESISTED for entries that could not be solved in extended precision.
_UNSOLVED = 16.0 * _RESISTED
# Rounding errors in the work of a load on a motion: relative error of given numbers, and roundings of computed ones.
GIVEN = 32.0 * float(np.finfo(np.float64).eps)
COMPUTED = 16.0
# If the work of a load exceeds this share of the sum of the magnitudes of its terms, it is certainly not zero.
PLAIN = 1e-6
# Number of steps of refinement, and the share of the load that may remain unbalanced.
_STEPS = 3
_BALANCED = 1e-12


@dataclass(frozen=True)
class ConstrainedSolution:
    """The solution of a part of the batch.

    Attributes
    ----------
    where
        Indices of the batch entries.
    values
        Values of all unknowns, (..., n).
    motions
        Values of the unknowns in each free motion, (motions, ..., n), the largest displacement being one; rotations
        are multiplied by the length of the longest piece for this.
    length_scale
        Length of the longest piece, (...).
    consistent
        Whether the load does no work on any of the motions, (...).
    """

    where: Any
    values: Real
    motions: Real
    length_scale: Real
    consistent: NDArray[np.bool_]

    @property
    def alone(self) -> ConstrainedSolution:
        """The solution of the single entry of a batch without axes, from arrays with a leading axis of size one."""
        motions = self.motions[:, 0]
        return ConstrainedSolution((), self.values[0], motions, self.length_scale[0], self.consistent[0])


def large(statics: Statics, solver: SparseSolver) -> Iterator[ConstrainedSolution]:
    """Solutions of the load cases of one large frame; nothing if its free motions are not found.

    Parameters
    ----------
    statics
        The equilibrium equations of the frame.
    solver
        Its solver.
    """
    if _drives_motion(solver.unsupported_motions(solver.excited), solver.load[solver.excited]):
        return
    freedom = solver.freedom
    if freedom.factor is None:
        return
    names = solver.unknown[solver.excited]
    kept = np.flatnonzero(~freedom.constrained)
    state, own = rest(statics, names[kept].tolist()), Factored(freedom.factor)
    whole = norm(state.balance * own.root)
    for _ in range(2 * _STEPS):
        state = state.corrected(own)
    shape = (freedom.motions.shape[1], *state.values.shape[:-1], len(names))
    motions = freedom.motions.T.reshape(shape[0], *(1,) * (len(shape) - 2), len(names))
    balanced = norm(state.balance * own.root) <= _BALANCED * whole
    yield _constrained((...,), state, names.tolist(), kept, own, np.broadcast_to(motions, shape), balanced)


def _drives_motion(motions: Array, load: Array) -> bool:
    """Whether every load case (n, cases) certainly does work on one of the motions (n, motions)."""
    if not motions.size:
        return False
    driven = np.abs(motions.T @ load) > PLAIN * (np.abs(motions).T @ np.abs(load))
    return bool(driven.any(axis=0).all())


def weighed(columns: Array, sizes: Array, k: Array) -> tuple[Array, Array]:
    """Deformations per unknown, weighted by the square root of the stiffness and with columns scaled to length one.

    Given are deformations (..., e, n), the magnitudes of their terms (n, ..., e), and stiffnesses (..., e). Columns
    that are rounding become zero. Returned are the matrix, (..., e, n), and the scale of the columns, (..., n).
    """
    weight = np.sqrt(np.abs(k))[..., None]
    weighted = weight * columns
    length = np.sqrt(np.sum(weighted**2, axis=-2))
    parts = np.sqrt(np.sum((weight * np.moveaxis(sizes, 0, -1)) ** 2, axis=-2))
    none = length <= ZERO * parts
    root: Array = 1.0 / np.where(none, np.where(parts > 0.0, parts, 1.0), length)
    return np.where(none[..., None, :], 0.0, weighted * root[..., None, :]), root


def free(scaled: Array, count: int, *, plainly: bool = True) -> tuple[Array, Index]:
    """Right singular vectors of deformations (..., e, n), as rows (count, n, n), and the numbers of free motions.

    The free motions are the last rows. With `plainly` the number is zero if there are other motions that extended
    precision cannot distinguish from free ones; else these count as free.
    """
    size = scaled.shape[-1]
    flat = scaled.reshape(int(np.prod(scaled.shape[:-2])), *scaled.shape[-2:])
    more = np.zeros((len(flat), max(size - flat.shape[-2], 0), size))
    _, values, rows = np.linalg.svd(np.concatenate([flat, more], axis=1), full_matrices=False)
    if plainly:
        rank = (values <= ZERO * np.sqrt(size)).sum(axis=-1)
        ranks = np.where((values <= _RESISTED).sum(axis=-1) == rank, rank, 0)
    else:
        ranks = (values <= _UNSOLVED).sum(axis=-1)
    return np.broadcast_to(rows, (count, size, size)), np.broadcast_to(ranks, (count,))


def free_motions_of(state: EquilibriumResidual, count: int) -> tuple[Array, Array]:
    """Unknowns in the free motions of `count` entries, (motions, count, n), and the largest displacements.

    The latter are (motions, count), rotations being multiplied by the distance from the origin. Both are zero where an
    entry has fewer motions than others, or motions that rounding cannot distinguish from free ones.
    """
    found = by_unknowns(state.double, state.double_springs, state.stiffness, state.unknowns, np.float64)
    scaled, root = weighed(*found)
    bases, ranks = free(scaled, count)
    most, size = int(ranks.max(initial=0)), bases.shape[-1]
    own = np.arange(size - most, size) >= size - ranks[:, None]
    shapes = np.moveaxis(np.where(own[..., None], bases[:, size - most :], 0.0), 1, 0) * root
    motions = extended(shapes if state.values.ndim > 1 else shapes[:, 0])
    moved = np.abs(displaced(state, state.unknowns, motions)[1]).astype(np.float64)
    away = state.change(extent(state.statics), 0).astype(np.float64) + state.plan.frame.size
    largest = np.maximum(moved[..., :3].max(axis=(-1, -2)), moved[..., 3:].max(axis=(-1, -2)) * away)
    whole = _absolute(state, motions).astype(np.float64)
    return whole.reshape(most, count, size), largest.reshape(most, count)


def _constrained(
    where: Any,
    state: EquilibriumResidual,
    unknowns: Sequence[int],
    kept: Index,
    solver: Solver,
    shapes: Array,
    sure: NDArray[np.bool_],
) -> ConstrainedSolution:
    """The solution in all unknowns and refined free motions, from the solved unknowns `kept` and rough motions."""
    values = extended(np.zeros((*state.values.shape[:-1], len(unknowns))))
    values[..., kept] = state.values
    whole = EquilibriumResidual(state.statics, state.change, unknowns, values, state.ndim)
    motions = extended(shapes).copy()
    for _ in range(_STEPS):
        left = -resisted(whole, unknowns, motions)[..., kept]
        motions[..., kept] += solver.solve(left.astype(solver.root.dtype))
    lengths = [np.max(each.length, axis=-1) for each in whole.springs]
    length_scale = reduce(np.maximum, lengths, extended(0.0))
    length_scale = np.broadcast_to(np.where(length_scale > 0.0, length_scale, state.plan.frame.size), values.shape[:-1])
    moved = displaced(whole, unknowns, motions)[1]
    weights = np.concatenate(
        [np.ones((*length_scale.shape, 3)), np.repeat(length_scale[..., None], 3, axis=-1)], axis=-1
    )
    motions = motions / np.max(np.abs(moved) * weights[..., None, :], axis=(-1, -2))[..., None]
    consistent = ~_driven(whole, motions) & sure
    return ConstrainedSolution(where, whole.absolute(), _absolute(whole, motions), length_scale, consistent)


def _driven(state: EquilibriumResidual, motions: Real) -> NDArray[np.bool_]:
    """Whether the load does more work than rounding on any of the motions (motions, ..., n), (...)."""
    coordinates, moved = displaced(state, state.unknowns, motions)
    work = np.abs(np.sum(motions * state.balance, axis=-1))
    forces = np.abs(state.loads.forces)
    spread = state.double.sizes(coordinates.astype(np.float64))
    # the rounding of a position is relative to its distance from the origin; a rotation acts on it
    off = np.max(np.abs(moved[..., 3:]), axis=-1) * state.change(extent(state.statics), 0)[..., None]
    reach = np.abs(moved)
    reach[..., :3] += off[..., None]
    could = np.sum(reach * forces, axis=(-1, -2))
    noise = np.sum(spread * (state.loads.error_bound + state.fine * forces), axis=(-1, -2))
    for springs, found, borne in zip(state.double_springs, state.deformation_sizes, state.member_forces, strict=True):
        sizes = springs.sizes(spread, coordinates)
        noise = noise + state.fine * np.sum(sizes * springs.stiffness * found, axis=(-1, -2))
        could = could + np.sum(springs.sizes(reach, coordinates) * np.abs(borne), axis=(-1, -2))
    opened, reached = (state.double.displacement_sizes(coordinates, each) for each in (spread, reach))
    links = zip(state.stiffness, opened, reached, state.displacement_sizes, state.generalised_forces, strict=True)
    for k, own, far, size, borne in links:
        noise = noise + state.fine * np.sum(own * k * size, axis=-1)
        could = could + np.sum(far * np.abs(borne), axis=-1)
    return np.asarray(np.any(~(work <= GIVEN * could + COMPUTED * noise), axis=0))


def extent(statics: Statics) -> Real:
    """Largest absolute coordinate of a described node, (...) with all batch axes."""
    topology, ndim = statics.plan.topology, len(statics.plan.frame.shape)
    each = (np.max(np.abs(topology.position(node)), axis=-1) for node in range(len(topology.frame.nodes)))
    return aligned(reduce(np.maximum, each, np.zeros(())), ndim)


def _absolute(state: EquilibriumResidual, motions: Real) -> Real:
    """The unknowns in motions, in the coordinates of the frame's own tree (without tree members)."""
    return state.in_own_tree(motions, displaced(state, state.unknowns, motions)[1])
