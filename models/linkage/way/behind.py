"""Behind a gap in the drives' range, where no way leads: the linkage put together anew, the way that it was drawn."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....framework.batch import Array
from ..kinematics.loops import Loops, Pose
from ..kinematics.nearest import nearest
from ..kinematics.tape import Value
from .march import flips

# How many poses are tried, from how many positions beside the drawing, and how far these are from it.
POSES, TRIES, FAR = 24, 8, 2.0
CLOSED = 1e-9


def put_together(loops: Loops, nominal: Sequence[float], start: Pose, values: Array) -> tuple[int, Pose] | None:
    """The first of the driven states (poses, f) at which the linkage can be put together as drawn, and its pose there.

    As drawn means determinants of the same signs, which tell the open configuration of a four-bar from the crossed one.
    Some poses, evenly spread, are tried, from the drawing and from positions at random around it.
    """
    if not len(values) or not loops.linear.signs or loops.driven_balls:
        return None
    tried = np.unique(np.linspace(0, len(values) - 1, min(POSES, len(values))).astype(int))
    steps = FAR * np.random.default_rng(0).uniform(-1.0, 1.0, (TRIES, 1, loops.columns))
    steps[0] = 0.0
    shape = TRIES, len(tried)
    drawn: list[Value] = [np.full(shape, x) for x in start.state]
    begin = loops.advance(drawn, [np.broadcast_to(step, shape) for step in np.moveaxis(steps, -1, 0)])
    for place, value in zip(loops.driven_states, values[tried].T, strict=True):
        begin[place] = np.broadcast_to(value, shape)
    found, gap = nearest(loops, [np.ravel(x) for x in begin], nominal)
    states = np.stack(np.broadcast_arrays(*found), axis=-1).reshape(*shape, -1)
    for k, t in np.argwhere((gap.reshape(shape) < max(CLOSED, loops.tolerance)).T):
        pose = loops.close(states[t, k].tolist(), nominal)
        if pose is not None and not flips(start, pose):
            return int(tried[k]), pose
    return None
