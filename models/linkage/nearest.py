"""How far a loop is open, and where it is open least."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...framework.batch import Array
from .linear import matrices
from .loops import Loops
from .tape import Value

ITERATIONS = 80


def open_by(loops: Loops, state: Sequence[Value], parameters: Sequence[Value]) -> tuple[Array, NDArray[np.intp]]:
    """Norm of all closing residuals, angles times size, in units of size; and the row with the largest."""
    rows = loops.mechanism.residual[1](state, parameters)
    shape = np.broadcast_shapes(*(np.shape(x) for x in (*state, *parameters)))
    square, largest, which = np.zeros(shape), np.zeros(shape), np.zeros(shape, dtype=np.intp)
    for index, row in enumerate(rows):
        size = np.abs(row)
        square = square + size * size
        which = np.where(size > largest, index, which)
        largest = np.maximum(largest, size)
    return np.sqrt(square), which


def nearest(
    loops: Loops, state: Sequence[Value], parameters: Sequence[Value], *, free: bool = False
) -> tuple[list[Value], Array]:
    """States (M,) with the least gap near `state`, and that gap: Levenberg and Marquardt's method.

    With `free`, the drives are free as well; that takes a mechanism without driven balls.
    """
    m, n = loops.rows, loops.columns + (len(loops.mechanism.driven) if free else 0)
    current: list[Value] = [np.array(x, dtype=np.float64) for x in np.broadcast_arrays(*state)]
    count = np.shape(current[0]) if current else ()
    damping = np.full(count, 1e-4)
    residual, jacobian = _evaluated(loops, current, parameters, free)
    norm = np.sqrt((residual**2).sum(axis=-1))
    for _ in range(ITERATIONS if m and n else 0):
        turned = np.swapaxes(jacobian, -1, -2)
        normal = turned @ jacobian + damping[..., None, None] * np.eye(n)
        step: Array = np.asarray(-np.linalg.solve(normal, turned @ residual[..., None])[..., 0], dtype=np.float64)
        trial = loops.advance(current, [step[..., k] for k in range(loops.columns)])
        if free:
            for k, place in enumerate(loops.driven_states):
                trial[place] = trial[place] + step[..., loops.columns + k]
        new_residual, new_jacobian = _evaluated(loops, trial, parameters, free)
        new_norm = np.sqrt((new_residual**2).sum(axis=-1))
        better = new_norm < norm
        damping = np.clip(np.where(better, 0.1 * damping, 4.0 * damping), 1e-15, 1e6)
        current = [np.where(better, x, y) for x, y in zip(trial, current, strict=True)]
        residual = np.where(better[..., None], new_residual, residual)
        jacobian = np.where(better[..., None, None], new_jacobian, jacobian)
        norm = np.where(better, new_norm, norm)
        if np.all((norm < 1e-16) | (damping >= 1e6) | (np.abs(step).max(axis=-1) < 1e-15)):
            break
    return current, open_by(loops, current, parameters)[0]


def _evaluated(loops: Loops, state: Sequence[Value], parameters: Sequence[Value], free: bool) -> tuple[Array, Array]:
    m, n, f = loops.rows, loops.columns, len(loops.mechanism.driven)
    entries = loops.mechanism.full[1](state, parameters)
    shape = np.shape(state[0]) if state else ()
    if not m:
        return np.zeros((*shape, 0)), np.zeros((*shape, 0, n + free * f))
    rows = [list(entries[m + i * n : m + i * n + n]) for i in range(m)]
    if free:
        rows = [row + list(entries[m + m * n + i * f : m + m * n + i * f + f]) for i, row in enumerate(rows)]
    jacobian = matrices(rows)
    residual = np.stack(np.broadcast_arrays(*entries[:m]), axis=-1)
    return np.broadcast_to(residual, (*shape, m)), np.broadcast_to(jacobian, (*shape, *jacobian.shape[-2:]))
