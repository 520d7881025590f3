"""Poses in a change point, where the drive says nothing: taken from the branch on both sides.

In a change point the equations are singular and Newton's method finds a pose to half the digits at best. The branch
that passes through is smooth, so that the polynomial through poses around it, each solved to rounding, gives it to
rounding as well.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from ..kinematics.loops import Loops
from ..kinematics.nearest import open_by
from ..kinematics.tape import Value
from .follow import Guide
from .guess import Guess

if TYPE_CHECKING:
    from .assemble import Assembly

# Distance of the poses through which the polynomial goes, how many there are on each side, and where it is used.
STEP = 0.03
SIDE = 8
WITHIN = 0.025
EXACTLY = 1e-7
CLOSED = 1e-13


@dataclass(frozen=True, eq=False)
class Patch:
    """Poses of a batch in one change point.

    Attributes
    ----------
    members
        Which they are, over the batch shape; M in number.
    follow, bend
        First and second derivative of each unknown velocity coordinate's integral by the drive, (M,) each.
    drive
        The drive that moves.
    """

    members: NDArray[np.bool_]
    follow: list[Array]
    bend: list[Array]
    drive: int


def patched(loops: Loops, guess: Guess, parameters: Sequence[Value], found: Assembly) -> list[Patch]:
    """Put right the poses of `found` that lie in change points of the only moving drive."""
    if guess.s is None:
        return []
    s = np.broadcast_to(guess.s, found.shape)
    out = []
    for where, guide in guess.around.items():
        chosen = np.asarray(np.abs(s - where) <= WITHIN)
        if guess.switched:
            # beyond it, the way goes on along the other branch
            chosen = np.asarray(chosen & (np.sign(where) * (s - where) <= EXACTLY))
        if chosen.any():
            patch = _patch(loops, guess, guide, parameters, found, where, chosen)
            if patch is not None:
                out.append(patch)
    return out


def _patch(
    loops: Loops,
    guess: Guess,
    guide: Guide,
    parameters: Sequence[Value],
    found: Assembly,
    where: float,
    chosen: NDArray[np.bool_],
) -> Patch | None:
    assert guess.s is not None
    shape = found.shape
    knots = where + STEP * np.array([k for k in range(-SIDE, SIDE + 1) if k])
    if not guide.reached(knots).all():
        return None
    own = [np.broadcast_to(x, shape)[chosen] for x in parameters]
    s = np.broadcast_to(guess.s, shape)[chosen]
    around = guide.at(knots)
    begin: list[Value] = [around[:, k, None] for k in range(around.shape[1])]
    place = loops.driven_states[guess.drive]
    begin[place] = knots[:, None]
    closed = loops.close_all(loops.unit(begin), own)
    unit: list[Value] = [float(k == guess.drive) for k in range(len(loops.mechanism.driven))]
    follow = loops.velocities(closed.state, own, unit)
    bend = loops.accelerations(closed.state, own, follow, None)
    weights = _weights(knots, s)
    count = weights.shape[1]

    def there(value: Value) -> Array:
        return np.asarray(np.einsum("km,km->m", weights, np.broadcast_to(value, (len(knots), count))))

    state: list[Value] = [there(x) for x in closed.state]
    state[place] = s
    loops.unit(state)
    good = (open_by(loops, state, own)[0] < max(CLOSED, loops.tolerance)) & closed.trusted.all(axis=0)
    if not good.any():
        return None
    members = chosen.copy()
    members[chosen] = good
    for k in loops.unknown_states:
        np.asarray(found.state[k])[members] = np.asarray(state[k])[good]
    found.closed[members] = found.verified[members] = True
    unknown = loops.mechanism.unknown
    return Patch(
        members, [there(follow[k])[good] for k in unknown], [there(bend[k])[good] for k in unknown], guess.drive
    )


def _weights(knots: Array, s: Array) -> Array:
    """Value at s (M,) of the polynomial that is 1 at one knot and 0 at the others, (knots, M)."""
    out = np.ones((len(knots), len(s)))
    for j, knot in enumerate(knots):
        for k, other in enumerate(knots):
            if k != j:
                out[j] *= (s - other) / (knot - other)
    return out
