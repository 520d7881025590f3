"""Support function of deviations that keep overconstrained loops closed, by minimising a sum of lengths.

Deviations that open a redundant constraint are not possible. Over all e_b within their limits that keep the constraints
closed, ``sum S_b e_b = 0``, the largest ``sum a_b . e_b`` is ``min over m of sum |a_b + S_b^T m|``, by duality
(Rockafellar, *Convex Analysis*, 1970, section 28).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ....framework.batch import Array

# Smoothing of the lengths at the end, as a share of the whole: |v| is replaced by sqrt(v^2 + (share whole)^2); and
# number of steps, in which the smoothing decreases to it.
LEAST, STEPS = 1e-7, 30
# Shares of a Newton step that are tried.
DAMPED = (1.0, 0.3, 0.1, 0.02)
# Ratio to the largest singular value below which rows of redundant constraints count as dependent.
SAME = 1e-10


def least_lengths(along: Array, stress: Array, starts: Sequence[int], sizes: Sequence[int]) -> tuple[Array, Array]:
    """Vectors ``a + S^T m``, (..., n), with the least sum of lengths, and their smoothed lengths, (..., b).

    The multipliers m are found by weighted least squares (Weiszfeld) and by damped Newton steps, with a smoothing of
    the lengths that decreases from step to step.

    Parameters
    ----------
    along
        The b vectors a one after the other, (..., n).
    stress
        Rows S, (..., s, n).
    starts, sizes
        Index of the first component of each vector, and its number of components.
    """
    whole = np.sqrt(np.sum(along * along, axis=-1))[..., None]
    multipliers = np.zeros((*np.broadcast_shapes(along.shape[:-1], stress.shape[:-2]), stress.shape[-2]))
    # rows of unit norm keep the equations for the multipliers well scaled
    unit = np.linalg.norm(stress, axis=(-1, -2), keepdims=True)
    rows = stress / np.where(unit > 0.0, unit, 1.0)
    for step in range(STEPS):
        rounded = whole * max(LEAST, 0.1 * 0.5**step)
        found = along + _times(multipliers, rows)
        length = _rounded(found, starts, rounded)
        across = np.repeat(1.0 / np.where(length > 0.0, length, 1.0), sizes, axis=-1)
        slope = _sum(rows, found * across)
        best = _total(found, starts, rounded)
        squares = (rows * across[..., None, :]) @ np.swapaxes(rows, -1, -2)
        size = np.trace(squares, axis1=-2, axis2=-1)[..., None, None]
        for newton in (False, True):
            matrix = squares
            if newton:
                pulled = np.add.reduceat(rows * (found * across)[..., None, :], starts, axis=-1)
                weight = 1.0 / np.where(length > 0.0, length, 1.0)
                matrix = squares - (pulled * weight[..., None, :]) @ np.swapaxes(pulled, -1, -2)
            move = _solved(matrix, size, slope)
            here = multipliers
            for share in DAMPED if newton else DAMPED[:1]:
                tried = here - share * move
                total = _total(along + _times(tried, rows), starts, rounded)
                better = total < best
                multipliers, best = np.where(better[..., None], tried, multipliers), np.where(better, total, best)
    found = along + _times(multipliers, rows)
    return found, _rounded(found, starts, whole * LEAST)


def kept_closed(columns: Array, stress: Array) -> Array:
    """Columns (..., 3, n) projected on the deviations that open no redundant constraint.

    Parameters
    ----------
    columns
        Displacement or rotation by each deviation, (..., 3, n).
    stress
        Gap in each redundant constraint by each deviation, (..., s, n).
    """
    good = np.isfinite(np.sum(columns, axis=(-1, -2), keepdims=True) + np.sum(stress, axis=(-1, -2), keepdims=True))
    unit = np.linalg.norm(stress, axis=(-1, -2), keepdims=True)
    rows = np.where(good & (unit > 0.0), stress / np.where(unit > 0.0, unit, 1.0), 0.0)
    return np.asarray(columns - columns @ np.linalg.pinv(rows, rcond=SAME) @ rows)


def _times(multipliers: Array, rows: Array) -> Array:
    return np.asarray((multipliers[..., None, :] @ rows)[..., 0, :])


def _sum(rows: Array, vector: Array) -> Array:
    return np.asarray((rows @ vector[..., None])[..., 0])


def _rounded(vectors: Array, starts: Sequence[int], rounded: Array) -> Array:
    return np.asarray(np.sqrt(np.add.reduceat(vectors * vectors, starts, axis=-1) + rounded * rounded))


def _total(vectors: Array, starts: Sequence[int], rounded: Array) -> Array:
    return np.asarray(np.sum(_rounded(vectors, starts, rounded), axis=-1))


def _solved(matrix: Array, size: Array, right: Array) -> Array:
    """Steps of the multipliers, (..., s), of a matrix that may be singular.

    It is shifted by rounding of its trace `size` before the Newton correction, or by 1 if that is zero.
    """
    shifted = matrix + (1e-13 * size + (size == 0.0)) * np.eye(matrix.shape[-1])
    return np.asarray(np.linalg.solve(shifted, right[..., None])[..., 0])
