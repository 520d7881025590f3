"""Continuation of many poses at once, each along its own straight line in the space of the drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.continuation import PathBatch
from ..kinematics.blocks import taken
from ..kinematics.closed_poses import Pose, Poses
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .interpolation import cubic
from .predictor_corrector import EASY, FIRST, JUMPS, LONG, LONGEST, SHARPEST, SHORTEST, TURN

Mask = NDArray[np.bool_]
# First step of a path that is followed to a given end: longer than `FIRST`, as the second derivative is known there.
FAR = 0.7
# Number of poses that are followed together, so that their arrays fit the cache.
TOGETHER = 2048


@dataclass(frozen=True, eq=False)
class Ends:
    """How far straight paths were followed.

    Attributes
    ----------
    states
        State at the end of each path, (n, poses).
    reached
        Whether the path has arrived at its target, (poses,).
    left
        Distance from its end to its target, (poses,).
    crossing
        Whether a determinant changes its sign where the path was stuck, as it does at a change point, (poses,).
    """

    states: Array
    reached: Mask
    left: Array
    crossing: Mask


def followed(
    loops: Loops, parameters: Sequence[Value], states: Array, change: Array, common: Derivatives | None = None
) -> Ends:
    """Follow each pose from its state (n, poses) while the driven states change by `change`, (f, poses).

    Each of the `parameters` is one number, or one for each pose; `common` holds the derivatives at the start if all
    poses start from the same one.
    """
    count = states.shape[1]
    ends = Ends(states.copy(), np.zeros(count, dtype=bool), np.zeros(count), np.zeros(count, dtype=bool))
    for begin in range(0, count, TOGETHER):
        part = np.arange(begin, min(begin + TOGETHER, count))
        own = taken(parameters, part)
        paths = ManyPaths(loops, own, states[:, part], change[:, part], common=common)
        paths.run()
        ends.states[:, part], ends.reached[part] = paths.state, paths.reached
        ends.left[part], ends.crossing[part] = paths.length - paths.s, paths.crossing & paths.stalled
    return ends


def lengths(change: Array) -> Array:
    """Lengths of changes (f, ...), summed term by term."""
    return np.asarray(np.sqrt(sum(x * x for x in change)))


@dataclass(frozen=True, eq=False)
class Derivatives:
    """Derivatives of a pose by the drives.

    Attributes
    ----------
    follow, determinants
        As in `Pose`.
    rate, bend
        First and second derivatives of the state by the driven states, (n, f) and (n, f, f).
    pairs
        Places of those that something in the state follows together, the second at most the first.
    """

    follow: Array
    determinants: Array
    rate: Array
    bend: Array
    pairs: list[tuple[int, int]]

    def along(self, change: Array) -> tuple[Array, Array]:
        """First and second derivatives of the state (n, poses) along changes of the driven states (f, poses).

        Summed term by term, so that the result of a pose has the same bits for any number of poses; a matrix product
        sums in another order at the edges of its blocks.
        """
        first, second = (np.zeros((len(self.rate), change.shape[1])) for _ in range(2))
        part = np.empty_like(first)
        for factor, x in zip(self.rate.T, change, strict=True):
            first += np.multiply(factor[:, None], x, out=part)
        for (i, j), factor in zip(self.pairs, self._second, strict=True):
            if factor.any():
                second += np.multiply(factor[:, None], change[i] * change[j], out=part)
        return first, second

    def along_one(self, change: Array) -> tuple[Array, Array]:
        """`along` for one change (f,), by the same sums."""
        i, j = np.array(self.pairs).T
        first = np.add.accumulate(self.rate.T * change[:, None])[-1]
        second = np.add.accumulate(self._second * (change[i] * change[j])[:, None])[-1]
        return first, second

    @cached_property
    def _second(self) -> Array:
        """What each of the `pairs` adds to the second derivative of the state, (pairs, n)."""
        i, j = np.array(self.pairs, dtype=np.intp).reshape(-1, 2).T
        factors: Array = np.where(i == j, 1.0, 2.0)[:, None] * self.bend[:, i, j].T
        return factors

    @classmethod
    def of(cls, loops: Loops, parameters: Sequence[float], pose: Pose) -> Derivatives:
        """Derivatives at a pose; spherical joints must not be driven."""
        f, state, pairs = len(loops.driven_states), [np.array(x) for x in pose.state], loops.equations.driven_together
        i, j = np.array(pairs, dtype=np.intp).reshape(-1, 2).T
        # By polarisation: 2 B(u, v) = B(u + v, u + v) - B(u, u) - B(v, v).
        combinations = np.concatenate([np.eye(f), np.eye(f)[:, i] + np.eye(f)[:, j]], axis=1)
        spread: list[Value] = [np.broadcast_to(x, combinations.shape[1:]) for x in state]
        velocities = loops.velocities(spread, parameters, list(combinations))
        changes = loops.accelerations(spread, parameters, velocities, None)
        rate, bend = (
            np.stack([np.broadcast_to(x, combinations.shape[1:]) for x in each])
            for each in (
                loops.state_rate(spread, [velocities[k] for k in loops.mechanism.unknown]),
                loops.state_bend(spread, velocities, changes),
            )
        )
        rate[loops.driven_states] = combinations
        mixed = np.zeros((len(bend), f, f))
        mixed[:, i, j] = mixed[:, j, i] = 0.5 * (bend[:, f:] - bend[:, i] - bend[:, j])
        determinants = np.array(pose.determinants, dtype=np.float64)
        mixed = np.nan_to_num(mixed, copy=False, posinf=0.0, neginf=0.0)
        return cls(np.array(pose.follow), determinants, rate[:, :f], mixed, pairs)


@dataclass(frozen=True, eq=False)
class Read:
    """States read off long paths between their nodes.

    Attributes
    ----------
    states
        Interpolated states at the lengths asked for, (n, asked).
    reached
        Whether the path is that long, (asked,).
    end
        Length that each path has reached, (paths,).
    crossing
        As `Ends.crossing`, (paths,).
    """

    states: Array
    reached: Mask
    end: Array
    crossing: Mask


def read_off(
    loops: Loops, parameters: Sequence[Value], states: Array, direction: Array, path: NDArray[np.intp], s: Array
) -> Read:
    """Follow long paths from `states` (n, paths) in `direction` (f, paths), and interpolate at the lengths s (asked,).

    `path` (asked,) is the index of the path of each length. The nodes of a path are those of `PredictorCorrector` and
    do not depend on the lengths asked for.
    """
    count = states.shape[1]
    need = np.zeros(count)
    np.maximum.at(need, path, s)
    asked = Asked(path, s, states[:, path].copy(), s <= 0.0)
    paths = ManyPaths(loops, parameters, states, direction, need=need, asked=asked)
    paths.run()
    return Read(asked.states, asked.reached, paths.s, paths.crossing & paths.stalled)


@dataclass(eq=False)
class Asked:
    """Points to interpolate on paths: path and length of each, (asked,); states (n, asked), and which are found."""

    path: NDArray[np.intp]
    s: Array
    states: Array
    reached: Mask


@dataclass(frozen=True, eq=False)
class PosesAhead:
    """Poses one step ahead on some paths, with their derivatives by the drives and determinants, (entries, paths)."""

    found: Poses
    follow: Array
    determinants: Array


class ManyPaths(PathBatch[PosesAhead]):
    """Straight paths that are followed side by side, each with its own step length.

    The steps of a path are those that it would take alone. A step is accepted if Newton's method converges fast, no
    determinant changes its sign, and the derivatives by the drives change little from one step to the next.

    Parameters
    ----------
    loops
        The loops.
    parameters
        Dimensions, the same for all or one for each path.
    state
        Closed states from which the paths lead, (n, poses).
    change
        Change of the driven states along each, (f, poses).
    need
        Length to which each path is followed without ending there, (poses,); None if it ends where `change` says.
    asked
        Points to interpolate on the paths.
    common
        Derivatives at the start if all paths start from the same pose.
    """

    def __init__(
        self,
        loops: Loops,
        parameters: Sequence[Value],
        state: Array,
        change: Array,
        need: Array | None = None,
        asked: Asked | None = None,
        common: Derivatives | None = None,
    ) -> None:
        self.loops, self.parameters, self.asked = loops, parameters, asked
        self.length = lengths(change)
        self.direction = change / np.where(self.length > 0.0, self.length, 1.0)
        self.origin = state[loops.driven_states]
        count = state.shape[1]
        if need is not None:
            self.length = np.full(count, np.inf)
        self.need = self.length if need is None else need
        self.state, self.s = state.copy(), np.zeros(count)
        super().__init__(np.minimum(FAR if need is None else FIRST, self.length), SHORTEST)
        self.width = np.zeros(count)
        self.reached, self.crossing = self.need == 0.0, np.zeros(count, dtype=bool)
        self.jumped = np.zeros(count, dtype=bool)
        self._begin(common)

    def wanted(self) -> NDArray[np.intp]:
        """Indices of the paths that have neither reached their ends nor stalled."""
        return np.flatnonzero(~(self.reached | self.stalled))

    def _begin(self, common: Derivatives | None) -> None:
        """Rates and second derivatives at the beginning."""
        loops, state, own = self.loops, list(self.state), self.parameters
        self.before, self.before_rate = self.state.copy(), np.zeros_like(self.state)
        if common is not None:
            count = self.state.shape[1]
            self.follow = np.repeat(common.follow[:, None], count, axis=1)
            self.determinants = np.repeat(common.determinants[:, None], count, axis=1)
            self.rate, self.bend = common.along(self.direction)
            return
        self.follow, self.determinants = self._told(loops.poses(list(state), own))
        self.rate = self._rates(self.state, self.follow, self.direction)
        self.bend = np.zeros_like(self.state)
        if self.asked is None and not loops.driven_spherical:
            velocities = loops.velocities(state, own, list(self.direction))
            changes = loops.accelerations(state, own, velocities, None)
            self.bend = self._spread(loops.state_bend(state, velocities, changes))
            self.bend[~np.isfinite(self.bend)] = 0.0

    def attempt(self, paths: NDArray[np.intp]) -> tuple[PosesAhead, Mask]:
        """Poses one step ahead, at most at the ends of the paths, and whether each step may be accepted."""
        left = self.length[paths] - self.s[paths]
        step = np.minimum(self.step[paths], left)
        self.step[paths] = step = np.where(left < 1.01 * step, left, step)
        found, near = self._go(paths, step)
        changes_sign = self._changes_sign(paths, found.determinants)
        good = near & ~changes_sign
        self.crossing[paths] = np.where(good, False, self.crossing[paths] | (near & changes_sign))
        return found, good

    def shortened(self, paths: NDArray[np.intp]) -> None:
        """Where steps have become short, try once to step over what may be a change point."""
        sharp = paths[(self.step[paths] < SHARPEST) & ~self.jumped[paths]]
        if sharp.size:
            self._jump(sharp)

    def _go(self, paths: NDArray[np.intp], step: Array) -> tuple[PosesAhead, Mask]:
        """Poses one step ahead, and whether each is closed and near the one before."""
        found = self.loops.poses(self._predicted(paths, step), self._own(paths))
        follow, determinants = self._told(found)
        old = self.follow[:, paths]
        bound = TURN * (0.5 + np.abs(old).max(axis=0, initial=0.0))
        with np.errstate(invalid="ignore"):
            near = found.good & np.all(np.abs(follow - old) <= bound, axis=0)
        return PosesAhead(found, follow, determinants), near

    def accept(self, paths: NDArray[np.intp], points: PosesAhead, good: Mask) -> None:
        """Make the good ones of some poses the new ends of their paths."""
        found, follow, step = points.found, points.follow[:, good], self.step[paths]
        self.before[:, paths], self.before_rate[:, paths] = self.state[:, paths], self.rate[:, paths]
        state = np.stack([np.broadcast_to(x, good.shape)[good] for x in found.state])
        self.state[:, paths], self.width[paths] = state, step
        self.follow[:, paths], self.determinants[:, paths] = follow, points.determinants[:, good]
        self.rate[:, paths] = self._rates(state, follow, self.direction[:, paths])
        self.bend[:, paths] = 0.0
        ends = self.s[paths] + step
        self.reached[paths] = ends >= self.need[paths] * (1.0 if self.asked else 1.0 - 1e-14)
        if self.asked is not None:
            self._read_off(self.asked, paths, step)
        self.s[paths] = ends
        self.step[paths] = np.minimum(LONGEST, step * np.where(found.first_step[good] < EASY, 2.0, 1.2))
        self.jumped[paths] = False

    def _read_off(self, asked: Asked, paths: NDArray[np.intp], step: Array) -> None:
        """Interpolate the points asked for within the last step of some paths."""
        width = np.zeros(self.s.shape)
        width[paths] = step
        beyond = asked.s - self.s[asked.path]
        # Summed like the lengths of the paths, so that a point on a node is not lost by rounding.
        ends = self.s + width
        chosen = np.flatnonzero((beyond > 0.0) & (asked.s <= ends[asked.path]))
        k, h = asked.path[chosen], width[asked.path[chosen]]
        nodes = self.before[:, k], self.before_rate[:, k], self.state[:, k], self.rate[:, k]
        asked.states[:, chosen] = cubic(*nodes, beyond[chosen] / h, h)
        asked.reached[chosen] = True

    def _jump(self, paths: NDArray[np.intp]) -> None:
        """Mark paths that are stuck before a change point."""
        self.jumped[paths] = True
        for jump in JUMPS:
            found, near = self._go(paths, np.full(paths.shape, jump))
            self.crossing[paths] |= near & self._changes_sign(paths, found.determinants)

    def _predicted(self, active: NDArray[np.intp], step: Array) -> list[Value]:
        """Predicted states one step ahead: by the second derivative at first, then as `PredictorCorrector.predict`."""
        state, rate, before = self.state[:, active], self.rate[:, active], self.before[:, active]
        width, old = self.width[active], self.before_rate[:, active]
        safe = np.where(width > 0.0, width, 1.0)
        long = (width >= LONG * step) & (width > 0.0)
        if self.loops.determined:
            guess = state + step * (rate + 0.5 * step * self.bend[:, active])
            guess = np.where(long, cubic(before, old, state, rate, 1.0 + step / safe, safe), guess)
        else:
            change = np.where(long, 0.5 * step / safe, 0.0)
            guess = state + step * (rate + change * (rate - old) + 0.5 * step * self.bend[:, active])
        guess[self.loops.driven_states] = self.origin[:, active] + (self.s[active] + step) * self.direction[:, active]
        return self.loops.unit(list(guess))

    def _own(self, active: NDArray[np.intp]) -> list[Value]:
        return taken(self.parameters, active)

    def _changes_sign(self, paths: NDArray[np.intp], determinants: Array) -> Mask:
        return np.asarray(np.any(determinants * self.determinants[:, paths] < 0.0, axis=0))

    def _rates(self, state: Array, follow: Array, direction: Array) -> Array:
        """Derivatives of the states by the length of the path, (n, poses)."""
        return self._spread(self.loops.rate_along(list(state), list(direction), list(follow)), state.shape[1])

    def _told(self, found: Poses) -> tuple[Array, Array]:
        count = found.good.shape[0] if found.good.shape else self.state.shape[1]
        return self._spread(found.follow, count), self._spread(found.determinants, count)

    def _spread(self, entries: Sequence[Value], count: int | None = None) -> Array:
        """Entries, which may broadcast, as the rows of one array, (entries, poses)."""
        poses = self.state.shape[1] if count is None else count
        out = np.empty((len(entries), poses))
        for row, x in zip(out, entries, strict=True):
            row[:] = x
        return out
