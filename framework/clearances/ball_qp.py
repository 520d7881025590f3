"""Minimisation of a convex quadratic function over a product of balls, for a whole batch.

    minimise  ½ x·S x − f·x   subject to |x_j| ≤ 1 for each group j of components

with S symmetric and positive semidefinite: x are the offsets of journals over their clearances, S the stiffness against
offsets. At the minimum ``f − S x = λ_j x_j`` in group j with ``λ_j ≥ 0``, and ``λ_j = 0`` where ``|x_j| < 1``. A few
steps in the multipliers λ alone, which determine x, as for a single ball (Conn, Gould and Toint, *Trust-Region
Methods*, 2000, sec. 7.3), lead most entries close to their minimum. Newton's method on the conditions above, with the
set of active spheres updated at each step, then converges to the last digit. For entries that fail, or have more than
one minimum, an interior-point method finds the active spheres from any start (Nocedal and Wright, *Numerical
Optimization*, 2006, ch. 19); of several minima the analytic centre is taken.

The formulas of the first two are in `ball_formulas`. Long batches run them as machine code, see `ball_program`; others,
and those of many balls, step by step on arrays, with components first and batch entries last, (n, N), of the entries
that still need it. Both give the same bits.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..ldl import factorised, substituted
from . import ball_formulas as formulas
from .ball_formulas import Iterate
from .ball_problem import ROUNDING, BallProblem, Groups, Minimum, Quadratic
from .ball_program import CONVERGED, FIRST, STEPS, BallPrograms, chosen, improved, unfinished
from .middle import in_the_middle

# Number of entries handled at a time, whose matrices fit the processor's cache.
CHUNK = 2048
# Product of multiplier and distance from the sphere at which Newton's method takes over, f being of size one; and a
# smaller one if that fails, as it may where a sphere is touched with almost no force.
_CENTRED = (1e-10, 1e-14)
_BALANCED = 1e-12
_RESIDUAL = 1e-6
_MOST = 100
# Finished entries are removed when fewer than this share still iterate.
_SPARSE = 0.7


def minimise_in_balls(
    stiffness: Array,
    force: Array,
    own: NDArray[np.int64],
    members: Array | None = None,
    radius: Array | None = None,
) -> tuple[Array, Array]:
    """The minimum for every entry of a batch.

    Parameters
    ----------
    stiffness
        S, (n, n, N), or (n, n, 1) if it is the same for all entries.
    force
        f, (n, N).
    own
        Ball of each component, (n,), ascending from 0.
    members
        Stiffness (n, N) or (n, 1) with which S is compared to see whether it is zero; the largest number of S where
        None.
    radius
        Radius of each ball, (balls, N) or (balls, 1); one where None.

    Returns
    -------
    offset, pressing
        Minimum o (n, N), and the magnitudes of the forces f − S o on the spheres (balls, N), 0 where a sphere is not
        touched: the multipliers λ for balls of radius one. If S is so large compared with f, beyond some 10⁹, that
        rounding hides the minimum, the residual f − S o − λ o is not small.
    """
    groups = Groups(own)
    if members is None:
        members = np.broadcast_to(np.abs(stiffness).max(axis=(0, 1)), (len(own), stiffness.shape[-1]))
    if radius is None:
        radius = np.ones((groups.count, 1))
    found = minima(BallProblem(groups, stiffness, force, members, radius))
    return found.offset, found.pressing


def minima(problem: BallProblem) -> Minimum:
    """The minima of a problem; `found` tells where a few steps of Newton's method found them."""
    out = _near_minimum(problem)
    left = np.flatnonzero(~out.found)
    for start in range(0, len(left), CHUNK):
        part = left[start : start + CHUNK]
        out.put(part, _any_minimum(problem.at(part)))
    out.found[left] = False
    return out


# -- most entries -----------------------------------------------------------------------------------------------------


def _near_minimum(problem: BallProblem) -> Minimum:
    """The minima; `found` where they were found and are unique, or there is no force."""
    groups, count = problem.groups, problem.force.shape[-1]
    choice = chosen(groups, count)
    programs = BallPrograms.of(groups) if choice.compiled else None
    out = Minimum.places(len(problem.force), groups.count, count, choice.reason)
    if programs is None:
        _by_arrays(problem, out)
    else:
        programs.run(problem, out, compiled=True)
    unloaded = ~problem.force.any(axis=0)
    nowhere = unloaded | ~out.found
    if nowhere.any():
        for each in (out.offset, out.pressing, out.unbalanced):
            each[:, nowhere] = 0.0
        out.found[unloaded], out.steps[unloaded] = True, 0.0
    return out


def _by_arrays(problem: BallProblem, out: Minimum) -> None:
    """Fill in the minima step by step on arrays."""
    own = problem.groups.own
    for start in range(0, problem.force.shape[-1], CHUNK):
        entries = slice(start, start + CHUNK)
        part = problem.at(entries)
        with np.errstate(all="ignore"):
            quadratic, scaling = part.scaled()
            multiplier, first = _near(quadratic)
            x, multiplier, error, more = _newton(quadratic, formulas.inside_balls(quadratic, multiplier), multiplier)
            found = (error <= CONVERGED) & formulas.determined(quadratic, multiplier)
            offset, pressing = scaling.back(x, multiplier, own)
            out.put(entries, Minimum(offset, pressing, part.unbalanced(offset, pressing), found, first + more))


def _near(quadratic: Quadratic) -> tuple[Array, Array]:
    """Multipliers, in most cases close to those of the minimum, (balls, N), and number of steps, (N,)."""
    multiplier = formulas.first_multipliers(quadratic)
    steps, left, part, here = np.zeros(multiplier.shape[1]), np.arange(multiplier.shape[1]), quadratic, multiplier
    for _ in range(FIRST):
        here, settled = formulas.next_multipliers(part, here)
        multiplier[:, left] = here
        steps[left] += 1.0
        if settled.all():
            break
        if settled.any():
            left, part, here = left[~settled], part.at(~settled), here[:, ~settled]
    return multiplier, steps


# -- the remaining entries --------------------------------------------------------------------------------------------


def _any_minimum(problem: BallProblem) -> Minimum:
    """The minima, found from any start; where there are several, the centre of all."""
    with np.errstate(all="ignore"):
        quadratic, scaling = problem.scaled()
        offset, pressing = scaling.back(*_search(quadratic), problem.groups.own)
    count = problem.force.shape[-1]
    sound = np.isfinite(offset).all(axis=0) & np.isfinite(pressing).all(axis=0)
    offset, pressing = np.where(sound, offset, 0.0), np.where(sound, pressing, 0.0)
    with np.errstate(all="ignore"):
        unbalanced = problem.unbalanced(offset, pressing)
    return Minimum(offset, pressing, unbalanced, np.ones(count, dtype=np.bool_), np.zeros(count))


def _search(quadratic: Quadratic) -> tuple[Array, Array]:
    """x and λ at the minimum, at the centre of all minima if there are several."""
    groups = quadratic.groups
    x, multiplier = np.zeros_like(quadratic.force), np.ones((groups.count, quadratic.force.shape[1]))
    x, multiplier = _interior(quadratic, x, multiplier, _CENTRED[0])
    inside = x
    *found, error, _ = _newton(quadratic, x, multiplier)
    unconverged = ~(error <= _BALANCED)
    if unconverged.any():
        part = quadratic.at(unconverged)
        *closer, least, _ = _newton(part, *_interior(part, x[:, unconverged], multiplier[:, unconverged], _CENTRED[1]))
        better = least < error[unconverged]
        for whole, new in zip(found, closer, strict=True):
            whole[:, unconverged] = np.where(better, new, whole[:, unconverged])
    return _of_many(quadratic, found[0], found[1], inside)


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
    rounding = 16.0 * ROUNDING * np.maximum(quadratic.largest, quadratic.members.max(axis=0))
    taken = (middle != x).any(axis=0) & (off <= np.maximum(before, _BALANCED + rounding))
    return np.where(taken, middle, x), np.where(taken, pressed, multiplier)


def _interior(quadratic: Quadratic, x: Array, multiplier: Array, centred: float) -> tuple[Array, Array]:
    """Interior-point method from x and λ to the neighbourhood of the minimum: x and λ there."""
    groups, enough = quadratic.groups, _RESIDUAL + 16.0 * ROUNDING * quadratic.largest
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
    both = substituted(factorised(matrix, ROUNDING), np.stack([residual, -x / inside[groups.own]], axis=1))
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


def _newton(quadratic: Quadratic, x: Array, multiplier: Array) -> tuple[Array, Array, Array, Array]:
    """Newton's method on the conditions of the minimum.

    Returns x, λ, the residual of the conditions relative to S, (N,), and the number of steps, (N,).
    """
    groups, iterate = quadratic.groups, Iterate.of(quadratic, x, multiplier)
    least = np.fmin(iterate.error(quadratic.largest), np.inf)
    best_x, best_multiplier, error = iterate.x.copy(), iterate.multiplier.copy(), least.copy()
    failed, steps, left = np.zeros(len(least)), np.zeros(len(least)), np.arange(len(least))
    going = unfinished(least, failed)
    for _ in range(STEPS):
        if not going.any():
            break
        if going.sum() < _SPARSE * len(going):
            quadratic, iterate, left = quadratic.at(going), iterate.at(going), left[going]
            least, failed, going = least[going], failed[going], going[going]
        iterate = iterate.next(quadratic)
        better, least, failed = improved(iterate.error(quadratic.largest), least, failed)
        steps[left[going]] += 1.0
        better &= going
        put = left[better]
        best_x[:, put], best_multiplier[:, put] = iterate.x[:, better], iterate.multiplier[:, better]
        error[put] = least[better]
        going &= unfinished(least, failed)
    return *formulas.on_spheres(groups, best_x, best_multiplier), error, steps
