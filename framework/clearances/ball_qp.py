"""Minimisation of a convex quadratic function over a product of balls, for a whole batch.

    minimise  ½ x·S x − f·x   subject to |x_j| ≤ 1 for each group j of components

with S symmetric and positive semidefinite: x are the offsets of journals over their clearances, S the stiffness against
offsets. At the minimum ``f − S x = λ_j x_j`` in group j with ``λ_j ≥ 0``, and ``λ_j = 0`` where ``|x_j| < 1``. A few
steps in the multipliers λ alone, which determine x, as for a single ball (Conn, Gould and Toint, *Trust-Region
Methods*, 2000, sec. 7.3), lead most entries close to their minimum. Newton's method on the conditions above, with the
set of active spheres updated at each step, then converges to the last digit. For entries that fail, or have more than
one minimum, an interior-point method finds the active spheres from any start (Nocedal and Wright, *Numerical
Optimization*, 2006, ch. 19); of several minima the analytic centre is taken.

Arrays have components first and batch entries last, (n, N), so that each step is one NumPy operation on the entries
that still need it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..ldl import factorised, substituted
from .middle import SOFT, in_the_middle

# Number of entries handled at a time, whose matrices fit the processor's cache.
CHUNK = 2048
# Product of multiplier and distance from the sphere at which Newton's method takes over, f being of size one; and a
# smaller one if that fails, as it may where a sphere is touched with almost no force.
_CENTRED = (1e-10, 1e-14)
_BALANCED = 1e-12
_RESIDUAL = 1e-6
_MOST = 100
_STEPS = 12
_PATIENCE = 6
_ROUNDING = 1e-15
# Number of steps in the multipliers alone, and the share that remains of one that would fall to zero or below.
_FIRST, _KEPT = 4, 0.1
# If all pivots of S + λ, relative to the diagonal, are above this, the minimum is unique.
_DETERMINED = 1e-9
# Error at which an entry has converged, and number of steps without improvement after which a converged one stops.
_CONVERGED, _STAGNANT = 4e-15, 2
# Finished entries are removed when fewer than this share still iterate.
_SPARSE = 0.7


@dataclass(frozen=True)
class Groups:
    """The components of each ball: `own` (n,) is the ball of each component, in ascending order."""

    own: NDArray[np.int64]

    @cached_property
    def count(self) -> int:
        """Number of balls."""
        return int(self.own[-1]) + 1

    @cached_property
    def bounds(self) -> list[tuple[int, int]]:
        """Index of the first component of each ball, and of the one after its last."""
        ends = np.searchsorted(self.own, np.arange(self.count + 1)).tolist()
        return list(pairwise(ends))

    def dot(self, a: Array, b: Array) -> Array:
        """Inner product of two vectors in each ball, (balls, ...)."""
        product = a * b
        out = np.empty((self.count, *product.shape[1:]))
        for ball, (start, end) in enumerate(self.bounds):
            out[ball] = product[start]
            for k in range(start + 1, end):
                out[ball] += product[k]
        return out

    def apart(self, x: Array) -> Array:
        """The parts of vectors (n, N) in each ball, zero elsewhere, (n, balls, N)."""
        out = np.zeros((len(x), self.count, *x.shape[1:]))
        for ball, (start, end) in enumerate(self.bounds):
            out[start:end, ball] = x[start:end]
        return out


@dataclass(frozen=True)
class Quadratic:
    """The quadratic functions of N entries.

    Attributes
    ----------
    groups
        The components of each ball.
    stiffness
        S, (n, n, N).
    largest
        Largest magnitude in S, (N,).
    force
        f, (n, N).
    members
        Stiffness with which S is compared to see whether it is zero, (n, N).
    """

    groups: Groups
    stiffness: Array
    largest: Array
    force: Array
    members: Array

    @classmethod
    def of(cls, groups: Groups, stiffness: Array, force: Array, members: Array | None = None) -> Quadratic:
        """The functions with a stiffness S and a force f; `members` are the largest numbers of S where None."""
        largest = np.abs(stiffness).max(axis=(0, 1))
        return cls(
            groups, stiffness, largest, force, np.broadcast_to(largest, force.shape) if members is None else members
        )

    def at(self, entries: NDArray[np.bool_]) -> Quadratic:
        """The functions of the entries in a mask (N,)."""
        force, members = self.force[:, entries], self.members[:, entries]
        return Quadratic(self.groups, self.stiffness[:, :, entries], self.largest[entries], force, members)

    def left(self, x: Array) -> Array:
        """``f - S x``."""
        return self.force - _times(self.stiffness, x)

    def widened(self, multiplier: Array) -> Array:
        """``S + λ`` plus its rounding, so that it is regular, (n, n, N)."""
        out, rounding = self.stiffness.copy(), 2.0 * _ROUNDING * self.largest
        for i, ball in enumerate(self.groups.own):
            out[i, i] += multiplier[ball] + rounding
        return out

    def solved(self, multiplier: Array) -> tuple[Array, Array]:
        """The solution x of ``(S + λ) x = f``, (n, N), and ``-dx/dλ`` for each ball, (n, balls, N)."""
        factor = factorised(self.widened(multiplier), _ROUNDING)
        x = substituted(factor, self.force)
        return x, substituted(factor, self.groups.apart(x))


def minimise_in_balls(
    stiffness: Array, force: Array, own: NDArray[np.int64], members: Array | None = None
) -> tuple[Array, Array]:
    """The minimum for every entry of a batch.

    Parameters
    ----------
    stiffness
        S, (n, n, N).
    force
        f, (n, N).
    own
        Ball of each component, (n,), ascending from 0.
    members
        Stiffness (n, N) with which S is compared to see whether it is zero; the largest number of S where None.

    Returns
    -------
    x, multiplier
        Minimum x (n, N), and multipliers λ (balls, N), 0 where a sphere is not touched. If S is so large compared with
        f, beyond some 10⁹, that rounding hides the minimum, the residual f − S x − λ x is not small.
    """
    groups = Groups(own)
    x, multiplier = np.zeros_like(force), np.zeros((groups.count, force.shape[1]))
    size = np.abs(force).max(axis=0)
    left = np.flatnonzero(size > 0.0)
    for minimum in (_near_minimum, _any_minimum):
        unsolved = []
        for start in range(0, len(left), CHUNK):
            part = left[start : start + CHUNK]
            beside = None if members is None else members[:, part] / size[part]
            quadratic = Quadratic.of(groups, stiffness[:, :, part] / size[part], force[:, part] / size[part], beside)
            with np.errstate(all="ignore"):
                *found, solved = minimum(quadratic)
            sound = np.isfinite(found[0]).all(axis=0) & np.isfinite(found[1]).all(axis=0)
            x[:, part], multiplier[:, part] = (
                np.where(sound, found[0], 0.0),
                np.where(sound, found[1] * size[part], 0.0),
            )
            unsolved.append(part[~(solved & sound)])
        left = np.concatenate(unsolved) if unsolved else left
    return x, multiplier


# -- most entries -----------------------------------------------------------------------------------------------------


def _near_minimum(quadratic: Quadratic) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The minimum for f of size one: x, λ, and a mask of the entries at which it was found and is unique."""
    x, multiplier, error = _newton(quadratic, *_near(quadratic))
    return x, multiplier, (error <= _CONVERGED) & _determined(quadratic, multiplier)


def _near(quadratic: Quadratic) -> tuple[Array, Array]:
    """x and λ, in most cases close to the minimum: Newton's method for λ on ``1/|x_j| = 1`` with ``(S + λ) x = f``.

    A multiplier that would fall to zero is kept positive, as S alone may be singular, and the others are solved again.
    """
    groups = quadratic.groups
    multiplier = np.sqrt(groups.dot(quadratic.force, quadratic.force))
    eye = np.eye(groups.count)[..., None]
    for _ in range(_FIRST):
        x, pushed = quadratic.solved(multiplier)
        square = groups.dot(x, x)
        slope = groups.dot(x[:, None], pushed)
        missing = square * (np.sqrt(square) - 1.0)
        vanishing, least = np.zeros(multiplier.shape, dtype=bool), _KEPT * multiplier
        for _ in range(2):
            down = np.where(vanishing, least - multiplier, 0.0)
            others = missing - _times(slope, down)
            both = ~vanishing[:, None] & ~vanishing
            step = substituted(factorised(np.where(both, slope, eye), _ROUNDING), np.where(vanishing, down, others))
            vanishing |= multiplier + step <= least
        multiplier = np.where(vanishing, least, multiplier + step)
    x = substituted(factorised(quadratic.widened(multiplier), _ROUNDING), quadratic.force)
    return x / np.maximum(np.sqrt(groups.dot(x, x)), 1.0)[groups.own], multiplier


def _determined(quadratic: Quadratic, multiplier: Array) -> NDArray[np.bool_]:
    """Whether S + λ is positive definite, except in components without any force, so that the minimum is unique.

    If no sphere is touched, a stiffness that is negligible beside that of the members does not make it unique.
    """
    matrix, own = quadratic.stiffness.copy(), quadratic.groups.own
    for i, ball in enumerate(own):
        matrix[i, i] += multiplier[ball]
    diagonal = np.stack([matrix[k, k] for k in range(len(matrix))])
    untouched = (multiplier[own] == 0.0) & (diagonal > 0.0)
    least = np.maximum(np.where(untouched, SOFT * quadratic.members, 0.0), _DETERMINED * diagonal)
    factor = factorised(matrix, _ROUNDING)
    return np.asarray(
        np.logical_and.reduce([each * over <= 1.0 for each, (_, over) in zip(least, factor, strict=True)])
    )


# -- the remaining entries --------------------------------------------------------------------------------------------


def _any_minimum(quadratic: Quadratic) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The minimum for f of size one, the centre of all minima if there are several: x, λ, and a mask of True."""
    groups = quadratic.groups
    x, multiplier = np.zeros_like(quadratic.force), np.ones((groups.count, quadratic.force.shape[1]))
    x, multiplier = _interior(quadratic, x, multiplier, _CENTRED[0])
    inside = x
    *found, error = _newton(quadratic, x, multiplier)
    unconverged = ~(error <= _BALANCED)
    if unconverged.any():
        part = quadratic.at(unconverged)
        *closer, least = _newton(part, *_interior(part, x[:, unconverged], multiplier[:, unconverged], _CENTRED[1]))
        better = least < error[unconverged]
        for whole, new in zip(found, closer, strict=True):
            whole[:, unconverged] = np.where(better, new, whole[:, unconverged])
    return *_of_many(quadratic, found[0], found[1], inside), np.ones(error.shape, dtype=bool)


def _of_many(quadratic: Quadratic, x: Array, multiplier: Array, inside: Array) -> tuple[Array, Array]:
    """The centre of all minima with the energy of x, given points `inside` the balls; x itself where it is unique.

    Multipliers that are rounding are set to zero.
    """
    own = quadratic.groups.own
    sound = np.isfinite(quadratic.members).all(axis=0) & np.isfinite(quadratic.largest)
    sound &= np.all([np.isfinite(each).all(axis=0) for each in (x, multiplier, inside)], axis=0)
    if not sound.any():
        return x, multiplier
    part, middle = quadratic.at(sound), x.copy()
    pressed = np.where(multiplier > _BALANCED, multiplier, 0.0)
    middle[:, sound] = in_the_middle(
        own, part.stiffness, part.members, x[:, sound], pressed[:, sound] > 0.0, inside[:, sound]
    )
    off, before = (
        np.abs(quadratic.left(at) - by[own] * at).max(axis=0) for at, by in ((middle, pressed), (x, multiplier))
    )
    # S, and so the motions that it does not resist, are known only to the rounding of the members' stiffness
    rounding = 16.0 * _ROUNDING * np.maximum(quadratic.largest, quadratic.members.max(axis=0))
    taken = (middle != x).any(axis=0) & (off <= np.maximum(before, _BALANCED + rounding))
    return np.where(taken, middle, x), np.where(taken, pressed, multiplier)


def _interior(quadratic: Quadratic, x: Array, multiplier: Array, centred: float) -> tuple[Array, Array]:
    """Interior-point method from x and λ to the neighbourhood of the minimum: x and λ there."""
    groups, enough = quadratic.groups, _RESIDUAL + 16.0 * _ROUNDING * quadratic.largest
    out_x, out_multiplier, left = x.copy(), multiplier.copy(), np.arange(len(enough))
    for _ in range(_MOST):
        inside = 0.5 * (1.0 - groups.dot(x, x))
        residual = quadratic.left(x)
        rest = np.abs(residual - multiplier[groups.own] * x).max(axis=0)
        product = multiplier * inside
        going = (product.max(axis=0) > centred) | (rest > enough)
        out_x[:, left], out_multiplier[:, left] = x, multiplier
        if not going.any():
            break
        if not going.all():
            quadratic, left, enough, rest = quadratic.at(going), left[going], enough[going], rest[going]
            x, multiplier, inside, residual, product = (a[:, going] for a in (x, multiplier, inside, residual, product))
        # the distance from the spheres must not vanish before the residual does
        mean = np.maximum(product.mean(axis=0), 0.1 * rest)
        x, multiplier = _inward(quadratic, x, multiplier, inside, residual, mean)
    return out_x, out_multiplier


def _inward(
    quadratic: Quadratic, x: Array, multiplier: Array, inside: Array, residual: Array, mean: Array
) -> tuple[Array, Array]:
    """One predictor-corrector step in x and λ; the target for λ times the distance from the sphere is reduced by what
    the predictor achieves.
    """
    groups, matrix, weight = quadratic.groups, quadratic.widened(multiplier), multiplier / inside
    for ball, (start, end) in enumerate(groups.bounds):
        for i in range(start, end):
            for j in range(start, end):
                matrix[i, j] += weight[ball] * x[i] * x[j]
    both = substituted(factorised(matrix, _ROUNDING), np.stack([residual, -x / inside[groups.own]], axis=1))
    ahead, inward = both[:, 0], both[:, 1]
    rate = multiplier * (groups.dot(x, ahead) / inside - 1.0), (1.0 + multiplier * groups.dot(x, inward)) / inside
    free = np.minimum(1.0, _longest(groups, x, multiplier, inside, ahead, rate[0]))
    target = np.clip((1.0 - free) ** 3, 1e-4, 0.5) * mean
    step, change = ahead + target * inward, rate[0] + target * rate[1]
    share = np.clip(1.0 - mean, 0.8, 0.9) * _longest(groups, x, multiplier, inside, step, change)
    length = np.minimum(1.0, share)
    return x + length * step, multiplier + length * change


def _longest(groups: Groups, x: Array, multiplier: Array, inside: Array, step: Array, change: Array) -> Array:
    """Longest multiple of a step before it reaches a sphere or makes a multiplier zero, (N,)."""
    square, along = groups.dot(step, step), groups.dot(x, step)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(along * along + 2.0 * square * inside)
        sphere = np.where(along >= 0.0, 2.0 * inside / (along + root), (root - along) / square)
        vanishing = np.where(change < 0.0, -multiplier / change, np.inf)
    sphere = np.where(square > 0.0, sphere, np.inf)
    longest: Array = np.minimum(sphere.min(axis=0), vanishing.min(axis=0))
    return longest


# -- the last digits --------------------------------------------------------------------------------------------------


def _newton(quadratic: Quadratic, x: Array, multiplier: Array) -> tuple[Array, Array, Array]:
    """Newton's method on the conditions of the minimum: a sphere is active where λ exceeds the distance from it.

    Returns x, λ and the residual of the conditions relative to S, (N,).
    """
    groups, count = quadratic.groups, x.shape[1]
    least, failed = np.full(count, np.inf), np.zeros(count)
    best_x, best_multiplier, error_there, left = x.copy(), multiplier.copy(), least.copy(), np.arange(count)
    for _ in range(_STEPS):
        inside = 0.5 * (1.0 - groups.dot(x, x))
        touched = multiplier > inside
        multiplier = np.where(touched, multiplier, 0.0)
        residual = quadratic.left(x) - multiplier[groups.own] * x
        off = np.maximum(np.where(touched, np.abs(inside), -inside), -multiplier).max(axis=0)
        error = np.maximum(np.abs(residual).max(axis=0) / (1.0 + quadratic.largest), off)
        better = error < least
        least, failed = np.where(better, error, least), np.where(better, 0, failed + 1)
        put = left[better]
        best_x[:, put], best_multiplier[:, put] = x[:, better], multiplier[:, better]
        error_there[put] = error[better]
        # each entry stops by its own criteria, so that its result does not depend on the others
        going = (least > _ROUNDING) & (failed < np.where(least <= _CONVERGED, _STAGNANT, _PATIENCE))
        if not going.any():
            break
        if going.sum() < _SPARSE * len(going):
            quadratic, left, least, failed = quadratic.at(going), left[going], least[going], failed[going]
            x, multiplier, residual, inside = (a[:, going] for a in (x, multiplier, residual, inside))
            touched = touched[:, going]
        step, change = _corrected(quadratic, x, multiplier, residual, inside, touched)
        x, multiplier = x + step, multiplier + change
    length = np.sqrt(groups.dot(best_x, best_x))
    x = best_x / np.where(best_multiplier > 0.0, length, np.maximum(length, 1.0))[groups.own]
    return x, np.maximum(best_multiplier, 0.0), error_there


def _corrected(
    quadratic: Quadratic, x: Array, multiplier: Array, residual: Array, inside: Array, touched: NDArray[np.bool_]
) -> tuple[Array, Array]:
    """x and λ after a Newton step: ``(S + λ) dx + x dλ = residual`` and, on each active sphere, ``x·dx = inside``."""
    groups = quadratic.groups
    factor = factorised(quadratic.widened(multiplier + _ROUNDING), _ROUNDING)
    free = substituted(factor, residual)
    pushed = substituted(factor, groups.apart(np.where(touched[groups.own], x, 0.0)))
    both, eye = touched[:, None] & touched, np.eye(groups.count)[..., None]
    gap = np.where(touched, groups.dot(x, free) - inside, 0.0)
    change = substituted(factorised(np.where(both, groups.dot(x[:, None], pushed), eye), _ROUNDING), gap)
    return free - _times(pushed, change), change


def _times(matrix: Array, x: Array) -> Array:
    """Product of matrices (n, n, N) and vectors (n, N), summed in an order that does not depend on N."""
    out: Array = matrix[:, 0] * x[0]
    for j in range(1, len(x)):
        out += matrix[:, j] * x[j]
    return out
