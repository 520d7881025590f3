"""A convex quadratic over a product of balls, for a whole batch: where each of many points rests against its sphere.

    minimise  ½ x·S x − f·x   subject to |x_j| ≤ 1 for each group j of components

with S symmetric and not negative, as a joint's stiffness against offsets in all joints is. At the minimum
``f − S x = λ_j x_j`` in group j with ``λ_j ≥ 0``, and ``λ_j = 0`` where ``|x_j| < 1``. A few steps for the multipliers
alone, of which x follows, as for a single ball (Conn, Gould and Toint, Trust-Region Methods, 2000, sec. 7.3), lead most
entries into the neighbourhood of their minimum. Newton's method on these equations, with the touched spheres as found
and found again at each step, then goes to the last digit. For what is left, or has more than one minimum, an
interior-point method finds from any start which spheres are touched (Nocedal and Wright, Numerical Optimization, 2006,
ch. 19), and where there is a choice its middle is taken.

Components lead and the batch follows, so that each step is one NumPy operation on the entries that still need it.
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
# Steps for the multipliers alone, and what these leave at least of one that falls to zero or below.
_FIRST, _KEPT = 4, 0.1
# Pivot of S + λ, relative to its diagonal, above which there is one minimum only.
_DETERMINED = 1e-9
# Error of an entry that has converged, and steps without gain after which such a one ends.
_CONVERGED, _STAGNANT = 4e-15, 2
# Share of the entries that still iterate below which the others are taken out.
_SPARSE = 0.7


@dataclass(frozen=True)
class Groups:
    """Which components form which ball: `own` holds the ball of each component, in order."""

    own: NDArray[np.int64]

    @cached_property
    def count(self) -> int:
        """Number of balls."""
        return int(self.own[-1]) + 1

    @cached_property
    def bounds(self) -> list[tuple[int, int]]:
        """First component of each ball, and the one behind its last."""
        ends = np.searchsorted(self.own, np.arange(self.count + 1)).tolist()
        return list(pairwise(ends))

    def dot(self, a: Array, b: Array) -> Array:
        """Inner product by ball, (balls, ...)."""
        product = a * b
        out = np.empty((self.count, *product.shape[1:]))
        for ball, (start, end) in enumerate(self.bounds):
            out[ball] = product[start]
            for k in range(start + 1, end):
                out[ball] += product[k]
        return out

    def apart(self, x: Array) -> Array:
        """The vectors with the components of one ball each, (n, balls, N)."""
        out = np.zeros((len(x), self.count, *x.shape[1:]))
        for ball, (start, end) in enumerate(self.bounds):
            out[start:end, ball] = x[start:end]
        return out


@dataclass(frozen=True)
class Quadratic:
    """Quadratics of some entries: S (n, n, N), its largest number (N,), f (n, N), and the stiffness (n, N) beside which
    that of S is judged to be none."""

    groups: Groups
    stiffness: Array
    largest: Array
    force: Array
    members: Array

    @classmethod
    def of(cls, groups: Groups, stiffness: Array, force: Array, members: Array | None = None) -> Quadratic:
        """Those of entries with this stiffness and force."""
        largest = np.abs(stiffness).max(axis=(0, 1))
        return cls(
            groups, stiffness, largest, force, np.broadcast_to(largest, force.shape) if members is None else members
        )

    def at(self, entries: NDArray[np.bool_]) -> Quadratic:
        """Those of some of the entries."""
        force, members = self.force[:, entries], self.members[:, entries]
        return Quadratic(self.groups, self.stiffness[:, :, entries], self.largest[entries], force, members)

    def left(self, x: Array) -> Array:
        """``f - S x``."""
        return self.force - _times(self.stiffness, x)

    def widened(self, multiplier: Array) -> Array:
        """``S + λ``, and its rounding so that it is regular, (n, n, N)."""
        out, rounding = self.stiffness.copy(), 2.0 * _ROUNDING * self.largest
        for i, ball in enumerate(self.groups.own):
            out[i, i] += multiplier[ball] + rounding
        return out

    def solved(self, multiplier: Array) -> tuple[Array, Array]:
        """x with ``(S + λ) x = f``, and what λ of each ball changes in it, by ball, (n, N) and (n, balls, N)."""
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
        Stiffness (n, N) beside which that of S is judged to be none; the largest number of S where None.

    Returns
    -------
    x, multiplier
        (n, N) and λ (balls, N), which is 0 where a sphere is not touched. Where S is so large against f, beyond some
        10⁹, that rounding hides the minimum, f − S x − λ x shows it.
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
    """The minimum for f of size one: x, λ, and where they are the only one."""
    x, multiplier, error = _newton(quadratic, *_near(quadratic))
    return x, multiplier, (error <= _CONVERGED) & _determined(quadratic, multiplier)


def _near(quadratic: Quadratic) -> tuple[Array, Array]:
    """x and λ near the minimum in most cases: Newton's method for λ on ``1/|x_j| = 1`` with ``(S + λ) x = f``.

    A multiplier that would fall to zero is kept above it, as S alone may be singular, and the others are sought again.
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
    """Whether S + λ is positive definite, but for components that nothing acts on, so that there is one minimum.

    What the members' stiffness tells to be soft leaves a choice where no sphere is touched.
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


# -- what is left -----------------------------------------------------------------------------------------------------


def _any_minimum(quadratic: Quadratic) -> tuple[Array, Array, NDArray[np.bool_]]:
    """The minimum for f of size one, in the middle of others where there are any: x, λ, and that this is all."""
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
    """The minimum in the middle of those that share the energy of x, from places inside, x and λ; as found where it is
    the only one. A multiplier that is rounding is none."""
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
    # S is known to the rounding of the members' stiffness, and so are the motions that it does not resist
    rounding = 16.0 * _ROUNDING * np.maximum(quadratic.largest, quadratic.members.max(axis=0))
    taken = (middle != x).any(axis=0) & (off <= np.maximum(before, _BALANCED + rounding))
    return np.where(taken, middle, x), np.where(taken, pressed, multiplier)


def _interior(quadratic: Quadratic, x: Array, multiplier: Array, centred: float) -> tuple[Array, Array]:
    """Interior-point method from x and λ up to the neighbourhood of the minimum: x and λ there."""
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
        # the distance from the spheres is not to vanish before the imbalance does
        mean = np.maximum(product.mean(axis=0), 0.1 * rest)
        x, multiplier = _inward(quadratic, x, multiplier, inside, residual, mean)
    return out_x, out_multiplier


def _inward(
    quadratic: Quadratic, x: Array, multiplier: Array, inside: Array, residual: Array, mean: Array
) -> tuple[Array, Array]:
    """One step: the target of λ times the distance from the sphere falls by what a step without it would achieve."""
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
    """Multiple of a step at which it meets the first sphere, or makes the first multiplier vanish, (N,)."""
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
    """Newton's method on the conditions of the minimum: a sphere is touched where λ exceeds the distance from it.

    Returns x, λ and by how far they miss the conditions, relative to S.
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
        # each entry ends for reasons of its own, so that it does not depend on the others
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
    """Newton step of x and λ: ``(S + λ) dx + x dλ = residual`` and, on each touched sphere, ``x·dx = inside``."""
    groups = quadratic.groups
    factor = factorised(quadratic.widened(multiplier + _ROUNDING), _ROUNDING)
    free = substituted(factor, residual)
    pushed = substituted(factor, groups.apart(np.where(touched[groups.own], x, 0.0)))
    both, eye = touched[:, None] & touched, np.eye(groups.count)[..., None]
    gap = np.where(touched, groups.dot(x, free) - inside, 0.0)
    change = substituted(factorised(np.where(both, groups.dot(x[:, None], pushed), eye), _ROUNDING), gap)
    return free - _times(pushed, change), change


def _times(matrix: Array, x: Array) -> Array:
    """Product by entry; its terms are added in one order however many entries there are."""
    out: Array = matrix[:, 0] * x[0]
    for j in range(1, len(x)):
        out += matrix[:, j] * x[j]
    return out
