"""Continuation of many poses at once, each along its own straight line in the space of the drives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ....framework.continuation import PathBatch
from ..kinematics.blocks import taken
from ..kinematics.closed_poses import Poses
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .derivatives import Derivatives
from .interpolation import cubic
from .predictor_corrector import (
    BESIDE,
    BEYOND,
    DOUBLE_ZERO,
    EASY,
    FIRST,
    JUMPS,
    LONG,
    LONGEST,
    SHARPEST,
    SHORTEST,
    TURN,
)

Mask = NDArray[np.bool_]
# First step of a path that is followed to a given end: longer than `FIRST`, as the second derivative is known there.
FAR = 0.7
# Number of poses that are followed together, so that their arrays fit the cache.
TOGETHER = 2048
# Factor by which the rates have grown in a dead point, beside those after steps of the usual length.
GROWN, USUAL = 50.0, 1e-3
# A step that would end between these shares of the distance to where a determinant may vanish ends at the first.
WELL_BEFORE, AS_FAR_BEYOND = 0.4, 1.6


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
        Whether the path has met what may be a change point, (poses,).
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
        ends.left[part], ends.crossing[part] = paths.length - paths.s, paths.meets_crossing
    return ends


def lengths(change: Array) -> Array:
    """Lengths of changes (f, ...), summed term by term."""
    return np.asarray(np.sqrt(sum(x * x for x in change)))


@dataclass(frozen=True, eq=False)
class Read:
    """States read off long paths between their nodes.

    Attributes
    ----------
    states
        Interpolated states at the lengths asked for, that of its end where the path is not that long, (n, asked).
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
    # beyond the last length, as a change point may lie just beyond it
    np.maximum.at(need, path, s + BEYOND)
    asked = Asked(path, s, states[:, path].copy(), s <= 0.0)
    paths = ManyPaths(loops, parameters, states, direction, need=need, asked=asked)
    paths.run()
    short = ~asked.reached
    asked.states[:, short] = paths.state[:, path[short]]
    return Read(asked.states, asked.reached, paths.s, paths.meets_crossing)


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
        self.touched = np.zeros(count, dtype=bool)
        self.reached, self.crossing = self.need == 0.0, np.zeros(count, dtype=bool)
        self.jumped = np.zeros(count, dtype=bool)
        self._begin(common)
        self.usual = np.abs(self.rate).max(axis=0, initial=0.0)
        self.last_determinants = np.zeros_like(self.determinants)

    @property
    def meets_crossing(self) -> Mask:
        """Whether each path has met what may be a change point, (poses,).

        It has stalled where a determinant changes its sign beyond, or where the rates have stayed as they were, which
        grow without bound in a dead point; or it has passed a place where a determinant may have a double zero.
        """
        bounded = np.abs(self.rate).max(axis=0, initial=0.0) < GROWN * self.usual
        return np.asarray(self.stalled & (self.crossing | bounded) | self.touched)

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
        """Poses one step ahead, at most at the ends of the paths, and whether each step may be accepted.

        A step that would end near a change point ends well before it instead: beside one, Newton's method may find the
        other branch, on which no determinant changes its sign.
        """
        left = self.length[paths] - self.s[paths]
        step = np.minimum(self.step[paths], left)
        step = np.where(left < 1.01 * step, left, step)
        ahead = self._zero_ahead(paths)
        beside = (WELL_BEFORE * ahead < step) & (step < AS_FAR_BEYOND * ahead) & (WELL_BEFORE * ahead > SHARPEST)
        self.step[paths] = step = np.where(beside, WELL_BEFORE * ahead, step)
        found, near = self._go(paths, step)
        changes_sign = self._changes_sign(paths, found.determinants)
        good = near & ~changes_sign
        self.crossing[paths] = np.where(good, False, self.crossing[paths] | (near & changes_sign))
        return found, good

    def _zero_ahead(self, paths: NDArray[np.intp]) -> Array:
        """Distance to the nearest zero of a determinant, by a straight line through the last two nodes, (paths,)."""
        here, before = self.determinants[:, paths], self.last_determinants[:, paths]
        with np.errstate(all="ignore"):
            ahead = self.width[paths] * here / (before - here)
        falls = (np.abs(here) < np.abs(before)) & (here * before > 0.0)
        return np.asarray(np.where(falls, ahead, np.inf).min(axis=0, initial=np.inf))

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
        before, self.state[:, paths], self.width[paths] = self.width[paths], state, step
        determinants = points.determinants[:, good]
        x, y = np.abs(self.last_determinants[:, paths]), np.abs(self.determinants[:, paths])
        next_ones = np.abs(determinants)
        # beside an almost double zero the steps may become so short that neighbours are as small
        dips = (y <= DOUBLE_ZERO * np.maximum(x, next_ones)) | (np.minimum(before, step) < BESIDE)
        self.touched[paths] |= (dips & (y <= np.minimum(x, next_ones))).any(axis=0)
        self.last_determinants[:, paths] = self.determinants[:, paths]
        self.follow[:, paths], self.determinants[:, paths] = follow, determinants
        self.rate[:, paths] = self._rates(state, follow, self.direction[:, paths])
        self.bend[:, paths] = 0.0
        fast = np.where(step > USUAL, np.abs(self.rate[:, paths]).max(axis=0, initial=0.0), 0.0)
        self.usual[paths] = np.maximum(self.usual[paths], fast)
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
