"""The middle of where a journal may rest: of all minima of one energy, the farthest from the spheres.

Minima that share an energy differ by motions that no stiffness resists, and touch the same spheres with the same
forces. Which of them a search ends in is a matter of rounding; the one that maximises ``sum of log(1 - |x_j|²)`` over
the spheres that are not touched, their analytic centre, is a matter of the frame alone (Boyd and Vandenberghe, *Convex
Optimization*, 2004, sec. 8.5.3). Newton's method on this goes there from any place inside (sec. 9.6).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

# A stiffness against offsets below this share of the members' lets a journal move freely.
SOFT = 1e-12
# A ball's part in a motion, of length one in all, below which it has none; and the decrement that ends the steps.
_STILL, _ARRIVED = 1e-12, 1e-9
_STEPS = 100
# A place that is that of the middle of a ball but for rounding.
_NOTHING = 1e-14


def free_motions(stiffness: Array, members: Array, moving: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """Motions of the `moving` components by how little resists them.

    Parameters
    ----------
    stiffness
        Stiffness against offsets, (n, n, N).
    members
        The members' stiffness, (n, N), by which its softness is judged.
    moving
        Components that may move, (n, N).

    Returns
    -------
    motions, free
        Motions, each component times the root of the members' stiffness, of length one, (N, n, n) by column; and which
        of them are free, (N, n).
    """
    root = _roots(members)
    matrix = np.where(moving[:, None] & moving, stiffness / (root[:, None] * root), 0.0)
    each = np.arange(len(matrix))
    matrix[each, each] += np.where(moving, 0.0, 1.0)
    values, vectors = np.linalg.eigh(np.moveaxis(matrix, -1, 0))
    return vectors, np.asarray(values <= SOFT)


def in_the_middle(
    own: NDArray[np.int64], stiffness: Array, members: Array, x: Array, touched: NDArray[np.bool_], inside: Array
) -> Array:
    """Minima in the middle of those that share their energy, (n, N); as they are where there are no others.

    Parameters
    ----------
    own
        Ball of each component, (n,), ascending from 0.
    stiffness, members
        As for `free_motions`.
    x
        Minima, (n, N).
    touched
        Balls whose sphere bears a force, (balls, N).
    inside
        Places whose free motions lie inside the spheres, (n, N).
    """
    moving = ~touched[own]
    motions, free = free_motions(stiffness, members, moving)
    some = free.any(axis=-1)
    if not some.any():
        return x
    basis = motions[some] / _roots(members)[:, some].T[..., None] * (moving[:, some].T[..., None] & free[some][:, None])
    length = np.sqrt((basis * basis).sum(axis=1, keepdims=True))
    basis = basis / np.where(length > 0.0, length, 1.0)
    held = np.where(free[some], 0.0, 1.0)[:, None] * np.eye(len(own))
    start = x[:, some].T
    start = start + _along(basis, held, np.eye(len(own)), inside[:, some].T - start)
    same = own[:, None] == own
    taking = ((same @ np.abs(basis)).max(axis=-1) > _STILL)[..., None] & same
    found = _centred(basis, held, np.where(taking, 1.0, 0.0), start)
    out, found = x.copy(), np.where(np.isfinite(found).all(axis=-1, keepdims=True), found, x[:, some].T).T
    # what was nothing stays nothing, so that no rounding sets in motion what no load reaches
    out[:, some] = np.where((x[:, some] == 0.0) & (np.abs(found) <= _NOTHING), 0.0, found)
    return out


def _centred(basis: Array, held: Array, taking: Array, x: Array) -> Array:
    """The middle among places (N, n) that differ by motions of a basis (N, n, n), from the places x; NaN where these
    lie outside. `taking` is one for components of one ball that takes part, (N, n, n)."""
    for _ in range(_STEPS):
        part = np.diagonal(taking, axis1=-2, axis2=-1)
        room = 1.0 - (taking @ (x * x)[..., None])[..., 0]
        x = np.where((room > 0.0).all(axis=-1, keepdims=True), x, np.nan)
        pull = 2.0 * part * x / room
        curvature = pull[..., None] * pull[..., None, :] * taking + (2.0 * part / room)[..., None] * np.eye(x.shape[-1])
        step = _along(basis, held, curvature, -pull)
        decrement = np.sqrt(np.abs((pull * step).sum(axis=-1, keepdims=True)))
        going = decrement > _ARRIVED
        if not going.any():
            break
        x = x + np.where(going, step / np.where(decrement > 0.25, 1.0 + decrement, 1.0), 0.0)
    return x


def _along(basis: Array, held: Array, matrix: Array, force: Array) -> Array:
    """Displacement along motions of a basis under forces (N, n) against a stiffness (N, n, n)."""
    across = np.swapaxes(basis, -1, -2)
    found = np.linalg.solve(across @ matrix @ basis + held, across @ force[..., None])
    out: Array = (basis @ found)[..., 0]
    return out


def _roots(members: Array) -> Array:
    root = np.sqrt(members)
    return np.where(root > 0.0, root, 1.0)
