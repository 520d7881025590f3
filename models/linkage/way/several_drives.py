"""Several moving drives: a way through all poses along the sweep."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.loops import Loops, Pose
from .behind import put_together
from .drives import Drives
from .fan import fanned, scattered
from .follow import Guide
from .guess import NEAR, Guess, guess_of
from .march import March, Track
from .path import Path

Mask = NDArray[np.bool_]
Parts = tuple[Array, Array, Mask, Mask, Mask]


def through_poses(
    loops: Loops, nominal: Sequence[float], start: Pose, drives: Drives, switch: bool, longest: float
) -> Guess:
    """Follow the drives along the first axis on which they vary, each line of poses for itself from the drawing."""
    values = np.stack(np.broadcast_arrays(*drives.states), axis=-1)
    axis = next((k for k, size in enumerate(drives.shape) if size > 1), None)
    lines = values[None] if axis is None else np.moveaxis(values, axis, 0)
    flat = lines.reshape(lines.shape[0], -1, values.shape[-1])
    line = Line(loops, nominal, start, switch, longest)
    found = [line.followed(_same_sign(loops, flat[:, k])) for k in range(flat.shape[1])]
    parts = (np.stack(part, axis=1) for part in zip(*found, strict=True))
    shaped = [part.reshape(*lines.shape[:-1], *part.shape[2:]) for part in parts]
    return guess_of(*(part[0] if axis is None else np.moveaxis(part, 0, axis) for part in shaped))


@dataclass(frozen=True, eq=False)
class Line:
    """Follows one line of poses.

    Where the way ends, out of reach or in a dead point, it is taken up again at the first later pose to which a
    straight way leads from its end or from the drawing; if there is none, where the linkage can be put together anew.
    """

    loops: Loops
    nominal: Sequence[float]
    start: Pose
    switch: bool
    longest: float

    def followed(self, values: Array) -> Parts:
        """States (poses, n), signs (poses, blocks), where driven states (poses, f) are reached, surely, or anew."""
        count = len(values)
        states = np.empty((count, len(self.loops.mechanism.state_names)))
        reached, sure, apart = np.zeros(count, dtype=bool), np.ones(count, dtype=bool), np.zeros(count, dtype=bool)
        out = states, np.zeros((count, self.loops.linear.signs)), reached, sure, apart
        begin, done = self.start, 0
        whole = Path(self.loops, np.concatenate([self._driven(begin)[None], values]))
        if self.loops.linear.signs and not self.loops.driven_balls and scattered(whole):
            found = fanned(self.loops, self.nominal, self.start, values, self._straight)
            if found is not None:
                return (*found, sure, sure, apart)
        while True:
            certain = done == 0 or bool(sure[done])
            track = self._go(out, begin, values, done, count)
            sure[done:] &= certain
            done += int(np.count_nonzero(reached[done:]))
            if done == count:
                return out
            again = self._regained(track.nodes[-1].pose, values, done)
            self._begin_anew(out, values, done, count if again is None else again[0])
            if again is None:
                return out
            done, begin = again

    def _go(self, out: Parts, begin: Pose, values: Array, first: int, behind: int) -> Track:
        """Follow the poses from the `first` to that before `behind`, as far as the way leads."""
        states, signs, reached, sure, _ = out
        way = Path(self.loops, np.concatenate([self._driven(begin)[None], values[first:behind]]))
        track = March(self.loops, self.nominal, way, self.longest).run(begin, self.switch)
        guide, s, those = Guide.of(track), np.array(way.corners[1:]), slice(first, behind)
        states[those], signs[those] = guide.at(s), guide.signs_at(s, NEAR)
        reached[those], sure[those] = guide.reached(s), guide.sure(s)
        return track

    def _begin_anew(self, out: Parts, values: Array, first: int, behind: int) -> None:
        """Follow the poses of a gap from where the linkage can be put together."""
        _, _, reached, sure, apart = out
        while found := put_together(self.loops, self.nominal, self.start, values[first:behind]):
            first += found[0]
            self._go(out, found[1], values, first, behind)
            there = slice(first, first + int(np.count_nonzero(reached[first:behind])))
            sure[there], apart[there], first = False, True, there.stop

    def _driven(self, pose: Pose) -> Array:
        return np.array([pose.state[place] for place in self.loops.driven_states])

    def _regained(self, last: Pose, values: Array, done: int) -> tuple[int, Pose] | None:
        """The first pose from `done` on that can be reached straight, tried in strides that grow, then cut in half."""
        failed = done - 1
        for index in _strides(done, len(values)):
            found = self._straight(last, values[index]) or self._straight(self.start, values[index])
            if found is None:
                failed = index
                continue
            while index - failed > 1:
                middle = (index + failed) // 2
                nearer = self._straight(last, values[middle]) or self._straight(self.start, values[middle])
                if nearer is None:
                    failed = middle
                else:
                    index, found = middle, nearer
            return index, found
        return None

    def _straight(self, begin: Pose, values: Array) -> Pose | None:
        """The pose at driven states to which the way leads straight from another."""
        way = Path(self.loops, np.stack([self._driven(begin), values]))
        track = March(self.loops, self.nominal, way, self.longest).run(begin, self.switch)
        return track.nodes[-1].pose if track.complete else None


def _strides(begin: int, end: int) -> Iterator[int]:
    stride = 1
    while begin < end:
        yield begin
        begin += stride
        stride *= 2


def _same_sign(loops: Loops, values: Array) -> Array:
    """Driven states along a way, with the Euler parameters of each ball of the sign nearest to the one before."""
    out = values.copy()
    for place in loops.driven_balls:
        k = loops.driven_states.index(place)
        previous = np.concatenate([[[1.0, 0.0, 0.0, 0.0]], out[:-1, k : k + 4]])
        turn = np.cumprod(np.where((previous * out[:, k : k + 4]).sum(axis=-1) < 0.0, -1.0, 1.0))
        out[:, k : k + 4] *= turn[:, None]
    return out
