"""The analytic centre of all minima, where journals are free to move within their clearances.

Minima of equal energy differ by motions that no stiffness resists, and have the same active spheres with the same
forces. Which of them a search finds depends on rounding; the one that maximises ``sum of log(1 - |x_j|²)`` over the
inactive spheres, their analytic centre, depends on the frame alone (Boyd and Vandenberghe, *Convex Optimization*, 2004,
sec. 8.5.3). Newton's method converges to it from any interior point (sec. 9.6).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

# A stiffness against offsets below this share of that of the members counts as zero.
SOFT = 1e-12
# A ball whose part of a motion of length one is smaller does not take part in it; the Newton decrement at the end.
_STILL, _ARRIVED = 1e-12, 1e-9
_STEPS = 100
# An offset of this size is zero but for rounding.
_NOTHING = 1e-14


def free_motions(stiffness: Array, members: Array, moving: NDArray[np.bool_]) -> tuple[Array, NDArray[np.bool_]]:
    """Principal motions of the components that may move, and which of them no stiffness resists.

    Parameters
    ----------
    stiffness
        Stiffness against offsets, (n, n, N).
    members
        Stiffness of the members, (n, N), with which the former is compared.
    moving
        Mask of the components that may move, (n, N).

    Returns
    -------
    motions, free
        Motions as columns, (N, n, n), of length one, each component being scaled by the square root of the members'
        stiffness; and a mask of those that are free, (N, n).
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
    """Centres of all minima with the same energy, (n, N); the minima themselves where they are unique.

    Parameters
    ----------
    own
        Ball of each component, (n,), ascending from 0.
    stiffness, members
        As for `free_motions`.
    x
        Minima, (n, N).
    touched
        Mask of the balls whose sphere is active, (balls, N).
    inside
        Interior points from which to start along the free motions, (n, N).
    """
    moving = ~touched[own]
    motions, free = free_motions(stiffness, members, moving)
    some = free.any(axis=-1)
    if not some.any():
        return x
    basis = motions[some] / _roots(members)[:, some].T[..., None] * (moving[:, some].T[..., None] & free[some][:, None])
    length = np.sqrt((basis * basis).sum(axis=1, keepdims=True))
    basis = basis / np.where(length > 0.0, length, 1.0)
    constrained = np.where(free[some], 0.0, 1.0)[:, None] * np.eye(len(own))
    start = x[:, some].T
    start = start + _along(basis, constrained, np.eye(len(own)), inside[:, some].T - start)
    same = own[:, None] == own
    taking = ((same @ np.abs(basis)).max(axis=-1) > _STILL)[..., None] & same
    found = _centred(basis, constrained, np.where(taking, 1.0, 0.0), start)
    out, found = x.copy(), np.where(np.isfinite(found).all(axis=-1, keepdims=True), found, x[:, some].T).T
    # offsets that are zero stay zero, so that rounding does not move unloaded joints
    out[:, some] = np.where((x[:, some] == 0.0) & (np.abs(found) <= _NOTHING), 0.0, found)
    return out


def _centred(basis: Array, constrained: Array, taking: Array, x: Array) -> Array:
    """The analytic centre among points (N, n) that differ by motions of a basis (N, n, n), starting from x.

    NaN where x is outside. `taking` is one for pairs of components of the same ball that takes part, (N, n, n).
    """
    for _ in range(_STEPS):
        part = np.diagonal(taking, axis1=-2, axis2=-1)
        room = 1.0 - (taking @ (x * x)[..., None])[..., 0]
        x = np.where((room > 0.0).all(axis=-1, keepdims=True), x, np.nan)
        gradient = 2.0 * part * x / room
        curvature = gradient[..., None] * gradient[..., None, :] * taking + (2.0 * part / room)[..., None] * np.eye(
            x.shape[-1]
        )
        step = _along(basis, constrained, curvature, -gradient)
        decrement = np.sqrt(np.abs((gradient * step).sum(axis=-1, keepdims=True)))
        going = decrement > _ARRIVED
        if not going.any():
            break
        x = x + np.where(going, step / np.where(decrement > 0.25, 1.0 + decrement, 1.0), 0.0)
    return x


def _along(basis: Array, constrained: Array, matrix: Array, force: Array) -> Array:
    """Displacement along motions of a basis under forces (N, n) against a stiffness (N, n, n)."""
    across = np.swapaxes(basis, -1, -2)
    found = np.linalg.solve(across @ matrix @ basis + constrained, across @ force[..., None])
    out: Array = (basis @ found)[..., 0]
    return out


def _roots(members: Array) -> Array:
    root = np.sqrt(members)
    return np.where(root > 0.0, root, 1.0)
