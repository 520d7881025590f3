"""Closure error of the loops, and the state near a given one where it is least."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array
from .blocks import shape_of
from .linear import matrices, stacked_solve
from .loops import Loops
from .terms import Value

ITERATIONS = 80
UNDAMPED = 20
# Gap below which no further step is needed, and gap below which a pose may still be closed exactly.
EXACT, ALMOST = 1e-16, 1e-9


def open_by(loops: Loops, state: Sequence[Value], parameters: Sequence[Value]) -> Array:
    """Closure error: norm of all closing residuals, in units of the mechanism's size and radians, (...)."""
    square = np.zeros(shape_of(state, parameters))
    for row in loops.mechanism.residual[1](state, parameters):
        if not (isinstance(row, float) and row == 0.0):
            square += row * row
    return np.sqrt(square)


def open_by_one(loops: Loops, state: Sequence[float], parameters: Sequence[float]) -> float:
    """`open_by` of a single state, with the same bits."""
    square = 0.0
    for row in loops.mechanism.residual[0](state, parameters):
        square += row * row
    return math.sqrt(square)


def widest(loops: Loops, state: Sequence[Value], parameters: Sequence[Value]) -> NDArray[np.intp]:
    """Closing row with the largest residual, (...)."""
    shape = shape_of(state, parameters)
    rows = [np.broadcast_to(np.abs(row), shape) for row in loops.mechanism.residual[1](state, parameters)]
    return np.asarray(np.argmax(rows, axis=0))


def nearest(
    loops: Loops, state: Sequence[Value], parameters: Sequence[Value], *, free: bool = False
) -> tuple[list[Value], Array]:
    """States (M,) with the least gap near `state`, and that gap, by the Levenberg-Marquardt method.

    With `free`, the drives are unknowns as well; no spherical joint may be driven then. Each member stops at its own
    last step, so that its bits do not depend on its neighbours.
    """
    m, n = loops.rows, loops.columns + (len(loops.mechanism.driven) if free else 0)
    at = _At(loops, [np.array(x, dtype=np.float64) for x in np.broadcast_arrays(*state)], parameters, free)
    damping = np.full(at.norm.shape, 1e-4)
    moving = np.ones(at.norm.shape, dtype=bool)
    for _ in range(ITERATIONS if m and n else 0):
        transposed = np.swapaxes(at.jacobian, -1, -2)
        normal = transposed @ at.jacobian + damping[..., None, None] * np.eye(n)
        step = -stacked_solve(normal, transposed @ at.residual[..., None])[..., 0]
        better = at.moved(step, moving)
        damping = np.clip(np.where(better, 0.1 * damping, 4.0 * damping), 1e-15, 1e6)
        moving = moving & ~((at.norm < EXACT) | (damping >= 1e6) | (np.abs(step).max(axis=-1) < 1e-15))
        if not moving.any():
            break
    # A pose that is almost closed lies near a singular one. There each step halves the distance at best and may
    # increase the gap on the way, which damping would prevent.
    best, least = at.state, at.norm
    for _ in range(UNDAMPED if m and n else 0):
        moving = (least > EXACT) & (least < ALMOST)
        if not moving.any():
            break
        step = -(np.linalg.pinv(at.jacobian, rcond=1e-9) @ at.residual[..., None])[..., 0]
        at.moved(step, moving, at.norm < ALMOST)
        best = [np.where(at.norm < least, x, y) for x, y in zip(at.state, best, strict=True)]
        least = np.minimum(at.norm, least)
    return best, open_by(loops, best, parameters)


class _At:
    """States (M,) with their residuals and Jacobians; each moves where a step reduces its gap."""

    def __init__(self, loops: Loops, state: list[Value], parameters: Sequence[Value], free: bool) -> None:
        self.loops, self.parameters, self.free, self.state = loops, parameters, free, state
        self.residual, self.jacobian = _evaluated(loops, state, parameters, free)
        self.norm: Array = np.sqrt((self.residual**2).sum(axis=-1))

    def moved(
        self, step: Array, chosen: NDArray[np.bool_], anyway: NDArray[np.bool_] | bool = False
    ) -> NDArray[np.bool_]:
        """Take the step (M, n) of the chosen members if it reduces the gap, or `anyway`; returns where it was taken."""
        columns = self.loops.columns
        trial = self.loops.advance(self.state, [step[..., k] for k in range(columns)])
        if self.free:
            for k, place in enumerate(self.loops.driven_states):
                trial[place] = trial[place] + step[..., columns + k]
        residual, jacobian = _evaluated(self.loops, trial, self.parameters, self.free)
        norm = np.sqrt((residual**2).sum(axis=-1))
        better = np.asarray(chosen & ((norm < self.norm) | anyway))
        self.state = [np.where(better, x, y) for x, y in zip(trial, self.state, strict=True)]
        self.residual = np.where(better[..., None], residual, self.residual)
        self.jacobian = np.where(better[..., None, None], jacobian, self.jacobian)
        self.norm = np.where(better, norm, self.norm)
        return better


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
