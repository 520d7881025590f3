"""Which way to each pose, and the first guess there."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....framework.batch import Shape
from ..kinematics.loops import Loops, Pose
from .drives import Drives
from .guess import NEAR, Guess, guess_of
from .march import LONGEST
from .several_drives import through_poses
from .single_drive import SingleDrive

# Refinements of the longest step where the poses in between do not bear out the nodes.
FINER = (1.0, 0.2, 0.04)


def guesses(loops: Loops, nominal: Sequence[float], start: Pose, drives: Drives, switch: bool) -> Guess:
    """States of the nominal linkage at all values of the drives, solved and borne out, or the last before them."""
    drawn = [loops.drawn[place] for place in loops.driven_states]
    moving = [k for k, x in enumerate(drives.states) if np.any(x != drawn[k])]
    for finer in FINER:
        if not moving:
            guess = _drawing(loops, start, drives.shape)
        elif len(moving) == 1 and not loops.driven_balls:
            s = np.broadcast_to(drives.states[moving[0]], drives.shape)
            guess = SingleDrive(loops, nominal, start, moving[0], switch, LONGEST * finer).guess(s)
        else:
            guess = through_poses(loops, nominal, start, drives, switch, LONGEST * finer)
        if _borne_out(loops, guess, nominal, drives):
            break
    return guess


def _drawing(loops: Loops, start: Pose, shape: Shape) -> Guess:
    states = np.broadcast_to(np.array(start.state), (*shape, len(start.state)))
    signs = np.broadcast_to(np.sign(start.determinants), (*shape, len(start.determinants)))
    return guess_of(states, signs, np.ones(shape, dtype=bool))


def _borne_out(loops: Loops, guess: Guess, nominal: Sequence[float], drives: Drives) -> bool:
    """Close the nominal poses; True where all are trusted and of the sign that they should have."""
    _drive(loops, guess, drives)
    found = loops.close_all(list(guess.state), nominal)
    good = np.asarray(found.trusted)
    for determinant, sign in zip(found.determinants, guess.signs, strict=True):
        good = good & (np.asarray(determinant) * sign >= 0.0)
    if good.all() and guess.reached.all():
        for place in loops.unknown_states:
            guess.state[place] = np.array(np.broadcast_to(found.state[place], good.shape))
        guess.closed = True
        return True
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
