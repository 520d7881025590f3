"""Steps towards the minimum in balls, see `ball_qp`, for arrays of numbers or terms of a recording."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from functools import reduce
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..elementwise import less, maximum, square_root, where
from ..ldl import Columns, backward, factorised, forward, full_steps
from .ball_problem import ROUNDING, Groups, Quadratic, in_order, mirrored, times
from .middle import SOFT

# If all pivots of S + λ, relative to the diagonal, are above this, the minimum is unique.
_DETERMINED = 1e-9
# The share that remains of a multiplier that would fall to zero or below, and the relative change at which they are
# close enough for Newton's method.
_KEPT, _SETTLED = 0.1, 1e-3


def _all(conditions: Iterable[Any]) -> Any:
    return reduce(lambda a, b: a & b, conditions)


# -- linear equations -------------------------------------------------------------------------------------------------


def _solved(matrix: Array, load: Array) -> Array:
    """Solution of equations with positive semidefinite matrices (n, n, N), which are overwritten."""
    columns = factorised(matrix, ROUNDING)
    out = load.copy()
    forward(full_steps(len(out)), columns, out)
    backward(columns, out)
    return out


def _compliance(columns: Columns, pushed: Array) -> Array:
    """Products of loads (n, m, N), which `forward` has changed, with the solutions for them, (m, m, N)."""
    return mirrored(in_order(row[:, None] * (row * over) for row, (_, over) in zip(pushed, columns, strict=True)))


# -- steps in the multipliers alone -----------------------------------------------------------------------------------


def first_multipliers(quadratic: Quadratic) -> Array:
    """Multipliers λ, (balls, N), if there were no stiffness."""
    return square_root(quadratic.groups.dot(quadratic.force, quadratic.force))


def next_multipliers(quadratic: Quadratic, multiplier: Array) -> tuple[Array, Any]:
    """Multipliers λ after a step of Newton's method for ``1/|x_j| = 1`` with ``(S + λ) x = f``; whether they settled.

    A multiplier that would fall to zero is kept positive, as S alone may be singular, and the others are solved again.
    """
    groups, steps = quadratic.groups, full_steps(len(quadratic.force))
    columns = factorised(quadratic.widened(multiplier), ROUNDING)
    x = quadratic.force.copy()
    forward(steps, columns, x)
    backward(columns, x)
    pushed = groups.apart(x)
    forward(steps, columns, pushed)
    slope, square = _compliance(columns, pushed), groups.dot(x, x)
    missing = square * (square_root(square) - 1.0)
    least = _KEPT * multiplier
    vanishing = ~less(least, multiplier + _solved(slope.copy(), missing))
    down = where(vanishing, least - multiplier, 0.0)
    others = where(vanishing, down, missing - times(slope, down))
    eye = np.eye(groups.count)[..., None]
    ahead = multiplier + _solved(where(vanishing[:, None] | vanishing, eye, slope), others)
    new = where(vanishing | ~less(least, ahead), least, ahead)
    return new, _all(~less(_SETTLED * multiplier, np.abs(new - multiplier)))


def inside_balls(quadratic: Quadratic, multiplier: Array) -> Array:
    """The solution x of ``(S + λ) x = f``, brought into the balls, (n, N)."""
    x = _solved(quadratic.widened(multiplier), quadratic.force)
    return x / maximum(square_root(quadratic.groups.dot(x, x)), 1.0)[quadratic.groups.own]


# -- Newton's method with active spheres ------------------------------------------------------------------------------


@dataclass(frozen=True)
class Iterate:
    """A point x with multipliers λ, and how far it is from the minimum.

    Attributes
    ----------
    x
        The point, (n, N).
    multiplier
        Multipliers, zero where a sphere is not active, (balls, N).
    residual
        ``f - S x - λ x``, (n, N).
    inside
        Half of ``1 - |x_j|²``, (balls, N).
    touched
        Whether a sphere is active: where λ exceeds the distance from it, (balls, N).
    """

    x: Array
    multiplier: Array
    residual: Array
    inside: Array
    touched: Any

    @classmethod
    def of(cls, quadratic: Quadratic, x: Array, multiplier: Array) -> Iterate:
        """The iterate of a point and multipliers."""
        inside = 0.5 * (1.0 - quadratic.groups.dot(x, x))
        touched = less(inside, multiplier)
        multiplier = where(touched, multiplier, 0.0)
        residual = quadratic.left(x) - multiplier[quadratic.groups.own] * x
        return cls(x, multiplier, residual, inside, touched)

    def at(self, entries: NDArray[np.bool_]) -> Iterate:
        """The iterate of the entries in a mask (N,)."""
        parts = (self.x, self.multiplier, self.residual, self.inside, self.touched)
        return Iterate(*(each[:, entries] for each in parts))

    def error(self, largest: Array) -> Array:
        """Residual of the conditions of the minimum relative to S, whose `largest` number is given, (N,)."""
        off = maximum(where(self.touched, np.abs(self.inside), -self.inside), -self.multiplier)
        return maximum(reduce(maximum, np.abs(self.residual)) / (1.0 + largest), reduce(maximum, off))

    def next(self, quadratic: Quadratic) -> Iterate:
        """After a Newton step: ``(S + λ) dx + x dλ = residual`` and, on each active sphere, ``x·dx = inside``."""
        groups, steps = quadratic.groups, full_steps(len(self.x))
        columns = factorised(quadratic.widened(self.multiplier + ROUNDING), ROUNDING)
        free, pushed = self.residual.copy(), groups.apart(where(self.touched[groups.own], self.x, 0.0))
        forward(steps, columns, free)
        forward(steps, columns, pushed)
        moved = in_order(row * (each * over) for row, each, (_, over) in zip(pushed, free, columns, strict=True))
        slope = _compliance(columns, pushed)
        for ball, touched in enumerate(self.touched):
            slope[ball, ball] = where(touched, slope[ball, ball], 1.0)
        change = _solved(slope, where(self.touched, moved - self.inside, 0.0))
        for ball in range(groups.count):
            free = free - pushed[:, ball] * change[ball]
        backward(columns, free)
        return Iterate.of(quadratic, self.x + free, self.multiplier + change)


def on_spheres(groups: Groups, x: Array, multiplier: Array) -> tuple[Array, Array]:
    """x and λ with x exactly on the active spheres and not outside the others, and λ not negative."""
    length = square_root(groups.dot(x, x))
    room = where(less(0.0, multiplier), length, maximum(length, 1.0))
    return x / room[groups.own], maximum(multiplier, 0.0)


def determined(quadratic: Quadratic, multiplier: Array) -> Any:
    """Whether S + λ is positive definite, except in components without any force, so that the minimum is unique, (N,).

    If no sphere is touched, a stiffness that is negligible beside that of the members does not make it unique.
    """
    own, matrix = quadratic.groups.own, quadratic.added(multiplier)
    diagonal = np.stack([matrix[k, k] for k in range(len(matrix))])
    untouched = ~less(0.0, multiplier)[own] & less(0.0, diagonal)
    least = maximum(where(untouched, SOFT * quadratic.members, 0.0), _DETERMINED * diagonal)
    factor = factorised(matrix, ROUNDING)
    return _all(~less(1.0, each * over) for each, (_, over) in zip(least, factor, strict=True))
