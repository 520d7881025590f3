"""Which way to each pose, and the first guess there."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...framework.batch import Array
from .drives import Drives
from .follow import Guide
from .loops import Loops, Pose
from .march import BEYOND, LONGEST, March, Track
from .path import Path
from .tape import Value

# Refinements of the longest step where the poses in between do not bear out the nodes.
FINER = (1.0, 0.2, 0.04)
# Signs of determinants are not compared so near a change point.
NEAR = 0.02
TURN = 2.0 * np.pi


@dataclass(eq=False)
class Guess:
    """Nominal states over the drives' shape.

    Attributes
    ----------
    state
        Entries of the state, (...).
    signs
        Signs that the determinants must have, 0 where they may have either, (...).
    reached
        Where a way leads, (...).
    s
        Value of the only moving drive, (...); None where several move.
    guide
        What led along it.
    drive
        Which of the driven states it is.
    around
        What leads smoothly through each change point.
    switched
        Whether the way takes the other branch there.
    """

    state: list[Value]
    signs: list[Value]
    reached: NDArray[np.bool_]
    s: Array | None = None
    guide: Guide | None = None
    drive: int = 0
    around: dict[float, Guide] = field(default_factory=dict)
    switched: bool = False


def guesses(loops: Loops, nominal: Sequence[float], start: Pose, drives: Drives, switch: bool) -> Guess:
    """States of the nominal linkage at all values of the drives, solved and borne out, or the last before them."""
    drawn = [loops.drawn[place] for place in loops.driven_states]
    moving = [k for k, x in enumerate(drives.states) if np.any(x != drawn[k])]
    alone = len(moving) <= 1 and not loops.driven_balls
    for finer in FINER:
        if alone:
            guess = _single(loops, nominal, start, drives, moving, switch, LONGEST * finer)
        else:
            guess = _several(loops, nominal, start, drives, switch, LONGEST * finer)
        if _borne_out(loops, guess, nominal, drives):
            break
    return guess


def _borne_out(loops: Loops, guess: Guess, nominal: Sequence[float], drives: Drives) -> bool:
    """Close the nominal poses; True where all are trusted and of the sign that they should have."""
    _drive(loops, guess, drives)
    found = loops.close_all(list(guess.state), nominal)
    good = np.asarray(found.trusted)
    for determinant, sign in zip(found.determinants, guess.signs, strict=True):
        good = good & (np.asarray(determinant) * sign >= 0.0)
    near = np.zeros(good.shape, dtype=bool)
    if guess.guide is not None and guess.s is not None:
        for where in guess.guide.crossings:
            near |= np.abs(guess.s - where) < NEAR
    for place in loops.unknown_states:
        guess.state[place] = np.where(good, found.state[place], guess.state[place])
    return bool(np.all(good | near | ~guess.reached))


def _drive(loops: Loops, guess: Guess, drives: Drives) -> None:
    for place, value in zip(loops.driven_states, drives.states, strict=True):
        guess.state[place] = value
    guess.state = loops.unit(guess.state)


def _from_array(states: Array, signs: Array, reached: NDArray[np.bool_]) -> Guess:
    return Guess(list(np.moveaxis(states, -1, 0)), list(np.moveaxis(signs, -1, 0)), reached)


# -- one drive: every pose lies on one line, whatever the order ----------------------------------------------------


def _single(
    loops: Loops,
    nominal: Sequence[float],
    start: Pose,
    drives: Drives,
    moving: list[int],
    switch: bool,
    longest: float,
) -> Guess:
    place = moving[0] if moving else 0
    s = np.broadcast_to(drives.states[place], drives.shape) if drives.states else np.zeros(())
    if not moving:
        guide = Guide.of(Track([March(loops, nominal, _line(loops, place, 0.0), longest).node(0.0, start)]))
        return _from_array(guide.at(s), guide.signs_at(s, NEAR), np.ones(s.shape, dtype=bool))
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
    guess = _from_array(guide.at(within), guide.signs_at(within, NEAR), guide.reached(within))
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


# -- several drives: a way through all poses along the sweep -----------------------------------------------------------


def _several(
    loops: Loops, nominal: Sequence[float], start: Pose, drives: Drives, switch: bool, longest: float
) -> Guess:
    shape = drives.shape
    values = np.stack(np.broadcast_arrays(*drives.states), axis=-1)
    axis = next((k for k, size in enumerate(shape) if size > 1), None)
    lines = values[None] if axis is None else np.moveaxis(values, axis, 0)
    flat = lines.reshape(lines.shape[0], -1, values.shape[-1])
    drawn = np.array([loops.drawn[k] for k in loops.driven_states])
    states = np.empty((*flat.shape[:2], len(loops.mechanism.state_names)))
    signs = np.empty((*flat.shape[:2], len(loops.linear.determinants_of)))
    reached = np.empty(flat.shape[:2], dtype=bool)
    for line in range(flat.shape[1]):
        way = Path(loops, np.concatenate([drawn[None], _same_sign(loops, flat[:, line])]))
        guide = Guide.of(March(loops, nominal, way, longest).run(start, switch))
        s = np.array(way.corners[1:])
        states[:, line], signs[:, line], reached[:, line] = guide.at(s), guide.signs_at(s, NEAR), guide.reached(s)
    arrays = (x.reshape(*lines.shape[:-1], -1) for x in (states, signs, reached[..., None]))
    back = [x[0] if axis is None else np.moveaxis(x, 0, axis) for x in arrays]
    return _from_array(back[0], back[1], back[2][..., 0] > 0.0)


def _same_sign(loops: Loops, values: Array) -> Array:
    """Driven states along a way, with the Euler parameters of each ball of the sign nearest to the one before."""
    out = values.copy()
    for place in loops.driven_balls:
        k = loops.driven_states.index(place)
        previous = np.concatenate([[[1.0, 0.0, 0.0, 0.0]], out[:-1, k : k + 4]])
        turn = np.cumprod(np.where((previous * out[:, k : k + 4]).sum(axis=-1) < 0.0, -1.0, 1.0))
        out[:, k : k + 4] *= turn[:, None]
    return out
