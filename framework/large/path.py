"""Equilibrium paths past limit points, by arc length.

Unknowns and load factor go together along the path: a step along the tangent, then Newton's method in the plane across
it (Riks, J. Appl. Mech. 39 (1972) 1060-1065; Ramm 1981), its length following the number of iterations. Where the frame
is kinematically unstable at rest, as within clearances, there is no tangent there: the path goes on from the
equilibrium under the first share of the load.
"""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..batched.idle import released_at_rest
from ..batched.plan import Plan
from ..checked import whole_number
from ..continuation import Index, PathBatch, turning_values
from ..described.released_ends import with_hinges
from ..description import Description, excluding
from ..dofs import component
from ..elementwise import contracted
from ..errors import FrameError, PathWarning
from ..names import found
from .clearances import start
from .model import Model
from .newton import Newton, bordered
from .numbers import Where
from .search import Search
from .state import DisplacedState, Mask, StateOfEntries
from .tree_equations import Linearisation

# Iterations that a step is to take, at most takes, and how much its length may grow.
_AIM, _MOST, _GROWTH = 5, 12, 1.5
_CLOSE = 1e-16
# How far from its tangent the path may bend in a step, as a share of the step.
_ASIDE = 0.5
# Step below which a path is given up, as a share of the first.
_LEAST = 1e-4


@dataclass(frozen=True, repr=False)
class EquilibriumPath:
    """Points of equilibrium along a path.

    Attributes
    ----------
    frame
        The description.
    factor
        Load factor, (points, ...); NaN after the end of an entry's path.
    stable
        Whether the energy has a minimum there, (points, ...).
    reached
        Whether the path went as far as it was to, (...).
    """

    frame: Description = field(repr=False)
    factor: Array
    stable: NDArray[np.bool_]
    reached: NDArray[np.bool_]
    _model: Model = field(repr=False)
    _states: list[DisplacedState] = field(repr=False)

    def __repr__(self) -> str:
        return f"<EquilibriumPath of {len(self.factor)} points of {self.frame!r}>"

    def displacement(self, node: str) -> Array:
        """Displacement and rotation vector of a node at every point of the path, in global axes.

        Parameters
        ----------
        node
            Name of the node.

        Returns
        -------
        ndarray
            ``ux uy uz`` as lengths and the rotation vector in radians, (points, ..., 6); NaN after the end of an
            entry's path.

        Raises
        ------
        FrameError
            If the node is unknown.
        """
        name = found("node", node, self.frame.nodes, self.frame.aliases)
        number = self._model.topology.number[name]
        parts = [state.moved(number) for state in self._states]
        shaped = np.moveaxis(np.stack(parts), 1, -1).reshape(len(parts), *self.shape, 6)
        return np.where(np.isnan(self.factor)[..., None], np.nan, shaped)

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.frame.shape

    @cached_property
    def limits(self) -> list[Array]:
        """Load factors of the limit points, (k,) for each batch entry, entries flattened.

        Each is the summit of the parabola through three points of the path.
        """
        return [turning_values(column[np.isfinite(column)]) for column in self.factor.reshape(len(self.factor), -1).T]


def follow(frame: Description, node: str, name: str, to: float, steps: int, first: float) -> EquilibriumPath:
    """Follow the path from rest until a displacement component passes `to`; see `Frame.path`."""
    node = found("node", node, frame.nodes, frame.aliases)
    if to == 0.0 or not np.isfinite(to):
        raise FrameError(f"path to {name} = {to!r} of {node!r}: give a displacement that is not zero")
    whole_number(steps, f"steps of the path of {node!r}", 1)
    if isinstance(first, bool) or not 0.0 < first < np.inf:
        raise FrameError(f"path of {node!r} with first = {first!r}: give a load factor above zero, such as 0.05")
    goal = node, component(name), to
    frame = released_at_rest(frame, f"path of {node!r}")
    model = _model(frame, node)
    parts = model.planes.split()
    if len(parts) < 2:
        path = _traced(model, goal, steps, first)
    else:
        masks = [np.broadcast_to(part, frame.shape) for part in parts]
        models = [_model(excluding(frame, ~mask), node) for mask in masks]
        path = _together(model, masks, [_traced(each, goal, steps, first) for each in models])
    lost = ~path.reached & np.isfinite(path.factor[0])
    if lost.any():
        warnings.warn(_message(path, lost, node, name, to), PathWarning, stacklevel=3)
    return path


def _model(frame: Description, node: str) -> Model:
    """The frame compiled, where it has a path."""
    model = Model(Plan(with_hinges(frame.copy()), cut=True))
    if not model.size:
        raise FrameError(f"path of {node!r}: nothing in the frame can move; free or prescribe a displacement")
    for number in model.contacts:
        raise FrameError(
            f"joint {model.edges[number].edge.name!r} is ideal (inf) where it has clearance: for a path give it a "
            "contact stiffness, such as 2e11, or no clearance"
        )
    return model


def _traced(model: Model, goal: tuple[str, int, float], steps: int, first: float) -> EquilibriumPath:
    """Paths of all entries, in the coordinates of a model."""
    tracer = _Tracer(model, goal, first)
    for _ in range(steps):
        if not tracer.point():
            break
    factor = np.stack(tracer.factors).reshape(len(tracer.factors), *model.frame.shape)
    stable = np.stack(tracer.stables).reshape(len(tracer.stables), *model.frame.shape)
    return EquilibriumPath(model.frame, factor, stable, tracer.reached, model, tracer.states)


def _together(model: Model, masks: list[Mask], paths: list[EquilibriumPath]) -> EquilibriumPath:
    """Paths of a batch from those of its parts, the entries of which have kept to planes of their own."""
    shape, points = model.frame.shape, max(len(path.factor) for path in paths)
    factor, stable = np.full((points, *shape), np.nan), np.zeros((points, *shape), dtype=bool)
    reached = np.zeros(shape, dtype=bool)
    states = [DisplacedState.start(model, masks[0].size) for _ in range(points)]
    for mask, path in zip(masks, paths, strict=True):
        index = np.flatnonzero(mask)
        factor[: len(path.factor), mask], stable[: len(path.stable), mask] = path.factor[:, mask], path.stable[:, mask]
        reached[mask] = path.reached[mask]
        for whole, part in zip(states, path._states, strict=False):
            whole.displacements[..., index] = part.displacements[..., index]
            whole.rotations[..., index] = part.rotations[..., index]
    return EquilibriumPath(model.frame, factor, stable, reached, model, states)


def _message(path: EquilibriumPath, lost: NDArray[np.bool_], node: str, name: str, to: float) -> str:
    """Where paths ended that did not reach what they were to."""
    first = int(np.argmax(lost))
    entry = np.unravel_index(first, lost.shape)
    moved = path.displacement(node)[..., component(name)].reshape(len(path.factor), -1)[:, first]
    points = int(np.isfinite(moved).sum())
    which = f" (entry {tuple(int(k) for k in entry)} of {int(lost.sum())} such)" if lost.shape else ""
    return (
        f"the path to {name} = {to:g} of {node!r} ended after {points} points at {moved[points - 1]:.6g}{which}: allow "
        "more steps, or begin with another first"
    )


@dataclass(frozen=True, eq=False)
class _Corrected:
    """Ends of a step: states, load factors, iterations and whether the energy has a minimum there, (m,) each."""

    state: StateOfEntries
    factor: Array
    iterations: NDArray[np.int64]
    stable: Mask


class _Tracer(PathBatch[_Corrected]):
    """Paths of all entries, a point at a time."""

    def __init__(self, model: Model, goal: tuple[str, int, float], first: float) -> None:
        self.model, self.newton = model, Newton(model)
        node, self.component, self.to = goal
        self.node = model.topology.number[node]
        count = len(model.present)
        where = model.where(np.arange(count))
        self.whole, self.none = (self.newton.equations(where, count, factor) for factor in (1.0, 0.0))
        self.state = self.newton.start(count)
        self.weight = self.whole.scale**2
        self.going = model.present.copy()
        self.reached = np.zeros(model.frame.shape, dtype=bool)
        self.factor = np.zeros(count)
        super().__init__(np.full(count, np.nan), 0.0)
        self.first, self.pending = first, np.zeros(count, dtype=bool)
        self.stable = np.zeros(count, dtype=bool)
        self.along, self.slope = np.zeros((0, count)), np.zeros(count)
        self.factors, self.states = [np.where(self.going, 0.0, np.nan)], [self._space()]
        self.stables = [self.going.copy()]
        if self._unstable_at_rest():
            self._begin(where)

    def point(self) -> bool:
        """One more point of each path that has not ended; whether there is any."""
        ahead, slope = self._tangent()
        self.going &= np.isfinite(slope)
        if not len(self.along):
            self.along, self.step = ahead, self.first / slope
            self.shortest = _LEAST * self.step
        sign = np.where(self._norm(ahead, self.along) < 0.0, -1.0, 1.0)
        self.along, self.slope = sign * ahead, sign * slope
        self.pending = self.going.copy()
        self.run()
        self.going &= ~self.stalled
        if not self.going.any():
            return False
        self._add(self.stable)
        return bool(self.going.any())

    def wanted(self) -> Index:
        """Entries whose next point is still to be found."""
        return np.flatnonzero(self.pending & ~self.stalled)

    def attempt(self, paths: Index) -> tuple[_Corrected, Mask]:
        """Points of equilibrium a step further, and which of these were found."""
        found = self._corrected(paths)
        return found, found.iterations[paths] <= _MOST

    def accept(self, paths: Index, points: _Corrected, good: Mask) -> None:
        """Go on to the points that were found."""
        self.state.put(paths, points.state.taken(paths))
        self.factor[paths], self.stable[paths] = points.factor[paths], points.stable[paths]
        grown = np.clip(np.sqrt(_AIM / np.maximum(points.iterations[paths], 1)), 0.5, _GROWTH)
        self.step[paths] *= grown
        self.pending[paths] = False

    def _unstable_at_rest(self) -> bool:
        """Whether some entry is kinematically unstable at rest."""
        at, _ = self._linear(self.state, None, self.factor)
        return not bool((self.newton.factor(at).pivots[:, self.going] > self.newton.elimination.zero).all())

    def _begin(self, where: Where) -> None:
        """Go to the equilibrium under the first share of the load at once."""
        begin = start(self.newton, where, len(self.factor), self.first)
        there = Search(self.newton).solve(where, begin, 0.0, self.first)
        self.going &= there.converged
        self.state, self.factor = there.state, np.where(self.going, self.first, 0.0)
        self._add(there.stable)

    def _add(self, stable: Mask) -> None:
        """One more point where the entries are now; those that have come far enough end there."""
        self.factors.append(np.where(self.going, self.factor, np.nan))
        self.states.append(self._space())
        self.stables.append(stable & self.going)
        here = self._value(self.states[-1])
        beyond = here >= self.to if self.to > 0.0 else here <= self.to
        self.reached |= (self.going & beyond).reshape(self.reached.shape)
        self.going &= ~beyond

    def _space(self) -> DisplacedState:
        return self.newton.space(self.state.taken(np.arange(len(self.factor))))

    def _value(self, state: DisplacedState) -> Array:
        return np.asarray(state.moved(self.node)[self.component])

    def _tangent(self) -> tuple[Array, Array]:
        """Unit direction of the path: coordinates (size, m) and load factor (m,)."""
        at, load = self._linear(self.state, None, self.factor)
        ahead = self.newton.step(at, self.whole.prescribed_values, self.newton.factor(at).solve, load)
        size = np.sqrt(self._norm(ahead, ahead))
        slope = 1.0 / np.where(size > 0.0, size, np.nan)  # without a load there is no path
        return ahead * slope, slope

    def _norm(self, a: Array, b: Array) -> Array:
        out: Array = contracted("im,im->m", self.weight * a, b)
        return out

    def _linear(
        self, state: StateOfEntries, stresses: list[Array] | None, factor: Array
    ) -> tuple[Linearisation, Array]:
        """Forces and tangent at a load factor (m,), and the loads (size, m)."""
        whole, none = (part.linearised(state, stresses) for part in (self.whole, self.none))
        mixed = replace(
            none,
            forces=none.forces + factor * (whole.forces - none.forces),
            values=none.values + factor * (whole.values - none.values),
        )
        return mixed, none.forces - whole.forces

    def _corrected(self, paths: Index) -> _Corrected:
        """Points of equilibrium in the plane at the ends of some steps; more iterations than allowed where none."""
        done = np.ones(len(self.factor), dtype=bool)
        done[paths] = False
        step, share = (np.where(done, 0.0, self.step * each) for each in (self.along, self.slope))
        at, _ = self._linear(self.state, None, self.factor)
        state, factor = self.whole.advanced(self.state, step), self.factor + share
        stresses = self.whole.step_stresses(at, step)
        prescribed, stable = self.whole.prescribed_values, np.zeros(len(factor), dtype=bool)
        iterations = np.zeros(len(factor), dtype=np.int64)
        aside = np.zeros_like(step)
        while not done.all() and iterations.max() <= _MOST:
            at, load = self._linear(state, stresses, factor)
            factors = self.newton.factor(at)
            by_load = self.newton.step(at, prescribed, factors.solve, load)
            there = prescribed - self.whole.prescribed_residual(state)
            free = self.newton.step(at, factor * prescribed - there, factors.solve)
            step, change = bordered(self.weight * self.along, free, by_load)
            step = np.where(done, 0.0, step)
            usable = np.isfinite(step).all(axis=0) & np.isfinite(change)
            step = np.where(usable, step, 0.0)
            aside += step
            state = self.whole.advanced(state, step)
            factor = np.where(done | ~usable, factor, factor + change)
            stresses = self.whole.step_stresses(at, step)
            iterations += ~done
            # without that of the reactions, on prescribed displacements that are where they should be but for rounding
            forces, push, moved = (part[: self.model.free] for part in (at.forces, load, step))
            work = np.abs(contracted("im,im->m", forces, moved)) + np.abs(change * contracted("im,im->m", push, moved))
            # the plane leaves a single coordinate no step: the load factor alone, in which forces are linear, balances
            close = ~done & usable & (work <= _CLOSE * at.energy)
            stable = np.where(close, (factors.pivots > 0.0).all(axis=0), stable)
            done |= close
        iterations[~done | (self._norm(aside, aside) > (_ASIDE * self.step) ** 2)] = _MOST + 1
        return _Corrected(state, factor, iterations, stable)
