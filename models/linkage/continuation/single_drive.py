"""The path of one moving drive, followed both ways from the reference configuration; every pose lies on it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ....framework.batch import Array
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from .ends import SHORT
from .follow import Guide
from .guess import NEAR, Guess
from .predictor_corrector import BEYOND, PredictorCorrector, RayPath, changes_sign

TURN = 2.0 * np.pi
# Angle up to which the drive is followed all the way, and the tolerance within which a turn is closed.
MANY = 6.0 * TURN
SAME = 1e-10
# Number of turns beyond which other angles are not counted on: their rounding would leave the loops open.
WOUND = 1000.0


@dataclass(frozen=True, eq=False)
class SingleDrive:
    """Follows one drive both ways from the reference configuration.

    Attributes
    ----------
    loops, parameters, start
        The loops, their dimensions and the reference configuration.
    drive
        Index of the driven state that moves.
    switch
        Whether the other branch is taken at change points.
    """

    loops: Loops
    parameters: Sequence[float]
    start: Pose
    drive: int
    switch: bool

    def guess(self, s: Array) -> Guess:
        """Starting values at values s of the drive.

        A rotating drive reaches values beyond an end of its range the other way round. If it makes many turns, the
        poses of the first are used again, provided that the linkage returns to its configuration after a turn.
        """
        low, high = reach(s)
        again = self._again(s) if max(high, -low) > MANY else None
        return self._followed(s, low, high) if again is None else again

    def guide_over(self, low: float, high: float) -> Guide:
        """The path both ways from the reference configuration, from `low` to `high` if it leads there."""
        return self._guide(self._path(1.0, max(high, 0.0) + BEYOND), self._path(-1.0, max(-low, 0.0) + BEYOND))

    def exactly(self, s: float) -> list[float] | None:
        """The state at one value of the drive, in short steps from the node before it; None if they fail."""
        path = self._path(1.0 if s >= 0.0 else -1.0, abs(s) + BEYOND)
        before = [node for node in path.nodes if node.s <= abs(s)][-1]
        return self._continue(1.0 if s >= 0.0 else -1.0).exactly(before, abs(s))

    def _again(self, s: Array) -> Guess | None:
        """Starting values by whole turns, if the linkage returns to its configuration after one or two; else None."""
        if self.switch or not self.loops.is_rotation(self.drive) or not self.loops.determined:
            return None
        for period in (TURN, 2.0 * TURN):
            winding = self._winding(period)
            if winding is not None:
                rounds = np.trunc(s / period)
                first = s - period * rounds
                out = self._followed(first, *reach(first))
                rounds = np.where(np.abs(s) < WOUND, rounds, 0.0)
                out.state = [x + rounds * turns if turns else x for x, turns in zip(out.state, winding, strict=True)]
                return out
        return None

    def _winding(self, period: float) -> list[float] | None:
        """Change of the state over a period, in whole turns of joints; None if the configuration is another one."""
        path = self._path(1.0, period + BEYOND)
        there = self.loops.close(Guide.of(path).at(np.array(period)).tolist(), self.parameters)
        if not path.complete or there is None or changes_sign(self.start, there):
            return None
        away = np.subtract(there.state, self.start.state)
        away[self.loops.driven_states[self.drive]] = 0.0
        turns = TURN * np.round(away / TURN)
        turning = [self.loops.is_angle(place) for place in range(len(away))]
        return None if np.abs(away - turns).max() > SAME or np.any(turns[np.logical_not(turning)]) else turns.tolist()

    def _followed(self, s: Array, low: float, high: float) -> Guess:
        """Starting values at values s of the drive, from `low` to `high`, by following it all the way."""
        ahead, back = self._path(1.0, high + BEYOND), self._path(-1.0, BEYOND - low)
        within = s
        if not (ahead.complete and back.complete) and self.loops.is_rotation(self.drive):
            if not ahead.complete:
                back = self._other_way_round(s, ahead, 1.0)
            if not back.complete:
                ahead = self._other_way_round(s, back, -1.0)
            for sign, path in ((1.0, ahead), (-1.0, back)):
                turns = np.ceil((sign * within - path.end - SHORT) / TURN)
                within = np.where(turns > 0.0, within - sign * TURN * turns, within)
        guide = self._guide(ahead, back)
        around = {where: Guide.of(side, back) for where, side in _sides(ahead)}
        around |= {-where: Guide.of(ahead, side) for where, side in _sides(back)}
        out = Guess(list(guide.entries(within)), list(guide.signs_at(within, NEAR)), guide.reached(within))
        out.s, out.guide, out.drive, out.around, out.switched = within, guide, self.drive, around, self.switch
        return out

    def _guide(self, ahead: RayPath, back: RayPath) -> Guide:
        """Both paths from the reference configuration as one; the last result is kept."""
        kept, key = self.loops.guide, (ahead, back, len(ahead.nodes), len(back.nodes))
        if kept is None or kept[0] != key:
            kept = self.loops.guide = key, Guide.of(ahead, back)
        guide: Guide = kept[1]
        return guide

    def _continue(self, sign: float) -> PredictorCorrector:
        direction = [sign * (k == self.drive) for k in range(len(self.loops.driven_states))]
        return PredictorCorrector(self.loops, self.parameters, self.start, direction, self.switch)

    def _path(self, sign: float, until: float) -> RayPath:
        """The path of the drive in one direction, at least to `until`; the last one is kept and extended.

        Nodes do not depend on how far a path is followed, so a path that was followed farther before serves as well.
        """
        kept, key = self.loops.kept, (self.start, self.drive, self.switch)
        known, path = kept.get(sign > 0.0, (None, None))
        if known == key and not (path.complete and path.end < until):
            return path  # type: ignore[no-any-return]
        continuation = self._continue(sign)
        if known != key:
            kept[sign > 0.0] = key, continuation.begin(self.start)
        return continuation.extend(kept[sign > 0.0][1], until)

    def _other_way_round(self, s: Array, ended: RayPath, sign: float) -> RayPath:
        """The path in the other direction, far enough to reach all values beyond the end of `ended`."""
        beyond = sign * s[sign * s > ended.end]
        around = beyond - TURN * np.ceil((beyond - ended.end) / TURN)
        return self._path(-sign, float(np.max(-around, initial=0.0)) + BEYOND)


def reach(s: Array) -> tuple[float, float]:
    """Least and greatest of the values s and 0."""
    return float(s.min(initial=0.0)), float(s.max(initial=0.0))


def _sides(path: RayPath) -> Iterator[tuple[float, RayPath]]:
    """Change points of a path, each with the smooth branch through it."""
    sides = path.sides or [path] * len(path.crossings)
    return zip(path.crossings, sides, strict=False)
