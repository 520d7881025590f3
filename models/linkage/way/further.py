"""Members of a batch whose own dimensions let them reach further than the member in the middle, which leads them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import Block, cut
from ..kinematics.loops import Loops
from ..kinematics.tape import Value
from .fan import straight
from .guess import Guess

Mask = NDArray[np.bool_]
TURN = 2.0 * np.pi
# How far from the end of its way the leader is left, and how far beyond that end members are looked for.
BACK, FAR = 0.15, 0.6
# In so many steps a member takes its own dimensions, and so fine are those of the drive then.
STEPS = 4


def further(
    loops: Loops, guess: Guess, block: Block, left: Mask, parameters: Sequence[Value], nominal: Sequence[float]
) -> tuple[Mask, Array]:
    """Which of the members of a block that are left close beyond the end of the leader's way, and their states (k, n).

    Before that end each takes its own dimensions, then the drive goes on straight.
    """
    shape, guide, none = left.shape, guess.guide, np.empty((0, len(guess.state)))
    if guide is None or not loops.linear.signs or not any(np.ndim(x) for x in parameters):
        return np.zeros(shape, dtype=bool), none
    place = loops.driven_states[guess.drive]
    given = np.broadcast_to(np.asarray(cut(guess.state[place], block)), shape)
    turns = np.round((given - 0.5 * (guide.low + guide.high)) / TURN) if loops.turns(guess.drive) else 0.0
    s = given - TURN * turns
    beyond = np.maximum(s - guide.high, guide.low - s)
    chosen = np.asarray(left & (beyond > 0.0) & (beyond < FAR))
    if not chosen.any():
        return chosen, none
    aims = np.asarray(s[chosen])
    edge = np.clip(aims, min(guide.low + BACK, 0.0), max(guide.high - BACK, 0.0))
    state: list[Value] = list(np.moveaxis(guide.at(edge), -1, 0).copy())
    state[place] = edge
    own = [np.broadcast_to(x, shape)[chosen] if np.ndim(x) else x for x in parameters]
    sure = np.ones(edge.shape, dtype=bool)
    for t in np.arange(1, STEPS + 1) / STEPS:
        step = loops.close_all(loops.unit(state), [p + t * (q - p) for p, q in zip(nominal, own, strict=True)])
        state, sure = step.state, sure & step.trusted
    begin = np.stack([np.broadcast_to(x, edge.shape) for x in state], axis=-1)
    values = begin[:, loops.driven_states]
    values[:, guess.drive] = aims
    ends, signs, led = straight(loops, own, begin, values, STEPS)
    good = sure & led & np.all(np.multiply(signs, guide.signs_at(edge, 0.0)) > 0.0, axis=-1)
    ends[:, place] = given[chosen]
    chosen[chosen] = good
    return chosen, ends[good]
