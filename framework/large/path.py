"""Equilibrium paths past limit points, by arc length.

A step along the tangent, then Newton's method in the plane across it, its length following the number of iterations.
Where the frame is kinematically unstable at rest, as within clearances, there is no tangent there: the path goes on
from the equilibrium under the first share of the load.
"""

from __future__ import annotations

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import prod

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..batched.idle import released_at_rest
from ..batched.plan import Plan
from ..checked import whole_number
from ..continuation import Index, PathBatch
from ..described.released_ends import with_hinges
from ..description import Description, excluding
from ..dofs import component
from ..errors import FrameError, PathWarning
from ..names import found
from .arc_length import MOST, ArcLength, ArcPoint, Corrected
from .clearances import start
from .limit_points import Track
from .model import Model
from .newton import Newton
from .numbers import Where
from .search import Search
from .state import Mask, StateOfEntries

# Iterations that a step is to take, and how much its length may grow.
_AIM, _GROWTH = 5, 1.5
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
    _number: Mapping[str, int] = field(repr=False)
    _tracks: list[Track] = field(repr=False)

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
        out = np.full((len(self.factor), prod(self.shape), 6), np.nan)
        for track in self._tracks:
            for point, state in enumerate(track.states):
                out[point, track.index] = track.newton.space(state).moved(self._number[name]).T[track.index]
        return np.where(np.isnan(self.factor)[..., None], np.nan, out.reshape(*self.factor.shape, 6))

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.frame.shape

    @cached_property
    def limits(self) -> list[Array]:
        """Load factors of the limit points between the first and the last point, (k,) for each batch entry, flattened.

        Each is found between the points beside it, by points of equilibrium of its own, so that it does not depend on
        the steps of the path. NaN where that fails.

        Warns
        -----
        PathWarning
            Where a limit point was not found.
        """
        parts = [track.limits() for track in self._tracks]
        entry, factor = (np.concatenate([getattr(part, name) for part in parts]) for name in ("entry", "factor"))
        lost = np.flatnonzero(np.isnan(factor))
        if len(lost):
            between = np.concatenate([part.between for part in parts], axis=-1)[:, lost[0]]
            warnings.warn(self._unfound(int(entry[lost[0]]), between, len(lost)), PathWarning, stacklevel=3)
        return [factor[entry == k] for k in range(prod(self.shape))]

    def _unfound(self, entry: int, between: Array, count: int) -> str:
        """Which limit points were not found."""
        place = tuple(int(k) for k in np.unravel_index(entry, self.shape)) if self.shape else ()
        which = f" (entry {place})" if self.shape else ""
        return (
            f"the limit point of the path between load factors {between[0]:.6g} and {between[1]:.6g}{which} was not "
            f"found and is NaN in limits ({count} such): follow the path in shorter steps, with a smaller first"
        )


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
        path = _together(model.frame, masks, [_traced(each, goal, steps, first) for each in models])
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
    shape = len(tracer.stables), *model.frame.shape
    factor, stable = np.stack(tracer.track.factors).reshape(shape), np.stack(tracer.stables).reshape(shape)
    return EquilibriumPath(model.frame, factor, stable, tracer.reached, model.topology.number, [tracer.track])


def _together(frame: Description, masks: list[Mask], paths: list[EquilibriumPath]) -> EquilibriumPath:
    """Paths of a batch from those of its parts, the entries of which have kept to planes of their own."""
    shape, points = frame.shape, max(len(path.factor) for path in paths)
    factor, stable = np.full((points, *shape), np.nan), np.zeros((points, *shape), dtype=bool)
    reached, tracks = np.zeros(shape, dtype=bool), []
    for mask, path in zip(masks, paths, strict=True):
        factor[: len(path.factor), mask], stable[: len(path.stable), mask] = path.factor[:, mask], path.stable[:, mask]
        reached[mask] = path.reached[mask]
        tracks += [replace(track, index=np.flatnonzero(mask)) for track in path._tracks]
    return EquilibriumPath(frame, factor, stable, reached, paths[0]._number, tracks)


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


class _Tracer(PathBatch[Corrected]):
    """Paths of all entries, a point at a time."""

    def __init__(self, model: Model, goal: tuple[str, int, float], first: float) -> None:
        self.model, self.newton = model, Newton(model)
        node, self.component, self.to = goal
        self.node = model.topology.number[node]
        count = len(model.present)
        where = model.where(np.arange(count))
        self.arc = ArcLength(self.newton, where, count)
        self.state = self.newton.start(count)
        self.going = model.present.copy()
        self.reached = np.zeros(model.frame.shape, dtype=bool)
        self.factor = np.zeros(count)
        super().__init__(np.full(count, np.nan), 0.0)
        self.pending, self.stable = np.zeros(count, dtype=bool), np.zeros(count, dtype=bool)
        self.length = np.zeros(count)
        self.track = Track(
            self.newton, np.arange(count), [self._here()], [np.where(self.going, 0.0, np.nan)], [], [], []
        )
        self.stables = [self.going.copy()]
        if self._unstable_at_rest():
            self._begin(where, first)
        self.along, self.slope = self.arc.tangent(self.state, self.factor)
        self.step = first / self.slope
        self.shortest = _LEAST * self.step

    def point(self) -> bool:
        """One more point of each path that has not ended; whether there is any."""
        self.going &= np.isfinite(self.slope)
        self.pending = self.going.copy()
        self.run()
        self.going &= ~self.stalled
        if not self.going.any():
            return False
        self._add(self.stable)
        self._turn()
        return bool(self.going.any())

    def wanted(self) -> Index:
        """Entries whose next point is still to be found."""
        return np.flatnonzero(self.pending & ~self.stalled)

    def attempt(self, paths: Index) -> tuple[Corrected, Mask]:
        """Points of equilibrium a step further, and which of these were found."""
        begin = ArcPoint(self.state, self.factor, self.along, self.slope)
        found = self.arc.corrected(begin, self.step, paths)
        return found, found.iterations[paths] <= MOST

    def accept(self, paths: Index, points: Corrected, good: Mask) -> None:
        """Go on to the points that were found."""
        self.state.put(paths, points.state.taken(paths))
        self.factor[paths], self.stable[paths] = points.factor[paths], points.stable[paths]
        self.length[paths] = self.step[paths]
        grown = np.clip(np.sqrt(_AIM / np.maximum(points.iterations[paths], 1)), 0.5, _GROWTH)
        self.step[paths] *= grown
        self.pending[paths] = False

    def _unstable_at_rest(self) -> bool:
        """Whether some entry is kinematically unstable at rest."""
        at, _ = self.arc.linear(self.state, None, self.factor)
        return not bool((self.newton.factor(at).pivots[:, self.going] > self.newton.elimination.zero).all())

    def _begin(self, where: Where, first: float) -> None:
        """Go to the equilibrium under the first share of the load at once."""
        begin = start(self.newton, where, len(self.factor), first)
        there = Search(self.newton).solve(where, begin, 0.0, first)
        self.going &= there.converged
        self.state, self.factor = there.state, np.where(self.going, first, 0.0)
        self._add(there.stable)
        for part in (self.track.slopes, self.track.lengths, self.track.ends):
            part.append(np.full(len(self.factor), np.nan))

    def _turn(self) -> None:
        """Turn into the directions in which the paths go on, and note how the load factor changed on the steps."""
        ahead, slope = self.arc.tangent(self.state, self.factor)
        turn = self.arc.inner(ahead, self.along)
        self.track.slopes.append(self.slope)
        self.track.lengths.append(self.length.copy())
        self.track.ends.append(slope / np.where(turn != 0.0, turn, np.nan))
        sign = np.where(turn < 0.0, -1.0, 1.0)
        self.along, self.slope = sign * ahead, sign * slope

    def _add(self, stable: Mask) -> None:
        """One more point where the entries are now; those that have come far enough end there."""
        self.track.factors.append(np.where(self.going, self.factor, np.nan))
        self.track.states.append(self._here())
        self.stables.append(stable & self.going)
        here = self.newton.space(self.state).moved(self.node)[self.component]
        beyond = here >= self.to if self.to > 0.0 else here <= self.to
        self.reached |= (self.going & beyond).reshape(self.reached.shape)
        self.going &= ~beyond

    def _here(self) -> StateOfEntries:
        return self.state.taken(np.arange(len(self.factor)))
