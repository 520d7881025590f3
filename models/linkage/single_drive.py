"""One moving drive: every pose lies on one line, whatever the order of its values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from ...framework.batch import Array
from .follow import Guide
from .guess import NEAR, Guess, guess_of
from .loops import Loops, Pose
from .march import BEYOND, March, Track
from .path import Path

TURN = 2.0 * np.pi


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

        A drive that turns goes round the other way to what lies beyond an end of its range.
        """
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
        guide = Guide.of(ahead, back)
        around = {where: Guide.of(side, back) for where, side in _sides(ahead)}
        around |= {-where: Guide.of(ahead, side) for where, side in _sides(back)}
        out = guess_of(guide.at(within), guide.signs_at(within, NEAR), guide.reached(within), guide.sure(within))
        out.s, out.guide, out.drive, out.around, out.switched = within, guide, self.drive, around, self.switch
        return out

    def _track(self, far: float) -> Track:
        """The way to a value of the drive, `far` from the drawing; the last one each way is kept."""
        key = self.drive, self.switch, self.longest, far
        if self.loops.kept.get(far > 0.0, (None, None))[0] != key:
            drawn = np.array([self.loops.drawn[place] for place in self.loops.driven_states])
            end = drawn.copy()
            end[self.drive] += far
            way = Path(self.loops, np.stack([drawn, end]))
            track = March(self.loops, self.nominal, way, self.longest).run(self.start, self.switch)
            self.loops.kept[far > 0.0] = key, track
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
