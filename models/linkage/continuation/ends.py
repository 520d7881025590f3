"""Poses in dead points, where the path of the drives ends."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import taken
from ..kinematics.loops import Loops
from ..kinematics.nearest import nearest
from ..kinematics.terms import Value

# Largest distance, in radians and mechanism sizes, of a path's last node from the dead point in which it ends, and of
# the states of the two.
SHORT, AWAY = 1e-6, 1e-2
CLOSED = 1e-13


def at_dead_points(
    loops: Loops,
    parameters: Sequence[Value],
    states: Array,
    reached: NDArray[np.bool_],
    left: Array,
    targets: Array,
) -> None:
    """Close the poses just beyond the last one that Newton's method reaches.

    Near a dead point the equations are singular and each step of Newton's method halves the gap at best, so the gap is
    minimised instead. Results go into `states` (n, poses) and `reached` (poses,); `left` (poses,) is the distance from
    the states to the driven states `targets`, (f, poses).
    """
    chosen = np.flatnonzero(~reached & (left < SHORT))
    if not chosen.size:
        return
    begin = states[:, chosen]
    begin[loops.driven_states] = targets[:, chosen]
    there, good = _nearest(loops, taken(parameters, chosen), begin)
    states[:, chosen[good]] = there[:, good]
    reached[chosen[good]] = True


def sharpened(loops: Loops, parameters: Sequence[Value], states: Array, chosen: NDArray[np.bool_]) -> None:
    """Improve the chosen poses near dead points to rounding.

    There the gap grows as the square of the error, so a pose with a small gap may still be inaccurate. Improved states
    go into `states`, (n, poses).
    """
    places = np.flatnonzero(chosen)
    if places.size:
        there, good = _nearest(loops, taken(parameters, places), states[:, places])
        states[:, places[good]] = there[:, good]


def _nearest(loops: Loops, parameters: Sequence[Value], begin: Array) -> tuple[Array, NDArray[np.bool_]]:
    """States (n, k) with the least gap near `begin`, and which of them close there."""
    found, gap = nearest(loops, loops.unit(list(begin)), parameters)
    there = np.stack(np.broadcast_arrays(*found))
    return there, (gap < max(CLOSED, loops.tolerance)) & (np.abs(there - begin).max(axis=0) < AWAY)
