"""One moving drive: every pose lies on one line, whatever the order of its values."""

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
# How far the drive is followed turn by turn, and how near to its place everything is after a turn.
MANY = 6.0 * TURN
SAME = 1e-10
# Beyond, the other angles are not counted on: their rounding would leave the loops open.
WOUND = 1000.0


@dataclass(frozen=True, eq=False)
class SingleDrive:
    """Follows one drive both ways from the reference configuration.

    Attributes
    ----------
    loops, parameters, start
        The loops, their dimensions and the reference configuration.
    drive
        Which of the driven states moves.
    switch
        Whether the other branch is taken at change points.
    """

    loops: Loops
    parameters: Sequence[float]
    start: Pose
    drive: int
    switch: bool

    def guess(self, s: Array) -> Guess:
        """First guesses at values s of the drive.

        A drive that turns goes round the other way to what lies beyond an end of its range. Where it is to go round
        many times, what it has found once is taken again, if there everything is back in its place.
        """
        again = self._again(s) if np.abs(s).max(initial=0.0) > MANY else None
        return self._followed(s) if again is None else again

    def guide_over(self, low: float, high: float) -> Guide:
        """The guide both ways from the reference configuration, from `low` to `high` where the path leads there."""
        return self._guide(self._path(1.0, max(high, 0.0) + BEYOND), self._path(-1.0, max(-low, 0.0) + BEYOND))

    def exactly(self, s: float) -> list[float] | None:
        """The state at one value of the drive, step by step from the node before it; None where that is lost."""
        path = self._path(1.0 if s >= 0.0 else -1.0, abs(s) + BEYOND)
        before = [node for node in path.nodes if node.s <= abs(s)][-1]
        return self._continue(1.0 if s >= 0.0 else -1.0).exactly(before, abs(s))

    def _again(self, s: Array) -> Guess | None:
        """First guesses by whole turns, one or two at a time, after which everything is in its place."""
        if self.switch or not self.loops.is_rotation(self.drive) or not self.loops.determined:
            return None
        for period in (TURN, 2.0 * TURN):
            winding = self._winding(period)
            if winding is not None:
                rounds = np.trunc(s / period)
                out = self._followed(s - period * rounds)
                rounds = np.where(np.abs(s) < WOUND, rounds, 0.0)
                out.state = [x + rounds * turns if turns else x for x, turns in zip(out.state, winding, strict=True)]
                return out
        return None

    def _winding(self, period: float) -> list[float] | None:
        """By how much the state has grown after a period, in whole turns of joints; None where that leads elsewhere."""
        path = self._path(1.0, period + BEYOND)
        there = self.loops.close(Guide.of(path).at(np.array(period)).tolist(), self.parameters)
        if not path.complete or there is None or changes_sign(self.start, there):
            return None
        away = np.subtract(there.state, self.start.state)
        away[self.loops.driven_states[self.drive]] = 0.0
        turns = TURN * np.round(away / TURN)
        turning = [self.loops.is_angle(place) for place in range(len(away))]
        return None if np.abs(away - turns).max() > SAME or np.any(turns[np.logical_not(turning)]) else turns.tolist()

    def _followed(self, s: Array) -> Guess:
        """First guesses at values s of the drive, all the way."""
        ahead, back = (self._path(sign, float(np.max(sign * s, initial=0.0)) + BEYOND) for sign in (1.0, -1.0))
        within = s
        if self.loops.is_rotation(self.drive):
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
        """The guide along both paths from the reference configuration; the last one is kept."""
        kept, key = self.loops.guide, (ahead, back, len(ahead.nodes), len(back.nodes))
        if kept is None or kept[0] != key:
            kept = self.loops.guide = key, Guide.of(ahead, back)
        guide: Guide = kept[1]
        return guide

    def _continue(self, sign: float) -> PredictorCorrector:
        direction = [sign * (k == self.drive) for k in range(len(self.loops.driven_states))]
        return PredictorCorrector(self.loops, self.parameters, self.start, direction, self.switch)

    def _path(self, sign: float, until: float) -> RayPath:
        """The path of the drive one way, at least to `until`; the last one each way is kept, and taken further.

        Nodes do not depend on how far a path is followed, so that one that was followed farther before serves as well.
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
        """The path the other way, as far as it takes to come to all that lies beyond the one that `ended`."""
        beyond = sign * s[sign * s > ended.end]
        around = beyond - TURN * np.ceil((beyond - ended.end) / TURN)
        return self._path(-sign, float(np.max(-around, initial=0.0)) + BEYOND)


def _sides(path: RayPath) -> Iterator[tuple[float, RayPath]]:
    """Change points of a path, and what leads through each of them smoothly."""
    sides = path.sides or [path] * len(path.crossings)
    return zip(path.crossings, sides, strict=False)
