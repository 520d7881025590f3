"""Many poses in no order: all at once straight from the drawing, then each from the one before, to see that they agree.

A way through thousands of scattered poses is long. Where every pose is reached on the straight line from the drawing,
and every step of the way leads from one of these to the next, the way itself need not be gone.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import blocks, cut_all
from ..kinematics.loops import Loops, Pose
from ..kinematics.tape import Value
from .march import LONGEST
from .path import Path

# A way with fewer poses, or with fewer sharp corners among them, is gone step by step.
POSES = 100
SHARP = 0.3
AGREE = 1e-8
# Steps that are in doubt are cut finer, then gone one by one; if these are too many, so is the way.
FINER = (1, 4)
MANY = 0.1


def scattered(way: Path) -> bool:
    """True where a way is long and has many sharp corners."""
    corners = way.corners
    sharp = sum(way.stop(a, b + (b - a)) == b for a, b in pairwise(corners[:-1]) if b > a)
    return len(corners) > POSES and sharp > SHARP * len(corners)


def fanned(
    loops: Loops, nominal: Sequence[float], start: Pose, values: Array, go: Callable[[Pose, Array], Pose | None]
) -> tuple[Array, Array] | None:
    """States (poses, n) and signs (poses, blocks) at driven states (poses, f); None where the way must be gone.

    `go` goes straight from a pose to driven states, step by step, where a step of the way is in doubt.
    """
    drawn = np.array(start.state)
    states, signs, _ = straight(loops, nominal, np.broadcast_to(drawn, (len(values), len(drawn))), values, 1)
    before = np.concatenate([drawn[None], states[:-1]])
    doubtful = np.arange(len(values))
    for finer in FINER:
        found, at, sure = straight(loops, nominal, before[doubtful], values[doubtful], finer)
        away = np.abs(found - states[doubtful]).max(axis=-1)
        same = np.all(at == signs[doubtful], axis=-1) & (away < AGREE)
        doubtful = doubtful[~(sure & same)]
        if not doubtful.size:
            return states, signs
    if doubtful.size > MANY * len(values):
        return None
    return (states, signs) if _bear_out(loops, nominal, states, before, values, doubtful, go) else None


def _bear_out(
    loops: Loops,
    nominal: Sequence[float],
    states: Array,
    before: Array,
    values: Array,
    doubtful: NDArray[np.intp],
    go: Callable[[Pose, Array], Pose | None],
) -> bool:
    """True where each doubtful step, gone step by step, leads to the pose that is there."""
    for k in doubtful:
        begin = loops.close(before[k].tolist(), nominal)
        end = begin and go(begin, values[k])
        if end is None or np.abs(np.subtract(end.state, states[k])).max() > AGREE:
            return False
    return True


def straight(
    loops: Loops, parameters: Sequence[Value], begin: Array, values: Array, finer: int
) -> tuple[Array, Array, NDArray[np.bool_]]:
    """States after the drives have gone straight to `values`, their signs, and where they can be trusted."""
    states, sure = np.empty_like(begin), np.empty(len(begin), dtype=bool)
    signs = np.empty((len(begin), loops.linear.signs))
    first = begin[:, loops.driven_states]
    for (block,) in blocks((len(begin),), 1024):
        way, own = values[block] - first[block], cut_all(parameters, (block,))
        count = finer * (int(np.ceil(np.abs(way).max(initial=0.0) / LONGEST)) + 2)
        now: list[Value] = list(begin[block].T.copy())
        before, steps = now, []
        good = np.ones(len(way), dtype=bool)
        for t in np.arange(1, count + 1) / count:
            ahead = [2.0 * x - y for x, y in zip(now, before, strict=True)]
            for k, place in enumerate(loops.driven_states):
                ahead[place] = first[block, k] + t * way[:, k]
            closed = loops.close_all(loops.unit(ahead), own)
            good &= closed.trusted
            steps.append(np.sign(np.stack(closed.determinants, axis=-1)))
            before, now = now, closed.state
        states[block], signs[block] = np.stack(now, axis=-1), steps[-1]
        sure[block] = good & np.all(np.equal(steps, steps[0]), axis=(0, -1))
    return states, signs, sure
