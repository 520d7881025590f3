"""Poses in a change point, where the drive does not determine the pose: interpolated along the branch through it.

In a change point the equations are singular, and Newton's method finds a pose to half the digits at best. The branch
through the change point is smooth, so the polynomial through poses on both sides, each solved to rounding, gives the
pose to rounding as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.blocks import members_of, taken
from ..kinematics.loops import Loops
from ..kinematics.nearest import open_by
from ..kinematics.terms import Value
from .follow import Guide
from .guess import Guess
from .interpolation import weights
from .predictor_corrector import OPEN

Mask = NDArray[np.bool_]
# Spacing of the interpolated poses, their number on each side, and the distance up to which the polynomial is used.
STEP = 0.03
SIDE = 8
WITHIN = 0.025
EXACTLY = 1e-7
CLOSED = 1e-13
# Closing a pose near a crossing may move it by no more than this share of its distance from the crossing.
BESIDE = 0.05


@dataclass(frozen=True, eq=False)
class Patch:
    """Poses of a batch in one change point.

    Attributes
    ----------
    members
        Mask of the poses over the batch shape; M are True.
    follow, bend
        First and second derivative of each unknown velocity coordinate's integral by the drive, (M,) each.
    drive
        The drive that moves.
    """

    members: Mask
    follow: list[Array]
    bend: list[Array]
    drive: int

    def of(self, chosen: Mask) -> Patch:
        """The same patch in the batch of which the present one holds the `chosen` entries."""
        members = np.zeros(chosen.shape, dtype=bool)
        members[chosen] = self.members
        return replace(self, members=members)


def patched(
    loops: Loops, guess: Guess, parameters: Sequence[Value], state: list[Value], reached: Mask, sought: Mask
) -> tuple[list[Patch], Mask | None]:
    """Interpolate those of the poses `sought` that lie in change points of the only moving drive.

    Puts them into `state` and `reached`, and returns them. Where the branches cross only approximately, as those of a
    parallelogram with bars that are equal to eight digits, no pose may close exactly: the second result marks poses
    whose loops are left open by that much.
    """
    if guess.s is None or not guess.around:
        return [], None
    s, nearly = np.broadcast_to(guess.s, reached.shape), np.zeros(reached.shape, dtype=bool)
    out = []
    for where, guide in guess.around.items():
        chosen = np.asarray((np.abs(s - where) <= WITHIN) & sought)
        if guess.switched:
            # beyond the change point the path continues on the other branch
            chosen = np.asarray(chosen & (np.sign(where) * (s - where) <= EXACTLY))
        if chosen.any():
            around = _around(loops, guess, guide, parameters, where, s[chosen], chosen)
            if around is not None:
                patch = _patch(loops, around, state, reached, chosen)
                out += [patch] if patch is not None else []
                _nearly(loops, around, where, state, reached, nearly, chosen)
    return out, nearly


@dataclass(frozen=True, eq=False)
class Around:
    """Poses near a change point, interpolated from those on both sides of it.

    Attributes
    ----------
    parameters
        Dimensions of the poses, (M,).
    s
        Values of the drive, (M,).
    drive
        Index of the drive that moves.
    state
        Entries of the interpolated state, (M,).
    gap
        Closure error of the interpolated state, (M,).
    sure
        Whether all poses on both sides are closed, (M,).
    follow, bend
        As in `Patch`, for all velocity coordinates, (M,) each.
    """

    parameters: list[Value]
    s: Array
    drive: int
    state: list[Value]
    gap: Array
    sure: Mask
    follow: list[Array]
    bend: list[Array]


def _around(
    loops: Loops, guess: Guess, guide: Guide, parameters: Sequence[Value], where: float, s: Array, chosen: Mask
) -> Around | None:
    knots = where + STEP * np.array([k for k in range(-SIDE, SIDE + 1) if k])
    if not guide.reached(knots).all():
        return None
    own = members_of(parameters, chosen)
    around = guide.at(knots)
    begin: list[Value] = [around[:, k, None] for k in range(around.shape[1])]
    place = loops.driven_states[guess.drive]
    begin[place] = knots[:, None]
    closed = loops.close_all(loops.unit(begin), own)
    unit: list[Value] = [float(k == guess.drive) for k in range(len(loops.mechanism.driven))]
    follow = loops.velocities(closed.state, own, unit)
    bend = loops.accelerations(closed.state, own, follow, None)
    shares = weights(knots, s)
    count = shares.shape[1]

    def there(value: Value) -> Array:
        return np.asarray(np.einsum("km,km->m", shares, np.broadcast_to(value, (len(knots), count))))

    state: list[Value] = [there(x) for x in closed.state]
    state[place] = s
    loops.unit(state)
    sure = np.broadcast_to(closed.trusted, (len(knots), count)).all(axis=0)
    gap = open_by(loops, state, own)
    return Around(own, s, guess.drive, state, gap, np.asarray(sure), list(map(there, follow)), list(map(there, bend)))


def _patch(loops: Loops, around: Around, state: list[Value], reached: Mask, chosen: Mask) -> Patch | None:
    """The poses whose interpolated state closes the loops; they are stored in `state` and `reached`."""
    good = (around.gap < max(CLOSED, loops.tolerance)) & around.sure
    if not good.any():
        return None
    members = chosen.copy()
    members[chosen] = good
    for k in loops.unknown_states:
        np.asarray(state[k])[members] = np.asarray(around.state[k])[good]
    reached[members] = True
    unknown = loops.mechanism.unknown
    return Patch(
        members, [around.follow[k][good] for k in unknown], [around.bend[k][good] for k in unknown], around.drive
    )


def _nearly(
    loops: Loops, around: Around, where: float, state: list[Value], reached: Mask, nearly: Mask, chosen: Mask
) -> None:
    """Close the poses whose interpolated state closes only approximately, if that keeps them on their branch."""
    rest = ~(around.gap < max(CLOSED, loops.tolerance)) & around.sure & (around.gap < OPEN)
    if not rest.any():
        return
    begin = [np.asarray(x)[rest] for x in around.state]
    own = taken(around.parameters, rest)
    found = loops.close_all(list(begin), own)
    moved = np.max(np.abs(np.subtract(np.broadcast_arrays(*found.state), begin)), axis=0)
    closed = found.trusted & (moved < BESIDE * np.abs(around.s[rest] - where))
    members = chosen.copy()
    members[chosen] = rest
    for k in loops.unknown_states:
        np.asarray(state[k])[members] = np.where(closed, found.state[k], begin[k])
    reached[members] = True
    nearly[members] = ~closed
