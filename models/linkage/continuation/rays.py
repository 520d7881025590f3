"""Several moving drives: each pose at the end of a straight path of its own from the reference configuration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import taken
from ..kinematics.closed_poses import Pose
from ..kinematics.loop_coordinates import LAST_STEP
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .derivatives import Derivatives
from .ends import at_dead_points
from .follow import Guide
from .guess import NEAR
from .many_paths import FAR, TOGETHER, followed, lengths
from .predictor_corrector import LONGEST, TURN, PredictorCorrector, RayPath, changes_sign, follows

Mask = NDArray[np.bool_]
# How far aside a change point is passed to see whether that leads to the same pose, and how nearly the same.
ASIDE = 0.02
SAME = 1e-6


def from_one(loops: Loops, parameters: Sequence[float], start: Pose, targets: Array) -> tuple[Array, Mask, Mask]:
    """As `along_rays`, of poses that all begin in the same one; and which of them are closed to rounding."""
    if loops.driven_spherical:
        states = np.tile(np.array(start.state)[:, None], targets.shape[1])
        return *along_rays(loops, parameters, states, targets), np.zeros(targets.shape[1], dtype=bool)
    common = begins(loops, parameters, start)
    states, reached, closed = _in_one_step(loops, parameters, start, common, targets)
    if not reached.all():
        left = ~reached
        begin = np.tile(np.array(start.state)[:, None], int(left.sum()))
        states[:, left], reached[left] = along_rays(loops, parameters, begin, targets[:, left], common)
    return states, reached, closed


def _in_one_step(
    loops: Loops, parameters: Sequence[float], start: Pose, common: Derivatives, targets: Array
) -> tuple[Array, Mask, Mask]:
    """States (n, poses) at driven states (f, poses), and which of them one step leads to: as `at_once`, for many.

    Last, which of these are closed to rounding.
    """
    begin, count = np.array(start.state), targets.shape[1]
    states, reached = np.empty((len(begin), count)), np.zeros(count, dtype=bool)
    follow, determinants = common.follow[:, None], common.determinants[:, None]
    bound = TURN * (0.5 + float(np.abs(follow).max(initial=0.0)))
    guess, near, closed = states, np.empty(count, dtype=bool), np.zeros(count, dtype=bool)
    for first in range(0, count, TOGETHER):
        part = slice(first, first + TOGETHER)
        change = targets[:, part] - begin[loops.driven_states, None]
        rate, bend = common.along(change)
        guess[:, part] = begin[:, None] + rate + 0.5 * bend
        near[part] = lengths(change) <= FAR
    guess[loops.driven_states] = targets
    together = count if loops.at_once((count,), followed=True) else TOGETHER
    for first in range(0, count, together):
        part = slice(first, first + together)
        found = loops.poses(loops.unit(list(guess[:, part])), parameters)
        good = found.good & near[part]
        for now, then in zip(found.follow, follow, strict=True):
            good &= np.abs(now - then) <= bound
        for now, then in zip(found.determinants, determinants, strict=True):
            good &= now * then >= 0.0
        reached[part], closed[part] = good, good & (found.last_step <= LAST_STEP)
        for row, x in zip(states, found.state, strict=True):
            row[part] = x
    return states, reached, closed


def begins(loops: Loops, parameters: Sequence[float], start: Pose) -> Derivatives:
    """How all paths begin at the reference configuration; kept with the loops."""
    if loops.derivatives is None or loops.derivatives[0] is not start:
        loops.derivatives = start, Derivatives.of(loops, parameters, start)
    derivatives: Derivatives = loops.derivatives[1]
    return derivatives


def at_once(loops: Loops, parameters: Sequence[float], start: Pose, common: Derivatives, target: Array) -> Pose | None:
    """The pose at driven states (f,) where one step leads to it, as the first step of `ManyPaths`; else None."""
    begin = np.array(start.state)
    change = target - begin[loops.driven_states]
    if not lengths(change) <= FAR:
        return None
    rate, bend = common.along_one(change)
    guess = begin + rate + 0.5 * bend
    guess[loops.driven_states] = target
    pose = loops.close(loops.unit(guess.tolist()), parameters)  # type: ignore[arg-type]
    if pose is None or changes_sign(start, pose) or not follows(start, pose):
        return None
    return pose


def along_rays(
    loops: Loops, parameters: Sequence[Value], states: Array, targets: Array, common: Derivatives | None = None
) -> tuple[Array, Mask]:
    """States (n, poses) to which straight paths lead from `states` to the driven states (f, poses), and where they do.

    A change point is passed where that is the only way on: where paths that pass it on either side lead to the same
    pose. At a pose in a dead point, to which a path leads but beyond which none would, the branches meet.

    `parameters` are the same for all, or one for each pose.
    """
    change = targets - states[loops.driven_states]
    if loops.driven_spherical:
        change = _nearer_spherical(loops, states, targets)
    ends = followed(loops, parameters, states, change, common)
    out, reached = ends.states, ends.reached
    for k in np.flatnonzero(ends.crossing):
        own = [float(x) for x in taken(parameters, np.array(k))]
        start = loops.close(states[:, k].tolist(), own)
        found = start and passed(loops, own, start, change[:, k])
        if found:
            out[:, k], reached[k] = found, True
    at_dead_points(loops, parameters, out, reached, ends.left, targets)
    return out, reached


def _nearer_spherical(loops: Loops, states: Array, targets: Array) -> Array:
    """By how much the driven states change, with the Euler parameters of balls of the sign nearest to the start."""
    aims, begin = targets.copy(), states[loops.driven_states]
    for place in loops.driven_spherical:
        rows = slice(k := loops.driven_states.index(place), k + 4)
        aims[rows] *= np.where((aims[rows] * begin[rows]).sum(axis=0) < 0.0, -1.0, 1.0)
    return np.asarray(aims - begin)


def passed(loops: Loops, parameters: Sequence[float], start: Pose, change: Array) -> list[float] | None:
    """The state at the end of a path through change points; None where it ends before, or goes on in several ways."""
    length = float(np.linalg.norm(change))
    continuation = _continue(loops, parameters, start, change / length)
    path = continuation.extend(continuation.begin(start), length)
    for where in path.crossings:
        if where < length and not _alone(continuation, path, where):
            return None
    return _end(continuation, path, length)


def _continue(loops: Loops, parameters: Sequence[float], start: Pose, direction: Array) -> PredictorCorrector:
    return PredictorCorrector(loops, parameters, start, direction.tolist())


def _end(continuation: PredictorCorrector, path: RayPath, s: float) -> list[float] | None:
    """The state at `s` on a path that leads so far."""
    if path.end < s:
        return None
    guide, loops = Guide.of(path), continuation.loops
    guess, signs = guide.at(np.array(s)), guide.signs_at(np.array(s), NEAR)
    pose = loops.close(continuation.place(guess.tolist(), s), continuation.parameters)
    if pose is not None and np.all(np.multiply(pose.determinants, signs) >= 0.0):
        return pose.state
    return continuation.exactly([node for node in path.nodes if node.s <= s][-1], s)


def _alone(continuation: PredictorCorrector, path: RayPath, where: float) -> bool:
    """Whether paths that pass a change point on either side lead to the pose beyond it to which the path leads."""
    before = [node for node in path.nodes if node.s < where][-1]
    after = next(node for node in path.nodes if node.s > where)
    direction = np.array(continuation.direction)
    across = np.linalg.svd(direction[None])[2][1:]
    middle = 0.35 * (before.s - where) if where - before.s > after.s - where else 0.35 * (after.s - where)
    for aside in (*across, *-across):
        pose: Pose | None = before.pose
        corner = (where + middle - before.s) * direction + min(ASIDE, 0.5 * LONGEST) * aside
        for change in (corner, (after.s - before.s) * direction - corner):
            pose = pose and _straight(continuation, pose, change)
        if pose is None or np.abs(np.subtract(pose.state, after.pose.state)).max() > SAME:
            return False
    return True


def _straight(continuation: PredictorCorrector, start: Pose, change: Array) -> Pose | None:
    """The pose at the end of a straight path; None where it ends before."""
    length = float(np.linalg.norm(change))
    aside = _continue(continuation.loops, continuation.parameters, start, change / length)
    state = _end(aside, aside.extend(aside.begin(start), length), length)
    return continuation.loops.close(state, continuation.parameters) if state else None
