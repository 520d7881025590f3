"""A convex quadratic over a product of balls, for a whole batch: where each of many points rests against its sphere.

    minimise  ½ x·S x − f·x   subject to |x_j| ≤ 1 for each group j of components

with S symmetric and not negative, as a joint's stiffness against offsets in all joints is. At the minimum
``f − S x = λ_j x_j`` in group j with ``λ_j ≥ 0``, and ``λ_j = 0`` where ``|x_j| < 1``. An interior-point method finds
from any start which spheres are touched (Nocedal and Wright, Numerical Optimization, 2006, ch. 19); Newton's method on
these equations, with the touched spheres as found and found again at each step, then goes to the last digit.

Components lead and the batch follows, so that each step is one NumPy operation on the entries that still need it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

# Entries handled at a time: the matrices of this many fit the cache.
CHUNK = 2048
# Product of multiplier and distance from the sphere at which Newton's method takes over, with f of size one; and where
# that fails, as it may where a sphere is touched with next to no force.
_CENTRED = (1e-10, 1e-14)
_BALANCED = 1e-12
_RESIDUAL = 1e-6
_MOST = 100
_STEPS = 12
_PATIENCE = 6
_ROUNDING = 1e-15


@dataclass(frozen=True)
class Groups:
    """Which components form which ball: `own` holds the ball of each component, in order."""

    own: NDArray[np.int64]

    def dot(self, a: Array, b: Array) -> Array:
        """Inner product by ball, (balls, N)."""
        starts = np.searchsorted(self.own, np.arange(self.own[-1] + 1))
        out: Array = np.add.reduceat(a * b, starts, axis=0)
        return out

    def widened(self, stiffness: Array, multiplier: Array, weight: Array, x: Array) -> Array:
        """``S + λ + w x xᵀ``, the last two ball by ball, (n, n, N)."""
        out = stiffness.copy()
        rounding = 2.0 * _ROUNDING * np.abs(stiffness).max(axis=(0, 1))
        for i, ball in enumerate(self.own):
            out[i, i] += multiplier[ball] + rounding
            for j in np.flatnonzero(self.own == ball):
                out[i, j] += weight[ball] * x[i] * x[j]
        return out


def minimise_in_balls(stiffness: Array, force: Array, own: NDArray[np.int64]) -> tuple[Array, Array]:
    """The minimum for every entry of a batch.

    Parameters
    ----------
    stiffness
        S, (n, n, N).
    force
        f, (n, N).
    own
        Ball of each component, (n,), ascending from 0.

    Returns
    -------
    x, multiplier
        (n, N) and λ (balls, N), which is 0 where a sphere is not touched. Where S is so large against f, beyond some
        10⁹, that rounding hides the minimum, f − S x − λ x shows it.
    """
    groups = Groups(own)
    x, multiplier = np.zeros_like(force), np.zeros((int(own[-1]) + 1, force.shape[1]))
    size = np.abs(force).max(axis=0)
    loaded = np.flatnonzero(size > 0.0)
    for start in range(0, len(loaded), CHUNK):
        part = loaded[start : start + CHUNK]
        scaled = stiffness[:, :, part] / size[part], force[:, part] / size[part]
        with np.errstate(all="ignore"):
            found = _minimum(*scaled, groups)
        sound = np.isfinite(found[0]).all(axis=0) & np.isfinite(found[1]).all(axis=0)
        x[:, part], multiplier[:, part] = np.where(sound, found[0], 0.0), np.where(sound, found[1] * size[part], 0.0)
    return x, multiplier


def _minimum(stiffness: Array, force: Array, groups: Groups) -> tuple[Array, Array]:
    """The minimum for f of size one: x and λ."""
    x, multiplier = np.zeros_like(force), np.ones((int(groups.own[-1]) + 1, force.shape[1]))
    x, multiplier = _interior(stiffness, force, groups, x, multiplier, _CENTRED[0])
    *found, error = _newton(stiffness, force, groups, x, multiplier)
    unconverged = ~(error <= _BALANCED)
    if unconverged.any():
        part = stiffness[:, :, unconverged], force[:, unconverged], groups
        *closer, least = _newton(*part, *_interior(*part, x[:, unconverged], multiplier[:, unconverged], _CENTRED[1]))
        better = least < error[unconverged]
        for whole, new in zip(found, closer, strict=True):
            whole[:, unconverged] = np.where(better, new, whole[:, unconverged])
    return found[0], found[1]


def _interior(
    stiffness: Array, force: Array, groups: Groups, x: Array, multiplier: Array, centred: float
) -> tuple[Array, Array]:
    """Interior-point method from x and λ up to the neighbourhood of the minimum: x and λ there."""
    out_x, out_multiplier, left = x.copy(), multiplier.copy(), np.arange(force.shape[1])
    enough = _RESIDUAL + 16.0 * _ROUNDING * np.abs(stiffness).max(axis=(0, 1))
    for _ in range(_MOST):
        inside = 0.5 * (1.0 - groups.dot(x, x))
        residual = force - _times(stiffness, x)
        rest = np.abs(residual - multiplier[groups.own] * x).max(axis=0)
        product = multiplier * inside
        going = (product.max(axis=0) > centred) | (rest > enough)
        out_x[:, left], out_multiplier[:, left] = x, multiplier
        if not going.any():
            break
        if not going.all():
            left, enough, stiffness = left[going], enough[going], stiffness[:, :, going]
            x, multiplier, inside, residual, force, product = (
                a[:, going] for a in (x, multiplier, inside, residual, force, product)
            )
            rest = rest[going]
        # the distance from the spheres is not to vanish before the imbalance does
        mean = np.maximum(product.mean(axis=0), 0.1 * rest)
        x, multiplier = _inward(stiffness, groups, x, multiplier, inside, residual, mean)
    return out_x, out_multiplier


def _inward(
    stiffness: Array, groups: Groups, x: Array, multiplier: Array, inside: Array, residual: Array, mean: Array
) -> tuple[Array, Array]:
    """One step: the target of λ times the distance from the sphere falls by what a step without it would achieve."""
    matrix = groups.widened(stiffness, multiplier, multiplier / inside, x)
    ahead, inward = _solved(matrix, residual, -x / inside[groups.own])
    rate = multiplier * (groups.dot(x, ahead) / inside - 1.0), (1.0 + multiplier * groups.dot(x, inward)) / inside
    free = np.minimum(1.0, _longest(groups, x, multiplier, inside, ahead, rate[0]))
    target = np.clip((1.0 - free) ** 3, 1e-4, 0.5) * mean
    step, change = ahead + target * inward, rate[0] + target * rate[1]
    share = np.clip(1.0 - mean, 0.8, 0.9) * _longest(groups, x, multiplier, inside, step, change)
    length = np.minimum(1.0, share)
    return x + length * step, multiplier + length * change


def _longest(groups: Groups, x: Array, multiplier: Array, inside: Array, step: Array, change: Array) -> Array:
    """Multiple of a step at which it meets the first sphere, or makes the first multiplier vanish, (N,)."""
    square, along = groups.dot(step, step), groups.dot(x, step)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(along * along + 2.0 * square * inside)
        sphere = np.where(along >= 0.0, 2.0 * inside / (along + root), (root - along) / square)
        vanishing = np.where(change < 0.0, -multiplier / change, np.inf)
    sphere = np.where(square > 0.0, sphere, np.inf)
    longest: Array = np.minimum(sphere.min(axis=0), vanishing.min(axis=0))
    return longest


def _newton(stiffness: Array, force: Array, groups: Groups, x: Array, multiplier: Array) -> tuple[Array, Array, Array]:
    """Newton's method on the conditions of the minimum: a sphere is touched where λ exceeds the distance from it.

    Returns x, λ and by how far they miss the conditions, relative to S.
    """
    size = 1.0 + np.abs(stiffness).max(axis=(0, 1))
    least = np.full(size.shape, np.inf)
    best = x, multiplier
    going, failed = np.ones(size.shape, dtype=bool), np.zeros(size.shape)
    for _ in range(_STEPS):
        inside = 0.5 * (1.0 - groups.dot(x, x))
        touched = multiplier > inside
        multiplier = np.where(touched, multiplier, 0.0)
        residual = force - _times(stiffness, x) - multiplier[groups.own] * x
        off = np.maximum(np.where(touched, np.abs(inside), -inside), -multiplier).max(axis=0)
        error = np.maximum(np.abs(residual).max(axis=0) / size, off)
        better = going & (error < least)
        least = np.where(better, error, least)
        best = np.where(better, x, best[0]), np.where(better, multiplier, best[1])
        failed = np.where(better, 0, failed + 1)
        # each entry ends for reasons of its own, so that it does not depend on the others
        going &= (least > _ROUNDING) & (failed < _PATIENCE)
        if not going.any():
            break
        step, change = _corrected(stiffness, groups, x, multiplier, residual, inside, touched)
        x, multiplier = x + step, multiplier + change
    x, multiplier = best
    length = np.sqrt(groups.dot(x, x))
    x = x / np.where(multiplier > 0.0, length, np.maximum(length, 1.0))[groups.own]
    return x, np.maximum(multiplier, 0.0), least


def _corrected(
    stiffness: Array,
    groups: Groups,
    x: Array,
    multiplier: Array,
    residual: Array,
    inside: Array,
    touched: NDArray[np.bool_],
) -> tuple[Array, Array]:
    """Newton step of x and λ: ``(S + λ) dx + x dλ = residual`` and, on each touched sphere, ``x·dx = inside``."""
    balls = range(len(multiplier))
    normals = [np.where((groups.own == b)[:, None] & touched[b], x, 0.0) for b in balls]
    matrix = groups.widened(stiffness, multiplier + _ROUNDING, np.zeros_like(multiplier), x)
    free, *pushed = _solved(matrix, residual, *normals)
    schur = np.stack([groups.dot(normals[b], pushed[c])[b] + (b == c) * ~touched[b] for b in balls for c in balls])
    gap = np.where(touched, groups.dot(x, free) - inside, 0.0)
    (change,) = _solved(schur.reshape(len(balls), len(balls), -1), gap)
    for b in balls:
        free -= change[b] * pushed[b]
    return free, change


def _times(matrix: Array, x: Array) -> Array:
    """Product by entry; its terms are added in one order however many entries there are."""
    out: Array = matrix[:, 0] * x[0]
    for j in range(1, len(x)):
        out += matrix[:, j] * x[j]
    return out


def _solved(matrix: Array, *loads: Array) -> list[Array]:
    """Solutions of a symmetric positive definite system, which is overwritten, by LDLᵀ; no pivot is below rounding."""
    n = len(matrix)
    least = [_ROUNDING * matrix[k, k] + np.finfo(float).tiny for k in range(n)]
    out = [load.copy() for load in loads]
    for k in range(n):
        matrix[k, k] = 1.0 / np.maximum(matrix[k, k], least[k])
        for i in range(k + 1, n):
            low = matrix[k, i] * matrix[k, k]
            matrix[i, i:] -= low * matrix[k, i:]
            for y in out:
                y[i] -= low * y[k]
    for y in out:
        for k in reversed(range(n)):
            for i in range(k + 1, n):
                y[k] -= matrix[k, i] * y[i]
            y[k] *= matrix[k, k]
    return out
