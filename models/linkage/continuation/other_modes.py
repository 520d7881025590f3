"""Poses that no path reaches: another assembly mode is sought, or the least gap."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import taken
from ..kinematics.loops import Loops
from ..kinematics.nearest import nearest, open_by, widest
from ..kinematics.terms import Value

# Number of starting states near the reference configuration, and their distance from it.
TRIES, FAR = 8, 2.0
# From how many more where a screw may have to make many turns: few of them lead to the one at which the loop closes.
TURNED = 64
CLOSED = 1e-12
# Number of poses that are tried together.
TOGETHER = 512


def least_gaps(
    loops: Loops, parameters: Sequence[Value], begin: Array, *, alike: bool
) -> tuple[Array, Array, NDArray[np.intp]]:
    """States (n, poses) that close the loops, or have the least gap found; that gap, (poses,), and its largest row.

    Each pose is tried from `begin`, the last on the path to it, from the reference configuration and from positions
    at random around that, screws many turns away among them. Of those that close, the first is taken; if it is to be
    `alike`, the first whose determinants have the signs that they have in the reference configuration, as far as there
    is one: they tell the open configuration of a four-bar from the crossed one.
    """
    states, error = begin.copy(), np.empty(begin.shape[1])
    row = np.empty(begin.shape[1], dtype=np.intp)
    for first in range(0, begin.shape[1], TOGETHER):
        part = slice(first, first + TOGETHER)
        own = taken(parameters, part)
        states[:, part] = _best(loops, own, begin[:, part], 0.0 if alike else 1.0)
        found = list(states[:, part])
        error[part], row[part] = open_by(loops, found, own), widest(loops, found, own)
    return states, error, row


def _best(loops: Loops, parameters: Sequence[Value], begin: Array, enough: float) -> Array:
    """The state of least rank for each pose: 0 or 1 where it closes, with the same signs or not, more by its gap."""
    count = begin.shape[1]
    signs = _signs(loops)
    best, best_rank = begin.copy(), np.full(count, np.inf)
    for trial in _trials(loops, begin):
        left = np.flatnonzero(best_rank > enough)
        if not left.size:
            break
        own = taken(parameters, left)
        found, gap = nearest(loops, loops.unit(list(trial[:, left])), own)
        there = np.stack(np.broadcast_arrays(*found))
        rank = np.where(gap < max(CLOSED, loops.tolerance), _other_side(loops, there, own, signs), 2.0 + gap)
        better = rank < best_rank[left] * (1.0 - 1e-6)
        best[:, left[better]], best_rank[left[better]] = there[:, better], rank[better]
    return best


def _trials(loops: Loops, begin: Array) -> list[Array]:
    """Starting states with the given drives: the last on the path, the reference configuration, and some near it."""
    reference_state: list[Value] = [np.full(begin.shape[1], x) for x in loops.reference_state]
    turns = _turns(loops)
    count = TRIES if turns is None else TRIES + TURNED
    steps = FAR * np.random.default_rng(0).uniform(-1.0, 1.0, (count, loops.columns))
    steps[0] = 0.0
    if turns is not None:
        steps[TRIES:] *= turns
    out = [begin, *(np.stack(np.broadcast_arrays(*loops.advance(reference_state, step.tolist()))) for step in steps)]
    for trial in out[1:]:
        trial[loops.driven_states] = begin[loops.driven_states]
    return out


def _turns(loops: Loops) -> Array | None:
    """By how much farther screws turn than other joints, to travel as far as those, (columns,); None without any."""
    mechanism, out = loops.mechanism, np.ones(loops.columns)
    for name, those in mechanism.velocities.items():
        pitch = mechanism.linkage.joints[name].pitch
        if pitch is not None and np.any(pitch) and those.start in mechanism.unknown:
            size = 2.0 * np.pi * float(np.max(mechanism.size)) / np.abs(pitch).max()
            out[mechanism.unknown.index(those.start)] = max(size, 1.0)
    return out if np.any(out > 1.0) else None


def _signs(loops: Loops) -> Array:
    assert loops.mechanism.begun is not None
    signs: Array = np.sign(loops.mechanism.begun[2].determinants)
    return signs


def _other_side(loops: Loops, states: Array, parameters: Sequence[Value], signs: Array) -> Array:
    """0 where all determinants have the signs of the reference configuration, else 1, (poses,)."""
    determinants = loops.poses(list(states), parameters).determinants
    other = np.zeros(states.shape[1], dtype=bool)
    for determinant, sign in zip(determinants, signs, strict=True):
        other |= np.asarray(determinant) * sign < 0.0
    return other.astype(np.float64)
