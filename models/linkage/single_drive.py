"""One moving drive: every pose lies on one line, whatever the order of its values."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from ...framework.batch import Array
from .drives import Drives
from .follow import Guide
from .guess import NEAR, Guess, guess_of
from .loops import Loops, Pose
from .march import BEYOND, March, Track
from .path import Path

TURN = 2.0 * np.pi


def along_line(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    drives: Drives,
    moving: list[int],
    switch: bool,
    longest: float,
) -> Guess:
    """Follow the drive both ways from the drawing; a drive that turns, round the other way to what lies beyond an end."""
    place = moving[0] if moving else 0
    s = np.broadcast_to(drives.states[place], drives.shape) if drives.states else np.zeros(())
    if not moving:
        guide = Guide.of(Track([March(loops, nominal, _line(loops, place, 0.0), longest).node(0.0, start)]))
        return guess_of(guide.at(s), guide.signs_at(s, NEAR), np.ones(s.shape, dtype=bool))
    tracks = {}
    for sign in (1.0, -1.0):
        far = float(np.max(sign * s, initial=0.0)) + BEYOND
        march = March(loops, nominal, _line(loops, place, sign * far), longest)
        tracks[sign] = march.run(start, switch)
    if loops.turns(place):
        for sign in (1.0, -1.0):
            _other_way_round(loops, nominal, start, s, place, sign, tracks, switch, longest)
    guide = Guide.of(tracks[1.0], tracks[-1.0])
    within = s
    if loops.turns(place):
        for sign in (1.0, -1.0):
            beyond = sign * within > tracks[sign].end
            turns = np.ceil((sign * within - tracks[sign].end) / TURN)
            within = np.where(beyond, within - sign * TURN * turns, within)
    guess = guess_of(guide.at(within), guide.signs_at(within, NEAR), guide.reached(within))
    guess.s, guess.guide, guess.drive, guess.switched = within, guide, place, switch
    guess.around = {where: Guide.of(side, tracks[-1.0]) for where, side in _sides(tracks[1.0])}
    guess.around |= {-where: Guide.of(tracks[1.0], side) for where, side in _sides(tracks[-1.0])}
    return guess


def _sides(track: Track) -> Iterator[tuple[float, Track]]:
    """Change points of a track, and what leads through each of them smoothly."""
    sides = track.sides or [track] * len(track.crossings)
    return zip(track.crossings, sides, strict=False)


def _other_way_round(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    s: Array,
    place: int,
    sign: float,
    tracks: dict[float, Track],
    switch: bool,
    longest: float,
) -> None:
    """Where a turning drive cannot get to a pose in one sense, it may in the other: go so far back."""
    end = tracks[sign].end
    beyond = s[sign * s > end]
    if tracks[sign].complete or beyond.size == 0:
        return
    around = sign * beyond - TURN * np.ceil((sign * beyond - end) / TURN)
    need = float(np.max(-around)) + BEYOND
    if tracks[-sign].complete and need > tracks[-sign].end:
        tracks[-sign] = March(loops, nominal, _line(loops, place, -sign * need), longest).run(start, switch)


def _line(loops: Loops, place: int, value: float) -> Path:
    drawn = np.array([loops.drawn[k] for k in loops.driven_states])
    if not drawn.size or value == 0.0:
        return Path(loops, drawn[None])
    end = drawn.copy()
    end[place] += value
    return Path(loops, np.stack([drawn, end]))
