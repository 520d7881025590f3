"""One moving drive: every pose lies on one line, whatever the order of its values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.loops import Loops, Pose
from .behind import put_together
from .follow import Guide
from .guess import NEAR, Guess, guess_of
from .march import BEYOND, March, Track, flips
from .path import Path

Mask = NDArray[np.bool_]
TURN = 2.0 * np.pi
# How far the drive is followed turn by turn, and how near to its place everything is after a turn.
MANY = 6.0 * TURN
SAME = 1e-10
# Beyond, the other angles are not counted on: their rounding would leave the loops open.
WOUND = 1000.0


@dataclass(frozen=True, eq=False)
class SingleDrive:
    """Follows one drive both ways from the drawing.

    Attributes
    ----------
    loops, nominal, start
        The loops, their nominal dimensions and the drawing.
    drive
        Which of the driven states moves.
    switch, longest
        Whether the other branch is taken at change points; longest step.
    """

    loops: Loops
    nominal: Sequence[float]
    start: Pose
    drive: int
    switch: bool
    longest: float

    def guess(self, s: Array) -> Guess:
        """First guesses at values s of the drive.

        A drive that turns goes round the other way to what lies beyond an end of its range. Where it is to go round
        many times, what it has found once is taken again, if there everything is back in its place.
        """
        again = self._again(s) if np.abs(s).max(initial=0.0) > MANY else None
        return self._followed(s) if again is None else again

    def _again(self, s: Array) -> Guess | None:
        """First guesses by whole turns, one or two at a time, after which everything is in its place."""
        if self.switch or not self.loops.turns(self.drive) or not self.loops.determined:
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
        track = self._track(period + BEYOND)
        there = self.loops.close(Guide.of(track).at(np.array(period)).tolist(), self.nominal)
        if not track.complete or track.doubts or there is None or flips(self.start, there):
            return None
        away = np.subtract(there.state, self.start.state)
        away[self.loops.driven_states[self.drive]] = 0.0
        turns = TURN * np.round(away / TURN)
        turning = [self.loops.is_angle(place) for place in range(len(away))]
        return None if np.abs(away - turns).max() > SAME or np.any(turns[np.logical_not(turning)]) else turns.tolist()

    def _followed(self, s: Array) -> Guess:
        """First guesses at values s of the drive, all the way."""
        ahead, back = (self._track(sign * float(np.max(sign * s, initial=0.0) + BEYOND)) for sign in (1.0, -1.0))
        within = s
        if self.loops.turns(self.drive):
            if back.complete and not ahead.complete:
                back = self._other_way_round(s, ahead, back, 1.0)
            elif ahead.complete and not back.complete:
                ahead = self._other_way_round(s, back, ahead, -1.0)
            for sign, track in ((1.0, ahead), (-1.0, back)):
                turns = np.ceil((sign * within - track.end) / TURN)
                within = np.where(turns > 0.0, within - sign * TURN * turns, within)
        guide = self._guide(ahead, back)
        around = {where: Guide.of(side, back) for where, side in _sides(ahead)}
        around |= {-where: Guide.of(ahead, side) for where, side in _sides(back)}
        parts = guide.at(within), guide.signs_at(within, NEAR), guide.reached(within), guide.sure(within)
        out = guess_of(*(parts if parts[2].all() else self._behind(within, *parts)))
        out.s, out.guide, out.drive, out.around, out.switched = within, guide, self.drive, around, self.switch
        return out

    def _guide(self, ahead: Track, back: Track) -> Guide:
        """The guide along both ways from the drawing; the last one is kept."""
        kept = self.loops.guide
        if kept is None or kept[0] is not ahead or kept[1] is not back:
            kept = self.loops.guide = ahead, back, Guide.of(ahead, back)
        return kept[2]

    def _behind(
        self, s: Array, states: Array, signs: Array, reached: Mask, sure: Mask
    ) -> tuple[Array, Array, Mask, Mask, Mask]:
        """The parts of a guess at values s, put right where a way begins anew behind a gap, and where that is."""
        apart, left = np.zeros(s.shape, dtype=bool), np.unique(s[~reached])
        states, signs = states.copy(), signs.copy()
        while left.size:
            drawn = np.tile([self.loops.drawn[place] for place in self.loops.driven_states], (len(left), 1))
            drawn[:, self.drive] += left
            found = put_together(self.loops, self.nominal, self.start, drawn)
            if found is None:
                break
            begin, pose = left[found[0]], found[1]
            ends = ((1.0, left[-1] - begin + BEYOND), (-1.0, begin - left[0] + BEYOND))
            guide = Guide.of(*(self._from(pose, sign * far) for sign, far in ends))
            new = ~reached & guide.reached(s - begin)
            states[new], signs[new] = guide.at((s - begin)[new]), guide.signs_at((s - begin)[new], NEAR)
            reached, sure, apart = reached | new, sure & ~new, apart | new
            left = left[~guide.reached(left - begin)]
        return states, signs, reached, sure, apart

    def _from(self, pose: Pose, far: float) -> Track:
        """The way of the drive by `far` from a pose."""
        begin = np.array([pose.state[place] for place in self.loops.driven_states])
        end = begin.copy()
        end[self.drive] += far
        way = Path(self.loops, np.stack([begin, end]))
        return March(self.loops, self.nominal, way, self.longest).run(pose, self.switch)

    def _track(self, far: float) -> Track:
        """The way to a value of the drive, `far` from the drawing; the last one each way is kept."""
        key = self.drive, self.switch, self.longest, far
        if self.loops.kept.get(far > 0.0, (None, None))[0] != key:
            self.loops.kept[far > 0.0] = key, self._from(self.start, far)
        return self.loops.kept[far > 0.0][1]

    def _other_way_round(self, s: Array, ended: Track, other: Track, sign: float) -> Track:
        """The track `other`, as far as it takes to come to all that lies beyond the one that `ended`."""
        beyond = sign * s[sign * s > ended.end]
        around = beyond - TURN * np.ceil((beyond - ended.end) / TURN)
        need = float(np.max(-around, initial=0.0)) + BEYOND
        return self._track(-sign * need) if need > other.end else other


def _sides(track: Track) -> Iterator[tuple[float, Track]]:
    """Change points of a track, and what leads through each of them smoothly."""
    sides = track.sides or [track] * len(track.crossings)
    return zip(track.crossings, sides, strict=False)
