"""Continuation: from the drawing along the way of the drives, on one branch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ....framework.batch import Array
from ..kinematics.loops import Loops, Pose
from .path import Path

LONGEST = 0.35
SHORTEST = 1e-10
# How much a pose may change the way it follows the drives from one step to the next.
TURN = 0.4
# Where the way is stuck before a change point, how far to jump over it.
JUMPS = (6e-2, 2e-2, 5e-3, 2e-3)
SHARPEST = 1e-4
# How far beyond a change point it must be seen to be interpolated.
BEYOND = 0.35
# Distance of the poses from which its closure is judged, and how far it may be open.
KNOT = 0.02
OPEN = 1e-8
# Where another branch is looked for, as shares of the way gone beyond a change point.
AWAY = (0.5, 1.0, 2.0, 4.0, 0.25, 0.1, 8.0)


@dataclass(frozen=True, eq=False)
class Node:
    """A closed pose at the length `s` of the way, and the rate of its state by s."""

    s: float
    pose: Pose
    rate: list[float]


@dataclass(eq=False)
class Track:
    """Poses along the way.

    Attributes
    ----------
    nodes
        Poses in the order of s.
    crossings
        Lengths at which a change point was passed.
    sides
        Where the other branch was taken: for each crossing, the way so far and a little on along its own branch.
    doubts
        Crossings where the branches only come close to each other, so that the way has left its own for the smoother.
    complete
        False where the way ended before its length: in a dead point, or out of reach.
    """

    nodes: list[Node]
    crossings: list[float] = field(default_factory=list)
    sides: list[Track] = field(default_factory=list)
    doubts: list[float] = field(default_factory=list)
    complete: bool = True

    @property
    def end(self) -> float:
        """Length that was reached."""
        return self.nodes[-1].s

    @property
    def s(self) -> Array:
        """Lengths of the nodes."""
        return np.array([node.s for node in self.nodes])


class March:
    """Steps along a way, as long as Newton's method and the way's curvature allow.

    Parameters
    ----------
    loops
        Loops of the mechanism.
    parameters
        Its dimensions.
    path
        Way of the drives.
    longest
        Longest step.
    """

    def __init__(self, loops: Loops, parameters: Sequence[float], path: Path, longest: float = LONGEST) -> None:
        self.loops, self.parameters, self.path, self.longest = loops, parameters, path, longest

    def node(self, s: float, pose: Pose) -> Node:
        """A node of the pose at s."""
        slopes, drives = self.path.rates(pose.state, s)
        n = self.loops.columns
        unknown = [sum(d * x for d, x in zip(drives, pose.follow[k::n], strict=True)) for k in range(n)]
        rate = self.loops.state_rate(pose.state, unknown)
        for place, slope in zip(self.loops.driven_states, slopes, strict=False):
            rate[place] = slope
        return Node(s, pose, rate)

    def run(self, start: Pose, switch: bool = False) -> Track:
        """Go the whole way from the pose at its beginning."""
        return self._on(Track([self.node(0.0, start)]), switch, self.path.length)

    def _on(self, track: Track, switch: bool, until: float) -> Track:
        step = min(0.1, self.longest)
        jumped = False
        while track.end < until:
            here = track.nodes[-1]
            left = until - here.s
            target = self.path.stop(here.s, here.s + (left if left < 1.01 * step else step))
            found = self._go(track, self._across(track, target))
            if found is None:
                step *= 0.5
                if step < SHARPEST and not jumped:
                    jumped = True
                    found = self._jump(track)
                if step < SHORTEST:
                    track.complete = False
                    break
            if found is not None:
                jumped = False
                easy = found.pose.first_step < 0.03
                step = min(self.longest, max(step, found.s - here.s) * (2.0 if easy else 1.2))
                if not self._append(track, found, switch):
                    track.complete = False
                    break
        return track

    def _go(self, track: Track, target: float, jump: bool = False) -> Node | None:
        here = track.nodes[-1]
        guess = self.path.place(self.predict(track.nodes, target), target)
        pose = self.loops.close(guess, self.parameters)
        if pose is None:
            return None
        old, new = here.pose.follow, pose.follow
        bound = TURN * (0.5 + max(map(abs, old), default=0.0))
        if any(abs(x - y) > bound for x, y in zip(old, new, strict=True)):
            return None
        if jump and not flips(here.pose, pose):
            return None
        return self.node(target, pose)

    def predict(self, nodes: Sequence[Node], s: float) -> list[float]:
        """State at s, by the cubic through the last two nodes; or from their rates where that would not hold.

        What moves by itself is not put right by Newton's method, and would be blown up by the cubic: its parasitic
        root is -5, that of the rates 0 (Hairer, Nørsett and Wanner, Solving Ordinary Differential Equations I, III.3).
        """
        b = nodes[-1]
        h, change = s - b.s, 0.0
        if len(nodes) > 1 and (width := b.s - nodes[-2].s) >= 0.5 * h:
            if self.loops.determined:
                return _cubic(nodes[-2], b, 1.0 + h / width, width)
            change = 0.5 * h / width
        a = nodes[-2] if change else b
        return [x + h * (v + change * (v - u)) for x, v, u in zip(b.pose.state, b.rate, a.rate, strict=True)]

    def _across(self, track: Track, target: float) -> float:
        """The target, or where it lies near a change point as far behind that as the last node is before it."""
        if len(track.nodes) < 2:
            return target
        a, b = track.nodes[-2:]
        for x, y in zip(a.pose.determinants, b.pose.determinants, strict=True):
            if abs(y) < abs(x) and x * y > 0.0:
                ahead = (b.s - a.s) * y / (x - y)
                if 0.4 * ahead < target - b.s < 1.6 * ahead:
                    return float(min(b.s + 2.0 * ahead, self.path.length))
        return target

    def _jump(self, track: Track) -> Node | None:
        for jump in JUMPS:
            target = min(track.end + jump, self.path.length)
            found = self._go(track, target, jump=True)
            if found is not None:
                return found
        return None

    def _append(self, track: Track, found: Node, switch: bool) -> bool:
        """Go on to the node `found`, over a change point if one lies before it; False if its other branch is lost."""
        here = track.nodes[-1]
        if not flips(here.pose, found.pose):
            track.nodes.append(found)
            return True
        where = self._root(here, found)
        track.crossings.append(where)
        if not self._closes(here, found, where):
            track.doubts.append(where)
        if not switch:
            track.nodes.append(found)
            return True
        ahead = Track([*track.nodes, found])
        track.sides.append(self._on(ahead, False, max(found.s, min(where + BEYOND, self.path.length))))
        t = (where - here.s) / (found.s - here.s)
        state = self.loops.unit(_cubic(here, found, t, found.s - here.s))  # type: ignore[arg-type]
        away = other_branch(self, here, found, where, state)  # type: ignore[arg-type]
        if away is None:
            return False
        through = [(y - x) / (found.s - here.s) for x, y in zip(here.pose.state, found.pose.state, strict=True)]
        onward = [(y - x) / (away.s - where) for x, y in zip(state, away.pose.state, strict=True)]
        for node, rate in ((here, through), (away, onward)):
            middle = Pose(state, node.pose.follow, node.pose.determinants, 0.0)  # type: ignore[arg-type]
            track.nodes.append(Node(where, middle, rate))  # type: ignore[arg-type]
        track.nodes.append(away)
        return True

    def _root(self, a: Node, b: Node) -> float:
        """Where a determinant vanishes between two nodes: false position, then inverse interpolation from around."""
        k = next(
            i for i, (x, y) in enumerate(zip(a.pose.determinants, b.pose.determinants, strict=True)) if x * y < 0.0
        )

        def determinant(s: float) -> float:
            guess = _cubic(a, b, (s - a.s) / (b.s - a.s), b.s - a.s)
            pose = self.loops.close(self.path.place(guess, s), self.parameters)
            # the determinants are those of the last step but one
            pose = pose and self.loops.close(pose.state, self.parameters)
            return pose.determinants[k] if pose is not None else np.nan

        (left, low), (right, high) = (a.s, a.pose.determinants[k]), (b.s, b.pose.determinants[k])
        s = left
        for _ in range(4):
            s = (left * high - right * low) / (high - low)
            middle = determinant(s)
            if not abs(middle) > 0.0:
                break
            if middle * low > 0.0:
                left, low, high = s, middle, 0.5 * high
            else:
                right, high, low = s, middle, 0.5 * low
        width = min(max(s - a.s, b.s - s), 0.2)
        knots = [s + 0.24 * width * j for j in (-4, -3, -2, -1, 1, 2, 3, 4)]
        better = at_zero(knots, [determinant(knot) for knot in knots])
        return better if abs(better - s) < width else s

    def _closes(self, a: Node, b: Node, where: float) -> bool:
        """Whether the smooth way through a change point closes in it: the polynomial through poses around it."""
        knots = [where + KNOT * j for j in (-4, -3, -2, -1, 1, 2, 3, 4)]
        state = np.zeros(len(a.pose.state))
        for knot in knots:
            guess = _cubic(a, b, (knot - a.s) / (b.s - a.s), b.s - a.s)
            pose = self.loops.close(self.path.place(guess, knot), self.parameters)
            if pose is None:
                return False
            weight = np.prod([(where - other) / (knot - other) for other in knots if other != knot])
            state = state + weight * np.array(pose.state)
        middle = self.path.place(state.tolist(), where)
        residual = self.loops.mechanism.newton[0](middle, self.parameters)[: self.loops.rows]
        return bool(max(map(abs, residual)) < max(OPEN, self.loops.tolerance))


def at_zero(values: list[float], arguments: list[float]) -> float:
    """Value at argument 0 of the polynomial through the points (Neville's scheme)."""
    out = list(values)
    for level in range(1, len(out)):
        for i in range(len(out) - level):
            x, y = arguments[i], arguments[i + level]
            out[i] = (out[i] * y - out[i + 1] * x) / (y - x) if y != x else np.nan
    return out[0]


def other_branch(march: March, here: Node, found: Node, where: float, state: Sequence[float]) -> Node | None:
    """A pose on the branch that crosses, at `where` and `state`, the one on which two nodes lie.

    Beyond a change point the branches lie apart along the motion that is free in it: the null vector of the equations.
    Newton's method starts from the known branch displaced along it, either way and farther and farther. What it finds
    is the other branch if it leads back to the change point, and if the determinants keep the sign that they had
    before: they change it on the branch that goes on smoothly.
    """
    loops, n, m = march.loops, march.loops.columns, march.loops.rows
    entries = loops.mechanism.newton[0](state, march.parameters)[m:]
    free = np.linalg.svd(np.array(entries).reshape(m, n))[2][-1]
    beyond = min(max(found.s - where, 0.05), march.path.length - where)
    along = (beyond / (found.s - here.s)) * np.subtract(found.pose.state, here.pose.state)
    for share in AWAY:
        for sign in (1.0, -1.0):
            ahead = np.add(state, along).tolist()
            guess = loops.advance(ahead, (sign * share * beyond * free).tolist())
            s = where + beyond
            pose = loops.close(march.path.place(guess, s), march.parameters, far=0.5)  # type: ignore[arg-type]
            if pose is None or flips(here.pose, pose):
                continue
            node = march.node(s, pose)
            back = [x - beyond * v for x, v in zip(pose.state, node.rate, strict=True)]
            if max(abs(x - y) for x, y in zip(back, state, strict=True)) < 0.3 * share * beyond + 0.1 * beyond:
                return node
    return None


def flips(one: Pose, other: Pose) -> bool:
    """True where a determinant has another sign at the other pose."""
    return any(x * y < 0.0 for x, y in zip(one.determinants, other.determinants, strict=True))


def _cubic(a: Node, b: Node, t: float, width: float) -> list[float]:
    """State at a.s + t * width on the cubic through two nodes with their rates."""
    tt = t * t
    p, q = (1.0 + 2.0 * t) * (1.0 - t) ** 2, t * (1.0 - t) ** 2 * width
    r, u = tt * (3.0 - 2.0 * t), tt * (t - 1.0) * width
    return [
        p * w + q * x + r * y + u * z for w, x, y, z in zip(a.pose.state, a.rate, b.pose.state, b.rate, strict=True)
    ]
