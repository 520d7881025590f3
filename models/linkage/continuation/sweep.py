"""Long sweeps of one drive by machine code: what `one_pose` does for one pose, for all at once.

Poses in and near change points and dead points, many turns away, or that Newton's method does not reach from the nodes
of the path, are left to the closer search of `assemble`; of several drives also those at which none has moved.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ..kinematics.closed_poses import Pose
from ..kinematics.loops import Loops
from ..kinematics.terms import Value
from .follow import Guide
from .one_pose import ASIDE, STILL
from .single_drive import MANY, SingleDrive


@dataclass(frozen=True, eq=False)
class Swept:
    """Poses of a long sweep.

    Attributes
    ----------
    state
        Entries of the state, (...).
    good
        Whether each pose is found, (...).
    error
        Closure errors, (...), in units of the mechanism's size.
    reason
        Why machine code was chosen, in words.
    """

    state: list[Value]
    good: NDArray[np.bool_]
    error: Array
    reason: str


def swept(
    loops: Loops,
    parameters: Sequence[float],
    start: Pose,
    drive: int,
    driven: Sequence[Array],
    shape: Shape,
    closed: float,
) -> Swept | None:
    """Poses at driven states of which only one moves; None where machine code does not pay or cannot be used.

    Parameters
    ----------
    loops
        The loops.
    parameters, start
        Dimensions and reference configuration.
    drive
        Index of the driven state that moves.
    driven
        The driven states, which broadcast.
    shape
        Their shape.
    closed
        Closure error below which poses count as closed.
    """
    if not loops.columns:
        return None
    written = loops.closing.sweep()
    if written is None:
        return None
    s = driven[drive] - start.state[loops.driven_states[drive]]
    single = SingleDrive(loops, parameters, start, drive, switch=False)
    guide = single.guide_over(max(float(s.min()), -MANY), min(float(s.max()), MANY))
    if len(guide.s) < 2:
        return None
    state: list[Value] = [0.0] * len(start.state)
    for place, value in zip(loops.driven_states, driven, strict=True):
        state[place] = value
    nodes, columns = table(guide, loops.unknown_states)
    made = written.run([state, parameters, loops.closing.shares, [s, closed, nodes, *columns]], shape)
    if made is None:
        return None
    (unknown, (good,), (error,)), reason = made
    if len(driven) > 1:
        good &= np.abs(s) > STILL
    for place, x in zip(loops.unknown_states, unknown, strict=True):
        state[place] = x
    return Swept(state, good, error, reason)


def table(guide: Guide, unknown: Sequence[int]) -> tuple[Array, list[Array]]:
    """The path as a table of pieces, each with the data of its interpolation.

    Parameters
    ----------
    guide
        The path.
    unknown
        Indices of the unknown entries of the state.

    Returns
    -------
    nodes
        Ends of the pieces, from -inf to inf, (pieces + 1,).
    columns
        For each piece, (pieces,): whether it is off all change points; length at its node, and distance of the next
        node; for each unknown entry state and rate at the node and at the next; the signs of the determinants.
    """
    crossings = guide.crossings
    ends = np.clip([guide.low, guide.high], -MANY, MANY)
    inside = np.concatenate([guide.s, crossings, crossings - ASIDE, crossings + ASIDE, ends])
    nodes = np.unique(inside[(inside >= ends[0]) & (inside <= ends[1])])
    middle = 0.5 * (nodes[1:] + nodes[:-1])
    k = guide.before(middle)
    plain = np.abs(middle[:, None] - crossings).min(axis=1, initial=np.inf) > ASIDE
    columns = [plain.astype(np.float64), guide.s[k], guide.s[k + 1] - guide.s[k]]
    for place in unknown:
        states, rates = guide.states[:, place], guide.rates[:, place]
        columns += [states[k], rates[k], states[k + 1], rates[k + 1]]
    columns += guide.signs_at(middle, 0.0)
    outside = [(0.0, 0.0)] * 2 + [(1.0, 1.0)] + [(0.0, 0.0)] * (len(columns) - 3)
    whole = [np.concatenate([[a], x, [b]]) for x, (a, b) in zip(columns, outside, strict=True)]
    return np.concatenate([[-np.inf], nodes, [np.inf]]), whole
