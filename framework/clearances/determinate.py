"""Contact in closed form, for statically determinate frames, in which no stiffness resists offsets in the joints.

A unit offset in component k then moves the links by u_k without any strain. The joint force in that component is the
work of the loads p on this motion, ``f_k = p . u_k``, for any stiffness (principle of virtual work). The offsets have
the directions of the forces, ``o = radius f / |f|``, and the frame moves by ``sum of u_k o_k`` in addition to its
displacement without clearance. Motions vary with the geometry, and loads mostly with the sample, so that only a few
operations are needed for each batch entry, which are recorded as a program and run chunk by chunk. This holds as long
as every journal is in contact, which a margin, computed with each chunk, shows.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array, aligned
from ..batched.broadcast import BroadcastSolver
from ..batched.chunks import CHUNK, steps
from ..program.calculation import Calculation, worth_compiling
from ..program.direct import Direct
from ..program.recording import Recording, Term
from ..results.linear import LinearResults
from ..structure.parts import Value, is_zero, total
from .contact_state import ClearanceComponents, sizes
from .joints import UNLOADED
from .unit_motions import UnitMotions

# The force in a component as a sum of products: right-hand-side parameters, and the work of the loads per unit of each.
Works = list[tuple[Value, Value]]

# Up to this many chunks are computed directly, without a program; number of chunks that machine code does at a time.
_FEW, _LONGER = 2, 16
# Lengths between these have squares of full precision.
_LEAST, _LARGEST = 1e-139, 1e139
# Rounding of a motion, relative to it.
_ROUNDED = 1e-14
# Motions may vary over at most one in _SHARE of the batch entries, or over _SMALL entries, as they are kept in memory.
_SHARE, _SMALL = 4, 2**12


class DeterminateContact:
    """Contact and displacement within clearances, where no stiffness resists offsets.

    Parameters
    ----------
    components
        The components with clearance.
    radius
        Clearance of each joint, (...).
    without_clearance
        The solution without clearances.
    motions
        The solution of the unloaded frame for a unit offset in each component.

    Attributes
    ----------
    pressed
        Whether the closed form holds: all journals are in contact at all entries with results.
    """

    def __init__(
        self,
        components: ClearanceComponents,
        radius: Sequence[Array],
        without_clearance: LinearResults,
        motions: UnitMotions,
    ) -> None:
        self.components, self.without_clearance, self.motions = components, without_clearance, motions
        self._grid = without_clearance.plan.grid
        self._radius = [self._grid.value(each) for each in radius]
        self._pressed: bool | None = None

    @property
    def pressed(self) -> bool:
        """Whether the closed form holds: all journals are in contact, by a margin, at all entries with results."""
        if self._pressed is None:
            self._compute(lambda take: [], [])
        assert self._pressed is not None
        return self._pressed

    @cached_property
    def rounding(self) -> Array:
        """Share of the largest force below which the force in a joint is rounding, (joints, ...)."""
        return rounding_of_forces(self.components, self.motions, len(self._grid.shape))

    def displacement(self, node: str) -> Array | None:
        """Displacement of a node in global axes, (..., 6); None if a journal is not in contact."""
        if self._pressed is False:
            return None
        plan = self.without_clearance.plan
        number = plan.topology.number[node]
        out = self.without_clearance.stacked(plan.tree.global_rows(number))
        moved = self.motions.rows(self.motions.plan.tree.global_rows(number))
        rows = [k for k in range(6) if moved[..., k].any()]
        places = [out[..., k] for k in rows]

        def summed(take: Callable[[Value], Any]) -> list[Any]:
            offsets = self._offsets(take)
            return [_sum((take(self._value(u[..., k])), o) for u, o in zip(moved, offsets, strict=True)) for k in rows]

        self._compute(summed, places)
        return out if self._pressed else None

    # -- formulas, for numbers or terms of a recording --------------------------------------------------------------

    @cached_property
    def _works(self) -> list[Works]:
        return virtual_works(self.without_clearance, self.motions)

    def _forces(self, take: Callable[[Value], Any]) -> list[Any]:
        return [_sum((take(value), take(factor)) for value, factor in work) for work in self._works]

    def _lengths(self, take: Callable[[Value], Any]) -> list[Any]:
        """Magnitude of the force in each joint."""
        forces, own = self._forces(take), self.components.own
        squares = [_sum((f, f) for f, at in zip(forces, own, strict=True) if at == j) for j in range(len(self._radius))]
        return [0.0 if is_zero(square) else np.sqrt(square) for square in squares]

    def _offsets(self, take: Callable[[Value], Any]) -> list[Any]:
        """Displacement within the clearance in each component."""
        lengths = self._lengths(take)
        return [
            0.0 if is_zero(force) else take(self._radius[j]) * (force / lengths[j])
            for force, j in zip(self._forces(take), self.components.own, strict=True)
        ]

    def _margin(self, take: Callable[[Value], Any]) -> Any:
        """A number above zero where every joint force is well above rounding and its square has full precision.

        Magnitudes are added, not compared, so that a NaN anywhere makes it NaN.
        """
        size, lengths = self._grid.value(sizes(self.without_clearance.frame)), self._lengths(take)
        angular = self.components.is_rotation[self.components.starts]
        arms = [1.0 / size if rotation else 1.0 for rotation in angular]
        scale = _sum((length, take(arm)) for length, arm in zip(lengths, arms, strict=True))
        for value, (force, moment) in _load_bounds(self.without_clearance):
            scale = scale + abs(take(value)) * take(force + moment / size)
        found = take(_LARGEST) - scale - sum(lengths[1:], lengths[0])
        for length, arm, share in zip(lengths, arms, self.rounding, strict=True):
            found = np.minimum(found, length - scale * take(self._value(share) / arm) - take(_LEAST))
        return found

    # -- evaluation over the batch ----------------------------------------------------------------------------------

    def _compute(self, results: Callable[[Callable[[Value], Any]], list[Any]], places: Sequence[Array]) -> None:
        """Add results to the arrays `places`, and determine `pressed` unless it is known."""
        if self._pressed is None and not self._sound:
            self._pressed = False
            return
        with np.errstate(all="ignore"):
            if worth_compiling(self._grid.sizes[-1]) or self._grid.sizes[-1] > _FEW * CHUNK:
                self._by_chunks(results, places)
                return
            take = Direct(self._grid.shape).take
            if self._pressed is None:
                self._pressed = self._holds(np.asarray(self._margin(take)), ())
            for place, value in zip(places, results(take), strict=True):
                place += value

    def _by_chunks(self, results: Callable[[Callable[[Value], Any]], list[Any]], places: Sequence[Array]) -> None:
        recording, shape = Recording(), self._grid.shape
        margin = [self._margin(recording.take)] if self._pressed is None else []
        found = results(recording.take)
        asked = [(place, term) for place, term in zip(places, found, strict=True) if isinstance(term, Term)]
        terms = [*(term for _, term in asked), *margin]
        if not terms:
            return
        calculation = Calculation.recorded(recording, terms, shape)
        axis, step = steps(self._grid, ())
        step *= _LONGER if calculation.choice.compiled else 1
        pressed = True
        for start in range(0, shape[axis], step):
            indices = slice(start, min(start + step, shape[axis]))
            part, cut = (slice(None),) * axis + (indices,), list(shape)
            cut[axis] = indices.stop - start
            made = [np.empty(calculation.of(term.mask, tuple(cut))) for term in terms]
            calculation.run(axis, indices, made)
            for (place, _), value in zip(asked, made, strict=False):
                place[part] += value
            pressed = pressed and all(self._holds(value, part) for value in made[len(asked) :])
        self._pressed = pressed if margin else self._pressed

    @cached_property
    def _sound(self) -> bool:
        """Whether each joint carries a force, and pivots do not suggest that the frame is singular."""
        solutions = self.without_clearance, self.motions.solution
        borne = {int(j) for j, work in zip(self.components.own, self._works, strict=True) if work}
        return len(borne) == len(self._radius) and not any(
            isinstance(each.solver, BroadcastSolver) and (each.solver.suspects() & ~each.lost).any()
            for each in solutions
        )

    def _holds(self, margin: Array, part: tuple[slice, ...]) -> bool:
        """Whether the margin, at a part of the batch, is above zero wherever there are results."""
        lost = self.without_clearance.lost[part]
        lost = np.asarray(
            lost.all(axis=tuple(axis for axis, size in enumerate(margin.shape) if size == 1), keepdims=True)
        )
        return bool(((margin > 0.0) | lost).all())

    def _value(self, array: Array) -> Value:
        return self._grid.value(aligned(array, len(self._grid.shape)))


def virtual_works(without_clearance: LinearResults, motions: UnitMotions) -> list[Works]:
    """The joint force in each component that no stiffness resists, as a sum of products, see `Works`.

    Prescribed displacements and offsets do no work, as the unit offset causes no strain.
    """
    plan = without_clearance.plan
    dofs = list(plan.forces)
    moved = motions.moved(dofs)
    out: list[Works] = []
    for u in moved:
        works: dict[int, Value] = {}
        for k, dof in enumerate(dofs):
            if not u[..., k].any():
                continue
            for source, parts in plan.forces[dof].items():
                value = plan.grid.value(aligned(u[..., k], len(plan.grid.shape)))
                works[source] = works.get(source, 0.0) + total(parts)[1] * value
        out.append([(plan.rhs_parameters.values[source], work) for source, work in works.items()])
    return out


def told_by_work(components: ClearanceComponents, without_clearance: LinearResults, motions: UnitMotions) -> bool:
    """Whether `forces_by_work` applies: both solutions have the same node numbers, and no joint is a screw."""
    frame = without_clearance.frame
    screws = np.any([frame.joints[j].element.pitch for j in components.names])
    return bool(frame.size) and not screws and without_clearance.plan.topology.number == motions.plan.topology.number


def forces_by_work(without_clearance: LinearResults, motions: UnitMotions) -> Array:
    """Joint forces without clearance in components that no stiffness resists, (n, ...), to the rounding of the loads.

    Recovered from member forces, the forces of ideal joints have the rounding of stiffness times displacement, which
    may be far larger than that of the loads, so that an unloaded joint would seem to carry a force.
    """
    works = virtual_works(without_clearance, motions)
    out = np.zeros((len(works), *without_clearance.frame.shape))
    for k, work in enumerate(works):
        for value, factor in work:
            out[k, ...] += np.asarray(value * factor, dtype=np.float64)
    return out


def determinate_contact(
    components: ClearanceComponents, radius: Sequence[Array], without_clearance: LinearResults, motions: UnitMotions
) -> DeterminateContact | None:
    """Contact in closed form, where no stiffness resists offsets; None where the frame is not suited to it.

    Parameters
    ----------
    components, radius, without_clearance, motions
        As for `DeterminateContact`.

    Returns
    -------
    DeterminateContact or None
        The contact; None where offsets move unloaded components or several parts of the frame, deform a spring, or
        cause motions that vary over much of a long batch; for a single entry; and for other methods than broadcasting.
    """
    solvers = without_clearance.solver, motions.solution.solver
    loaded, moved = without_clearance.plan, motions.plan
    plans = [solver.plan for solver in solvers if isinstance(solver, BroadcastSolver)]
    if len(plans) < 2 or any(plan.entry is not None and not plan.grid.shape for plan in plans):
        return None
    count, whole = motions.entries, loaded.grid.sizes[-1]
    if whole < 2 or not kept_in_memory(count, whole):
        return None
    if not moved.excited <= loaded.excited or without_clearance.solver.parts > 1:
        return None
    if not told_by_work(components, without_clearance, motions) or motions.strained:
        return None
    return DeterminateContact(components, radius, without_clearance, motions)


def kept_in_memory(count: int, whole: int) -> bool:
    """Whether motions at so many entries are kept in memory for a batch of `whole` entries."""
    return count <= _SMALL or _SHARE * count <= whole


def rounding_of_forces(components: ClearanceComponents, motions: UnitMotions, ndim: int) -> Array:
    """Share of the largest force below which a force by virtual work is rounding, (joints, ...) with `ndim` batch axes.

    The closer a loop of rigid links is to a dead point, the larger are its motions by unit offsets, and the larger is
    the rounding in displacements that should be zero. If members or springs close the loop, pivots reveal such a pose.
    """
    eliminated, size = motions.plan.tree.elimination.rows, motions.solution.frame.size
    if not eliminated:
        return np.full((len(components.names), *(1,) * ndim), UNLOADED)
    lengths = [size if key % 6 >= 3 else 1.0 for key in eliminated]
    moved = np.abs(motions.rows(list(eliminated.values()))) * lengths
    largest = moved.max(axis=-1)
    largest[components.is_rotation] /= size or 1.0
    share = np.maximum(UNLOADED, _ROUNDED * np.maximum.reduceat(largest, components.starts, axis=0))
    return np.stack([aligned(each, ndim) for each in share])


def _load_bounds(solution: LinearResults) -> Iterator[tuple[Value, list[Value]]]:
    """Right-hand-side parameters of the loads, with the largest force and moment on a node per unit of each."""
    largest: dict[int, list[Value]] = {}
    for a, by_source in solution.plan.forces.items():
        for source, parts in by_source.items():
            two = largest.setdefault(source, [0.0, 0.0])
            two[a % 6 // 3] = np.maximum(two[a % 6 // 3], np.abs(total(parts)[1]))
    for source, two in largest.items():
        yield solution.plan.rhs_parameters.values[source], two


def _sum(terms: Iterator[tuple[Any, Any]]) -> Any:
    """Sum of products of pairs, without those that contain an exact zero."""
    result: Any = 0.0
    for a, b in terms:
        if not (is_zero(a) or is_zero(b)):
            product = a * b
            result = product if is_zero(result) else result + product
    return result
