"""Continuation: from the reference configuration along a straight line of the drives, on one branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np

from ....framework.continuation import follow, sign_change
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from .interpolation import SIDES, at_zero, shares, weights

FIRST = 0.1
LONGEST = 0.35
SHORTEST = 1e-10
# The cubic through the last two nodes is used if the last step was at least this share of the next.
LONG = 0.49
# First step of Newton's method below which the step length may double.
EASY = 0.03
# A step longer than planned by this factor has passed a change point.
LONGER = 1.01
# Largest change of the derivatives by the drives from one step to the next, relative to their size.
TURN = 0.4
# Lengths of jumps that are tried over a change point in front of which steps have become too short.
JUMPS = (6e-2, 2e-2, 5e-3, 2e-3)
SHARPEST = 1e-4
# Ratio of a determinant at two points and at one spacing from a zero, above which the zero is multiple.
STEEP = 3.2
# Length of path beyond a change point that is needed to interpolate the pose in it.
BEYOND = 0.35
# A double zero may lie near a node whose determinant is below the first share of those of both neighbours. It does if
# the least singular value at the second distance from it is below the third share of that at the nodes.
DOUBLE_ZERO, BESIDE, TOUCHED = 0.3, 2e-3, 0.05
# Distance of the poses from which closure in a change point is judged, at most the given share of the step over it, and
# the gap that is allowed: lengths that agree to eight digits are meant to be equal.
KNOT, SHARE = 0.02, 0.4
OPEN = 1e-8
# Displacements along the free motion at which the other branch is sought, as shares of the length beyond a change
# point.
AWAY = (0.5, 1.0, 2.0, 4.0, 0.25, 0.1, 8.0)


@dataclass(frozen=True, eq=False)
class ContinuationPoint:
    """A closed pose at the length `s` of the path, and the derivative of its state by s."""

    s: float
    pose: Pose
    rate: list[float]


@dataclass(eq=False)
class RayPath:
    """Poses along a ray, as far as it has been followed.

    Attributes
    ----------
    nodes
        Poses in the order of s.
    step
        Length of the next step.
    crossings
        Lengths at which a change point was passed.
    sides
        Where the other branch was taken: for each crossing, the path to it and a little beyond it on the smooth branch.
    complete
        False if the path has ended, in a dead point or at the limit of reach.
    jumped
        Whether jumping over a change point has been tried from the last node.
    """

    nodes: list[ContinuationPoint]
    step: float
    crossings: list[float] = field(default_factory=list)
    sides: list[RayPath] = field(default_factory=list)
    complete: bool = True
    jumped: bool = False

    @property
    def end(self) -> float:
        """Length that was reached."""
        return self.nodes[-1].s


class PredictorCorrector:
    """Predictor-corrector steps along a ray, as long as Newton's method and the curvature of the path allow.

    The nodes depend on the ray alone, not on how far it is to be followed: a path that is followed further keeps its
    nodes.

    Parameters
    ----------
    loops
        Loops of the mechanism.
    parameters
        Its dimensions.
    start
        The closed pose at which the ray begins.
    direction
        Change of the driven states per unit of length: radians, and displacements in units of the mechanism's size.
    switch
        Whether the other branch is taken at change points.
    """

    def __init__(
        self, loops: Loops, parameters: Sequence[float], start: Pose, direction: Sequence[float], switch: bool = False
    ) -> None:
        self.loops, self.parameters, self.direction, self.switch = loops, parameters, direction, switch
        self.origin = [start.state[place] for place in loops.driven_states]

    def node(self, s: float, pose: Pose) -> ContinuationPoint:
        """The node at s, from its pose."""
        rate = self.loops.rate_along(pose.state, self.direction, pose.follow)
        return ContinuationPoint(s, pose, rate)  # type: ignore[arg-type]

    def place(self, state: Sequence[float], s: float) -> list[float]:
        """`state` with the driven entries at `s`, and Euler parameters of spherical joints scaled to unit length."""
        out = list(state)
        for place, value, slope in zip(self.loops.driven_states, self.origin, self.direction, strict=True):
            out[place] = value + s * slope
        return self.loops.unit(out) if self.loops.balls else out  # type: ignore[arg-type, return-value]

    def begin(self, start: Pose) -> RayPath:
        """The path at the beginning of the ray."""
        return RayPath([self.node(0.0, start)], FIRST)

    def extend(self, path: RayPath, until: float, switch: bool | None = None) -> RayPath:
        """Follow the ray at least as far as `until`, or to where the path ends."""
        other = self.switch if switch is None else switch

        def accept(found: ContinuationPoint, step: float) -> float | None:
            path.complete = self._accept(path, found, step, other)
            return path.step if path.complete and path.end < until else None

        if path.complete and path.end < until:
            path.complete = follow(partial(self._attempt, path), accept, path.step, SHORTEST) and path.complete
        return path

    def exactly(self, node: ContinuationPoint, s: float) -> list[float] | None:
        """The state at `s`, reached from a node in steps as short as needed; None if the path ends before."""
        path = RayPath([node], min(LONGEST, s - node.s))

        def attempt(step: float) -> ContinuationPoint | None:
            found = self._go(path, s if s - path.end <= step else path.end + step)
            return None if found is None or changes_sign(path.nodes[-1].pose, found.pose) else found

        def accept(found: ContinuationPoint, step: float) -> float | None:
            path.nodes.append(found)
            return step if path.end < s else None

        arrived = node.s >= s or follow(attempt, accept, path.step, SHORTEST)
        return path.nodes[-1].pose.state if arrived else None

    def _attempt(self, path: RayPath, step: float) -> ContinuationPoint | None:
        """The node one step ahead or, if steps have become short, beyond a change point; None if the step fails."""
        here = path.nodes[-1]
        found = self._go(path, self._across(path, here.s + step))
        if found is not None and not self._passes(here, found, step):
            found = None
        if found is None and 0.5 * step < SHARPEST and not path.jumped:
            path.jumped = True
            found = self._jump(path, step)
        return found

    def _accept(self, path: RayPath, found: ContinuationPoint, step: float, switch: bool) -> bool:
        """Append a node that was found by a step; False if the path ends there."""
        gone, easy = found.s - path.end, found.pose.first_step < EASY
        path.jumped, path.step = False, min(LONGEST, max(step, gone) * (2.0 if easy else 1.2))
        return self._append(path, found, gone > LONGER * step, switch)

    def _passes(self, here: ContinuationPoint, found: ContinuationPoint, step: float) -> bool:
        """Whether a step stays on its branch: a change of sign, or a long step, is allowed over a change point only."""
        if not changes_sign(here.pose, found.pose) and found.s - here.s <= LONGER * step:
            return True
        return self._closes(here, found, self._root(here, found))

    def _go(self, path: RayPath, target: float, jump: bool = False) -> ContinuationPoint | None:
        here = path.nodes[-1]
        guess = self.place(self.predict(path.nodes, target), target)
        pose = self.loops.close(guess, self.parameters)
        if pose is None:
            return None
        if not follows(here.pose, pose):
            return None
        if jump and not changes_sign(here.pose, pose):
            return None
        return self.node(target, pose)

    def predict(self, nodes: Sequence[ContinuationPoint], s: float) -> list[float]:
        """State at s, by the cubic through the last two nodes; by their rates where that would be unstable.

        Newton's method does not correct idle degrees of freedom, so the predictor must be stable by itself. That by the
        cubic is not: its parasitic root is -5, that of the rates 0 (Hairer, Nørsett and Wanner, Solving Ordinary
        Differential Equations I, III.3).
        """
        b = nodes[-1]
        h, change = s - b.s, 0.0
        if len(nodes) > 1 and (width := b.s - nodes[-2].s) >= LONG * h:
            if self.loops.determined:
                return _cubic(nodes[-2], b, 1.0 + h / width, width)
            change = 0.5 * h / width
        a = nodes[-2] if change else b
        return [x + h * (v + change * (v - u)) for x, v, u in zip(b.pose.state, b.rate, a.rate, strict=True)]

    def _across(self, path: RayPath, target: float) -> float:
        """The target; if a change point lies near it, the point as far beyond that as the last node is before it."""
        if len(path.nodes) < 2:
            return target
        a, b = path.nodes[-2:]
        for x, y in zip(a.pose.determinants, b.pose.determinants, strict=True):
            if abs(y) < abs(x) and x * y > 0.0:
                ahead = (b.s - a.s) * y / (x - y)
                if 0.4 * ahead < target - b.s < 1.6 * ahead:
                    return float(b.s + 2.0 * ahead)
        return target

    def _jump(self, path: RayPath, step: float) -> ContinuationPoint | None:
        for jump in JUMPS:
            found = self._go(path, path.end + jump, jump=True)
            if found is not None and self._passes(path.nodes[-1], found, step):
                return found
        return None

    def _append(self, path: RayPath, found: ContinuationPoint, far: bool, switch: bool) -> bool:
        """Append the node `found`, over a change point if one lies before it; False where the other branch is lost."""
        here = path.nodes[-1]
        if not far and not changes_sign(here.pose, found.pose):
            path.nodes.append(found)
            self._touch(path)
            return True
        where = self._root(here, found)
        path.crossings.append(where)
        if not switch:
            path.nodes.append(found)
            return True
        ahead = RayPath([*path.nodes, found], path.step)
        path.sides.append(self.extend(ahead, where + BEYOND, switch=False))
        t = (where - here.s) / (found.s - here.s)
        state = self.loops.unit(_cubic(here, found, t, found.s - here.s))  # type: ignore[arg-type]
        away = other_branch(self, here, found, where, state)  # type: ignore[arg-type]
        if away is None:
            return False
        through = [(y - x) / (found.s - here.s) for x, y in zip(here.pose.state, found.pose.state, strict=True)]
        onward = [(y - x) / (away.s - where) for x, y in zip(state, away.pose.state, strict=True)]
        for node, rate in ((here, through), (away, onward)):
            middle = Pose(state, node.pose.follow, node.pose.determinants, 0.0)  # type: ignore[arg-type]
            path.nodes.append(ContinuationPoint(where, middle, rate))  # type: ignore[arg-type]
        path.nodes.append(away)
        return True

    def _touch(self, path: RayPath) -> None:
        """Find a change point near the last node but one where no determinant changes its sign.

        An even number of loops passes a change point there at once, so that the zero has even multiplicity.
        """
        if len(path.nodes) < 3 or not has_double_zero([node.pose.determinants for node in path.nodes[-3:]]):
            return
        for a, b in pairwise(path.nodes[-3:]):
            where = self._multiple_root(a, b)
            low = max(self._least(self._between(a, b, where + sign * BESIDE)) for sign in (-1.0, 1.0))
            if a.s <= where <= b.s and low < TOUCHED * max(self._least(node.pose) for node in (a, b)):
                path.crossings.append(where)
                return

    def _root(self, a: ContinuationPoint, b: ContinuationPoint) -> float:
        """Length at which a determinant vanishes between two nodes: false position, then inverse interpolation."""
        pairs = list(zip(a.pose.determinants, b.pose.determinants, strict=True))
        changes = [i for i, (x, y) in enumerate(pairs) if x * y < 0.0]
        if not changes:
            return self._multiple_root(a, b)
        k = changes[0]

        def determinant(s: float) -> float:
            pose = self._between(a, b, s)
            return pose.determinants[k] if pose is not None else np.nan

        s = sign_change(determinant, (a.s, a.pose.determinants[k]), (b.s, b.pose.determinants[k]), rounds=4)
        width = min(max(s - a.s, b.s - s), 0.2)
        knots = (s + 0.24 * width * SIDES).tolist()
        values = [determinant(knot) for knot in knots]
        if min(abs(values[0] / values[2]), abs(values[7] / values[5])) > STEEP:
            return self._multiple_root(a, b)
        better = at_zero(knots, values)
        return better if abs(better - s) < width else s

    def _multiple_root(self, a: ContinuationPoint, b: ContinuationPoint) -> float:
        """Length at which several loops pass a change point at once, so that a determinant has a multiple zero.

        The least singular value of the equations falls linearly to zero there and rises again.
        """
        left, right = (self._least(node.pose) for node in (a, b))
        s, width = a.s + (b.s - a.s) * left / (left + right), 0.25 * (b.s - a.s)
        for _ in range(4):
            left, right = (self._least(self._between(a, b, s + sign * width)) for sign in (-1.0, 1.0))
            if not left + right > 0.0:
                return s
            s = min(max(s + width * (left - right) / (left + right), a.s), b.s)
            width = max(0.25 * width, 0.02)
        knots = (s + 0.02 * SIDES).tolist()
        better = at_zero(knots, [np.sign(knot - s) * self._least(self._between(a, b, knot)) for knot in knots])
        return better if abs(better - s) < width else s

    def _between(self, a: ContinuationPoint, b: ContinuationPoint, s: float) -> Pose | None:
        """The pose at s between or next to two nodes, with its determinants."""
        guess = _cubic(a, b, (s - a.s) / (b.s - a.s), b.s - a.s)
        pose = self.loops.close(self.place(guess, s), self.parameters)
        # `close` returns the determinants of the iterate before the last, hence the second call
        return pose and self.loops.close(pose.state, self.parameters)

    def _least(self, pose: Pose | None) -> float:
        """Least singular value of the equations at a pose, of those that do not vanish everywhere; NaN without one."""
        if pose is None:
            return np.nan
        m, n = self.loops.rows, self.loops.columns
        entries = self.loops.mechanism.newton[0](pose.state, self.parameters)[m:]
        values = np.linalg.svd(np.array(entries).reshape(m, n), compute_uv=False)
        return float(values[self.loops.linear.rank - 1])

    def _closes(self, a: ContinuationPoint, b: ContinuationPoint, where: float) -> bool:
        """Whether the smooth way through a change point closes in it: the polynomial through poses around it."""
        spacing = min(KNOT, SHARE * (b.s - a.s))
        knots = (where + spacing * SIDES).tolist()
        state = np.zeros(len(a.pose.state))
        for knot, weight in zip(knots, weights(knots, where), strict=True):
            guess = _cubic(a, b, (knot - a.s) / (b.s - a.s), b.s - a.s)
            pose = self.loops.close(self.place(guess, knot), self.parameters)
            if pose is None:
                return False
            state = state + weight * np.array(pose.state)
        middle = self.place(state.tolist(), where)
        residual = self.loops.mechanism.newton[0](middle, self.parameters)[: self.loops.rows]
        return bool(max(map(abs, residual)) < max(OPEN, self.loops.tolerance))


def other_branch(
    continuation: PredictorCorrector,
    here: ContinuationPoint,
    found: ContinuationPoint,
    where: float,
    state: Sequence[float],
) -> ContinuationPoint | None:
    """A pose on the branch that crosses that of two nodes at the length `where` and the state `state`; None if not
    found.

    Beyond a change point the branches differ along the free motion in it, the null vector of the equations. Newton's
    method starts from the known branch displaced along that motion, both ways and by several distances. It has found
    the other branch if the pose leads back to the change point, and if the determinants keep the signs that they had
    before it: on the smooth branch they change.
    """
    loops, n, m = continuation.loops, continuation.loops.columns, continuation.loops.rows
    entries = loops.mechanism.newton[0](state, continuation.parameters)[m:]
    free = np.linalg.svd(np.array(entries).reshape(m, n))[2][-1]
    beyond = max(found.s - where, 0.05)
    along = (beyond / (found.s - here.s)) * np.subtract(found.pose.state, here.pose.state)
    for share in AWAY:
        for sign in (1.0, -1.0):
            ahead = np.add(state, along).tolist()
            guess = loops.advance(ahead, (sign * share * beyond * free).tolist())
            s = where + beyond
            pose = loops.close(continuation.place(guess, s), continuation.parameters, far=0.5)  # type: ignore[arg-type]
            if pose is None or changes_sign(here.pose, pose):
                continue
            node = continuation.node(s, pose)
            back = [x - beyond * v for x, v in zip(pose.state, node.rate, strict=True)]
            if max(abs(x - y) for x, y in zip(back, state, strict=True)) < 0.3 * share * beyond + 0.1 * beyond:
                return node
    return None


def follows(one: Pose, other: Pose) -> bool:
    """Whether the derivatives by the drives of two successive poses are close."""
    bound = TURN * (0.5 + max(map(abs, one.follow), default=0.0))
    return all(abs(x - y) <= bound for x, y in zip(one.follow, other.follow, strict=True))


def changes_sign(one: Pose, other: Pose) -> bool:
    """Whether a determinant has opposite signs at two poses."""
    return any(x * y < 0.0 for x, y in zip(one.determinants, other.determinants, strict=True))


def has_double_zero(determinants: Sequence[Sequence[float]]) -> bool:
    """Whether a determinant is far smaller at the second of three poses than at the others, without change of sign."""
    return any(
        abs(y) <= DOUBLE_ZERO * max(abs(x), abs(z)) and abs(y) <= min(abs(x), abs(z)) and x * y >= 0.0 and y * z >= 0.0
        for x, y, z in zip(*determinants, strict=True)
    )


def _cubic(a: ContinuationPoint, b: ContinuationPoint, t: float, width: float) -> list[float]:
    """State at a.s + t * width on the cubic through two nodes with their rates."""
    p, q, r, u = shares(t, width)
    return [
        p * w + q * x + r * y + u * z for w, x, y, z in zip(a.pose.state, a.rate, b.pose.state, b.rate, strict=True)
    ]
