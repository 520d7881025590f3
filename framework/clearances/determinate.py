"""Contact where offsets in the joints meet no stiffness: in closed form, from equilibrium alone.

A unit offset then moves the links without straining anything, by u_k. The force in that component is the work of the
loads on this motion, ``f_k = p . u_k``, whatever the stiffness is (principle of virtual work); the journals lie along
the forces, ``o = radius f / |f|``, and the frame moves by ``sum of u_k o_k`` beside what it moves without clearance.
Motions vary with the geometry and loads mostly with the sample, so that a few operations for each entry of the batch
are left, which are written down as one program and run chunk by chunk. It holds while every journal is pressed against
its bearing; a margin, which comes with each chunk, tells.
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
from ..structure.parts import Row, Value, add_row, is_zero, total
from .contact_state import UNLOADED, ClearanceComponents, sizes

# Force in a component: numbers that loads are made of, and the work of a unit of each.
Works = list[tuple[Value, Value]]

# Up to so many chunks are done at once, without writing down what is done; machine code does so many at a time.
_FEW, _LONGER = 2, 16
# Lengths between these have squares that hold all digits.
_LEAST, _LARGEST = 1e-139, 1e139
# Deformation of a spring by a unit offset, an angle or a length at the size of the frame, up to which it is rounding.
_UNSTRAINED = 1e-9
# Share of a motion that is its rounding.
_ROUNDED = 1e-14
# Share of the batch that motions may vary over, as they are held in memory, beyond so many of them.
_SHARE, _SMALL = 4, 2**12


class DeterminateContact:
    """Displacement within clearances that no stiffness resists.

    Parameters
    ----------
    components
        The components with clearance.
    radius
        Clearance of each joint, (...).
    without_clearance
        The solution without clearances.
    motions
        That of the frame without loads for a unit offset in each component, (n, ...).

    Attributes
    ----------
    pressed
        Whether all journals are pressed against their bearings at all entries that have results, which it takes; None
        while nobody knows.
    """

    def __init__(
        self,
        components: ClearanceComponents,
        radius: Sequence[Array],
        without_clearance: LinearResults,
        motions: LinearResults,
    ) -> None:
        self.components, self.without_clearance, self.motions = components, without_clearance, motions
        self._grid = without_clearance.plan.grid
        self._radius = [self._grid.value(each) for each in radius]
        self._pressed: bool | None = None

    @property
    def pressed(self) -> bool:
        """Whether all journals are pressed against their bearings wherever there are results, and those are plain."""
        if self._pressed is None:
            self._compute(lambda take: [], [])
        assert self._pressed is not None
        return self._pressed

    @cached_property
    def rounding(self) -> Array:
        """Share of the largest force below which one is rounding, by joint, (joints, ...)."""
        return rounding_of_forces(self.components, self.motions, len(self._grid.shape))

    def displacement(self, node: str) -> Array | None:
        """Displacement of a node in global axes, (..., 6); None where a journal is not pressed against its bearing."""
        if self._pressed is False:
            return None
        plan = self.without_clearance.plan
        number = plan.topology.number[node]
        out = self.without_clearance.stacked(plan.tree.global_rows(number))
        moved = _stacked(self.motions, self.motions.plan.tree.global_rows(number))
        rows = [k for k in range(6) if moved[..., k].any()]
        places = [out[..., k] for k in rows]

        def summed(take: Callable[[Value], Any]) -> list[Any]:
            offsets = self._offsets(take)
            return [_sum((take(self._value(u[..., k])), o) for u, o in zip(moved, offsets, strict=True)) for k in rows]

        self._compute(summed, places)
        return out if self._pressed else None

    # -- written down -----------------------------------------------------------------------------------------------

    @cached_property
    def _works(self) -> list[Works]:
        return virtual_works(self.without_clearance, self.motions)

    def _forces(self, take: Callable[[Value], Any]) -> list[Any]:
        return [_sum((take(value), take(factor)) for value, factor in work) for work in self._works]

    def _lengths(self, take: Callable[[Value], Any]) -> list[Any]:
        """Size of the force in each joint."""
        forces, own = self._forces(take), self.components.own
        squares = [_sum((f, f) for f, at in zip(forces, own, strict=True) if at == j) for j in range(len(self._radius))]
        return [0.0 if is_zero(square) else np.sqrt(square) for square in squares]

    def _offsets(self, take: Callable[[Value], Any]) -> list[Any]:
        """Displacement within the clearance by component."""
        lengths = self._lengths(take)
        return [
            0.0 if is_zero(force) else take(self._radius[j]) * (force / lengths[j])
            for force, j in zip(self._forces(take), self.components.own, strict=True)
        ]

    def _margin(self, take: Callable[[Value], Any]) -> Any:
        """Above zero where every force is one, by more than is asked of its state, and its square has all digits.

        Sizes of forces are added up, not compared, so that what is no number anywhere is none here.
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

    # -- carried out ------------------------------------------------------------------------------------------------

    def _compute(self, results: Callable[[Callable[[Value], Any]], list[Any]], places: Sequence[Array]) -> None:
        """Add results to what is in their places, and find out whether they hold, unless that is known."""
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
        """Whether each joint bears a force, and no pivot raises the suspicion that the frame is singular."""
        solutions = self.without_clearance, self.motions
        borne = {int(j) for j, work in zip(self.components.own, self._works, strict=True) if work}
        return len(borne) == len(self._radius) and not any(
            isinstance(each.solver, BroadcastSolver) and (each.solver.suspects() & ~each.lost).any()
            for each in solutions
        )

    def _holds(self, margin: Array, part: tuple[slice, ...]) -> bool:
        """Whether a margin, at a part of the batch, is above zero wherever there are results."""
        lost = self.without_clearance.lost[part]
        lost = np.asarray(
            lost.all(axis=tuple(axis for axis, size in enumerate(margin.shape) if size == 1), keepdims=True)
        )
        return bool(((margin > 0.0) | lost).all())

    def _value(self, array: Array) -> Value:
        return self._grid.value(aligned(array, len(self._grid.shape)))


def virtual_works(without_clearance: LinearResults, motions: LinearResults) -> list[Works]:
    """Each force in a component that no stiffness resists as a sum of products: loads, and the work of a unit of each.

    Displacements and offsets that are imposed do no work, as such a unit offset strains nothing.
    """
    plan = without_clearance.plan
    dofs = list(plan.forces)
    moved = _stacked(motions, [motions.plan.tree.row(*divmod(dof, 6)) for dof in dofs])
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


def told_by_work(components: ClearanceComponents, without_clearance: LinearResults, motions: LinearResults) -> bool:
    """Whether `motions` move the nodes that loads act on as they are numbered there, and no screw makes them turn."""
    frame = without_clearance.frame
    screws = np.any([frame.joints[j].element.pitch for j in components.names])
    return bool(frame.size) and not screws and without_clearance.plan.topology.number == motions.plan.topology.number


def forces_by_work(without_clearance: LinearResults, motions: LinearResults) -> Array:
    """Forces without clearance in components that no stiffness resists, (n, ...), to the rounding of the loads.

    Forces of ideal joints are what members leave unbalanced, with the rounding of stiffness times displacement, which
    may be far more than that of the loads: a joint that bears none would be told to bear one.
    """
    works = virtual_works(without_clearance, motions)
    out = np.zeros((len(works), *without_clearance.frame.shape))
    for k, work in enumerate(works):
        for value, factor in work:
            out[k, ...] += np.asarray(value * factor, dtype=np.float64)
    return out


def determinate_contact(
    components: ClearanceComponents, radius: Sequence[Array], without_clearance: LinearResults, motions: LinearResults
) -> DeterminateContact | None:
    """Contact in closed form where offsets meet no stiffness; None where the frame is not of the kind for it.

    Parameters
    ----------
    components, radius, without_clearance, motions
        As for `DeterminateContact`.

    Returns
    -------
    DeterminateContact or None
        None where offsets reach what loads do not, or several parts of the frame, where they strain a spring or their
        motions vary over much of a long batch, for one entry, and for frames that are not solved by broadcasting.
    """
    solvers = without_clearance.solver, motions.solver
    if not all(isinstance(solver, BroadcastSolver) and solver.plan.entry is None for solver in solvers):
        return None
    loaded, moved = without_clearance.plan, motions.plan
    count, whole = moved.grid.sizes[-1], loaded.grid.sizes[-1]
    if whole < 2 or (count > _SMALL and _SHARE * count > whole):
        return None
    if not moved.excited <= loaded.excited or without_clearance.solver.parts > 1:
        return None
    if not told_by_work(components, without_clearance, motions) or strained(motions):
        return None
    return DeterminateContact(components, radius, without_clearance, motions)


def strained(motions: LinearResults) -> bool:
    """Whether a unit offset in a joint deforms a spring, so that its motion depends on how stiff that is."""
    tree, size = motions.plan.tree, motions.frame.size
    edges = [(branch.edge, [tree.joint_row(branch, k) for k in range(6)]) for branch in tree.branches]
    rows: list[Row] = []
    for edge, moved in [*edges, *tree.closing]:
        for k, row in enumerate(edge.elastic(moved)):
            if k not in edge.ideal and not is_zero(edge.stiffness[k]):
                rows.append({})
                add_row(rows[-1], row, 1.0 if k < 3 else size)
    return bool(rows) and not bool(np.abs(_stacked(motions, rows)).max(initial=0.0) <= _UNSTRAINED * min(1.0, size))


def rounding_of_forces(components: ClearanceComponents, motions: LinearResults, ndim: int) -> Array:
    """Share of the largest force below which one by the work on these motions is rounding, by joint, (joints, ...)
    with `ndim` axes of the batch.

    The nearer a loop of rigid links is to a dead point, the farther unit offsets move it, and with that grows the
    rounding of what does not move at all. Where members or springs close the loop, pivots tell of such a pose.
    """
    eliminated, size = motions.plan.tree.elimination.rows, motions.frame.size
    if not eliminated:
        return np.full((len(components.names), *(1,) * ndim), UNLOADED)
    lengths = [size if key % 6 >= 3 else 1.0 for key in eliminated]
    moved = np.abs(_stacked(motions, list(eliminated.values()))) * lengths
    largest = moved.max(axis=-1)
    largest[components.is_rotation] /= size or 1.0
    share = np.maximum(UNLOADED, _ROUNDED * np.maximum.reduceat(largest, components.starts, axis=0))
    return np.stack([aligned(each, ndim) for each in share])


def _stacked(motions: LinearResults, rows: Sequence[Row]) -> Array:
    """Values of rows in motions by unit offsets, (n, ..., rows), zero at entries that were left out."""
    found = motions.stacked(rows)
    return found if motions.frame.absent is None else np.where(motions.lost[..., None], 0.0, found)


def _load_bounds(solution: LinearResults) -> Iterator[tuple[Value, list[Value]]]:
    """Numbers that loads are made of, with the largest force and moment on a node for a unit of each."""
    largest: dict[int, list[Value]] = {}
    for a, by_source in solution.plan.forces.items():
        for source, parts in by_source.items():
            two = largest.setdefault(source, [0.0, 0.0])
            two[a % 6 // 3] = np.maximum(two[a % 6 // 3], np.abs(total(parts)[1]))
    for source, two in largest.items():
        yield solution.plan.rhs_parameters.values[source], two


def _sum(terms: Iterator[tuple[Any, Any]]) -> Any:
    """Sum of products, without those of exact zeros."""
    result: Any = 0.0
    for a, b in terms:
        if not (is_zero(a) or is_zero(b)):
            product = a * b
            result = product if is_zero(result) else result + product
    return result
