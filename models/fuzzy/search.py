"""Smallest and largest values of a function in nested boxes, for all boxes and results at once.

The search begins at several corners and several of the points spread evenly within the box: those that are better than
the ones next to them, of which a result with several hills has several. Each step fits a quadratic
model to the result in a trust region about the best point so far, evaluates the function where the model is smallest,
and shrinks the region (A. R. Conn, N. I. M. Gould & P. L. Toint, *Trust-Region Methods*, 2000).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import combinations
from typing import NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Call = Callable[[Array], Array]

# Largest number of inputs for which all corners are tried; with more, only those to which the slopes point.
ALL_CORNERS = 8
# Largest number of steps, factor by which the trust region shrinks, and the gain at which a search ends, as a share of
# the range of the result.
STEPS, SHRINK, GAIN = 14, 0.25, 1e-13
# Largest number of points from which each result is searched for, among the corners and among those within.
MOST_STARTS = 3
# Number of corners of a model from which its minimum is searched for.
MODEL_CORNERS = 2
# Number of sweeps of coordinate descent by which a model is minimised.
SWEEPS = 12
# Largest number of values that the function returns in one call.
TOGETHER = 4_000_000


@dataclass(eq=False)
class Extremes:
    """Smallest and largest values found so far of each result in each box.

    Parameters
    ----------
    call
        Called with points (n, k); returns the results (n, m).
    lower, upper
        Lower and upper ends of the boxes, (a, k); each box lies within the one before.

    Attributes
    ----------
    value, point
        Smallest values of the results and of their negatives, (2, a, m), and the points with them, (2, a, m, k).
    evaluations, failed
        Number of points at which the function was called, and number of those with a result of NaN.
    """

    call: Call
    lower: Array
    upper: Array
    value: Array = field(init=False)
    point: Array = field(init=False)
    evaluations: int = field(default=0, init=False)
    failed: int = field(default=0, init=False)

    def evaluate(self, points: Array, box: Index) -> Array:
        """Results (n, m) at points (n, k) of the boxes (n,), which are remembered where they are the best."""
        own, back = np.unique(points, axis=0, return_inverse=True)
        found = self.call(own)
        self.evaluations += len(own)
        self.failed += int(np.isnan(found).any(axis=1).sum())
        values = found[back.reshape(-1)]
        if self.evaluations == len(own):
            self.value = np.full((2, len(self.lower), values.shape[1]), np.inf)
            self.point = np.full((*self.value.shape, points.shape[1]), np.nan)
        for k in np.unique(box):
            mine = box == k
            for side, sign in enumerate((1.0, -1.0)):
                self._keep(side, int(k), sign * values[mine], points[mine])
        return values

    def _keep(self, side: int, box: int, values: Array, points: Array) -> None:
        rated = np.where(np.isnan(values), np.inf, values)
        best = np.argmin(rated, axis=0)
        least = rated[best, np.arange(rated.shape[1])]
        better = least < self.value[side, box]
        self.value[side, box] = np.where(better, least, self.value[side, box])
        self.point[side, box] = np.where(better[:, None], points[best], self.point[side, box])

    def nest(self) -> None:
        """Take values found in a box for the boxes around it where they are better."""
        for k in range(len(self.lower) - 2, -1, -1):
            better = self.value[:, k + 1] < self.value[:, k]
            self.value[:, k] = np.where(better, self.value[:, k + 1], self.value[:, k])
            self.point[:, k] = np.where(better[..., None], self.point[:, k + 1], self.point[:, k])


def corners_only(found: Extremes) -> None:
    """Evaluate all corners; results that are monotonic in each input have their extremes there."""
    unit = _all_corners(found.lower.shape[1])
    found.evaluate(*_in_boxes(found, unit))
    found.nest()


def search(found: Extremes, samples: int) -> None:
    """Search for the extremes of all results in all boxes, from the corners and from `samples` points in each box."""
    k = found.lower.shape[1]
    within = np.concatenate([np.full((1, k), 0.5), evenly(samples, k)])
    inner = found.evaluate(*_in_boxes(found, within))
    starts = [_starts(found, inner, within, 2 * k)]
    corners = _all_corners(k) if k <= ALL_CORNERS else _corners_of_slopes(found)
    outer = found.evaluate(*_in_boxes(found, corners))
    found.nest()
    starts.append(_starts(found, outer, corners, k))
    for some, radius in zip(starts, (SHRINK, 1.0), strict=True):
        _refine(found, some, radius)
    found.nest()


def evenly(count: int, k: int) -> Array:
    """Points spread evenly in the unit cube, (count, k).

    Component j of point i is ``0.5 + i x^(-j)`` modulo 1, with the positive root of ``x^(k+1) = x + 1``; for k = 1 that
    is the golden ratio (M. Roberts, 2018).
    """
    root = 2.0
    for _ in range(60):
        root = (1.0 + root) ** (1.0 / (k + 1))
    return np.asarray((0.5 + np.arange(1, count + 1)[:, None] * root ** -np.arange(1.0, k + 1)) % 1.0)


def _all_corners(k: int) -> Array:
    return np.asarray((np.arange(2**k)[:, None] >> np.arange(k)) & 1, dtype=np.float64)


def _corners_of_slopes(found: Extremes) -> Array:
    """Corners of the unit cube towards which each result rises or falls at the middle of the widest box."""
    low, high = found.lower[0], found.upper[0]
    k = len(low)
    stencil = np.full((2 * k, k), 0.5)
    stencil[np.arange(k), np.arange(k)], stencil[np.arange(k, 2 * k), np.arange(k)] = 0.75, 0.25
    values = found.evaluate(low + stencil * (high - low), np.zeros(2 * k, dtype=np.int64))
    rising = np.nan_to_num(values[:k] - values[k:]).T > 0.0
    return np.unique(np.concatenate([rising, ~rising]), axis=0).astype(np.float64)


def _in_boxes(found: Extremes, unit: Array) -> tuple[Array, Index]:
    """Points (n, k) of the unit cube mapped to every box, (a n, k), and the number of the box of each, (a n,)."""
    a, k = found.lower.shape
    points = found.lower[:, None] + unit * (found.upper - found.lower)[:, None]
    # A coordinate of 1 is mapped to the end of the box exactly.
    points = np.where(unit == 1.0, found.upper[:, None], points)
    return points.reshape(-1, k), np.repeat(np.arange(a), len(unit))


def _starts(found: Extremes, values: Array, unit: Array, near: int) -> _Starts:
    """Points of each box from which to search for each result: those that are better than the `near` ones next to them.

    There are several if the result has several valleys or hills; the best points of these are taken, `MOST_STARTS` at
    most.
    """
    points, _ = _in_boxes(found, unit)
    a, n = len(found.lower), len(unit)
    table = np.moveaxis(values.reshape(a, n, values.shape[1]), 1, 2)
    signed = np.stack([np.where(np.isnan(table), np.inf, sign * table) for sign in (1.0, -1.0)])
    beside = np.argsort(scipy.spatial.distance.cdist(unit, unit, "sqeuclidean"), axis=1, kind="stable")[:, 1 : near + 1]
    lowest = signed <= signed[..., beside].min(axis=-1, initial=np.inf)
    order = np.argsort(np.where(lowest, signed, np.inf), axis=-1, kind="stable")[..., :MOST_STARTS]
    chosen = np.take_along_axis(lowest, order, axis=-1)
    chosen[..., 0] = True
    side, box, result = np.nonzero(chosen)[:3]
    return _Starts(side, box, result, points.reshape(a, n, -1)[box, order[chosen]])


class _Starts(NamedTuple):
    """Points (n, k) from which to search, and the side (0 for smallest, 1 for largest), box and result of each."""

    side: Index
    box: Index
    result: Index
    point: Array


@dataclass(eq=False)
class _Tasks:
    """The searches, one for each box, result and sign: their points, values and sizes of the trust region."""

    sign: Array
    box: Index
    result: Index
    at: Array
    value: Array
    radius: Array

    def __getitem__(self, which: Index | NDArray[np.bool_]) -> _Tasks:
        return _Tasks(*(each[which] for each in vars(self).values()))


def _refine(found: Extremes, starts: _Starts, radius: float) -> None:
    """Search from all starts at once, with a trust region of size `radius`."""
    count = len(starts.point)
    tasks = _Tasks(
        np.array([1.0, -1.0])[starts.side],
        starts.box,
        starts.result,
        starts.point.copy(),
        np.full(count, np.inf),
        np.full(count, radius),
    )
    for _ in range(STEPS):
        with np.errstate(invalid="ignore"):  # infinite values have no range
            spread = -(found.value[0] + found.value[1])
        going = _step(found, tasks, np.where(np.isfinite(spread), spread, 0.0))
        tasks = tasks[going]
        tasks = tasks[_first_of_equals(tasks)]
        if not len(tasks.at):
            return


def _first_of_equals(tasks: _Tasks) -> Index:
    """The searches that have not met an earlier one for the same result in the same box."""
    key = np.column_stack([tasks.sign, tasks.box, tasks.result, tasks.radius, tasks.at])
    return np.asarray(np.sort(np.unique(key, axis=0, return_index=True)[1]))


def _step(found: Extremes, tasks: _Tasks, spread: Array) -> NDArray[np.bool_]:
    """Do one step of all searches, and return which of them continue, (n,)."""
    low, high = found.lower[tasks.box], found.upper[tasks.box]
    reach = tasks.radius[:, None] * (high - low)
    first, last = np.maximum(low, tasks.at - reach), np.minimum(high, tasks.at + reach)
    stencil = _stencil(low.shape[1])
    values = _asked(found, tasks, first, last, stencil)
    best = np.argmin(values, axis=1)
    step, model = _least_of_model(values, stencil[best])
    tried = _placed(first, last, step[:, None])[:, 0]
    reached = _own(found, tasks, tried[:, None])[:, 0]
    nearby = np.min(values, axis=1)
    before, at = tasks.value.copy(), tasks.at.copy()
    for value, point in ((nearby, _placed(first, last, stencil[best][:, None])[:, 0]), (reached, tried)):
        better = value < tasks.value
        tasks.at = np.where(better[:, None], point, tasks.at)
        tasks.value = np.where(better, value, tasks.value)
    # The trust region keeps its size if its best point is at its edge but not at an edge of the box.
    inside = (tasks.at == low) | (tasks.at == high) | ((tasks.at > first) & (tasks.at < last)) | (first == last)
    tasks.radius = np.where(inside.all(axis=1) | (tasks.at == at).all(axis=1), SHRINK * tasks.radius, tasks.radius)
    least = GAIN * spread[tasks.box, tasks.result]
    with np.errstate(invalid="ignore"):
        gained = np.where(np.isfinite(before), before - tasks.value, np.inf)
        lacking = np.where(np.isfinite(model), tasks.value - model, np.inf)
    return (gained > least) | (lacking > least)


def _stencil(k: int) -> Array:
    """Points in [-1, 1]^k: the middle, the ends along each axis, and one corner in the plane of each pair, (s, k)."""
    one = np.eye(k)
    pairs = [one[i] + one[j] for i, j in combinations(range(k), 2)]
    return np.concatenate([np.zeros((1, k)), one, -one, np.reshape(pairs, (-1, k))])


def _placed(first: Array, last: Array, step: Array) -> Array:
    """Points (n, s, k) at relative steps (..., s, k) in [-1, 1] from the middles of boxes (n, k); ±1 gives the end."""
    middle, half = 0.5 * (first + last)[:, None], 0.5 * (last - first)[:, None]
    inner = np.clip(middle + half * step, first[:, None], last[:, None])
    return np.asarray(np.where(step == 1.0, last[:, None], np.where(step == -1.0, first[:, None], inner)))


def _asked(found: Extremes, tasks: _Tasks, first: Array, last: Array, stencil: Array) -> Array:
    """Signed result of each search at the stencil in its trust region, (n, s)."""
    return _own(found, tasks, _placed(first, last, stencil))


def _own(found: Extremes, tasks: _Tasks, points: Array) -> Array:
    """Signed result of each search, to be made smallest, at its points (n, s, k): (n, s), infinite for NaN."""
    n, s, k = points.shape
    out = np.empty((n, s))
    size = max(1, TOGETHER // max(s * found.value.shape[2], 1))
    for start in range(0, n, size):
        part = slice(start, start + size)
        values = found.evaluate(points[part].reshape(-1, k), np.repeat(tasks.box[part], s))
        mine = values.reshape(-1, s, values.shape[1])
        own = tasks.sign[part, None] * np.take_along_axis(mine, tasks.result[part, None, None], axis=2)[..., 0]
        out[part] = np.where(np.isnan(own), np.inf, own)
    return out


def _least_of_model(values: Array, start: Array) -> tuple[Array, Array]:
    """Minimum of the quadratic through values (n, s) at the stencil within [-1, 1]^k: points (n, k), values (n,)."""
    n, k = start.shape
    some = np.where(np.isfinite(values), values, np.nan)
    f, plus, minus = some[:, 0], some[:, 1 : k + 1], some[:, k + 1 : 2 * k + 1]
    g = 0.5 * (plus - minus)
    h = np.zeros((n, k, k))
    h[:, np.arange(k), np.arange(k)] = plus + minus - 2.0 * f[:, None]
    for column, (i, j) in enumerate(combinations(range(k), 2), start=2 * k + 1):
        h[:, i, j] = h[:, j, i] = some[:, column] - plus[:, i] - plus[:, j] + f
    quadratic = _Quadratic(f, g, h)
    points = quadratic.descent(np.concatenate([start[None], quadratic.lowest_corners()]))
    found = quadratic(points)
    best = np.argmin(np.where(np.isnan(found), np.inf, found), axis=0), np.arange(n)
    return points[best], found[best]


class _Quadratic(NamedTuple):
    """Quadratics ``f + g x + x h x / 2``: (n,), (n, k) and (n, k, k)."""

    f: Array
    g: Array
    h: Array

    def __call__(self, x: Array) -> Array:
        """Values (s, n) at points (s, n, k)."""
        bent = np.einsum("nij,sni,snj->sn", self.h, x, x)
        return np.asarray(self.f + np.einsum("ni,sni->sn", self.g, x) + 0.5 * bent)

    def lowest_corners(self) -> Array:
        """The corners of [-1, 1]^k with the smallest values, (s, n, k); none if there are too many."""
        n, k = self.g.shape
        if not 1 < k <= ALL_CORNERS:
            return np.zeros((0, n, k))
        corners = 2.0 * _all_corners(k) - 1.0
        pairs = (corners[:, :, None] * corners[:, None]).reshape(-1, k * k)
        values = self.g @ corners.T + 0.5 * (self.h.reshape(n, k * k) @ pairs.T)
        order = np.argsort(np.where(np.isnan(values), np.inf, values), axis=1, kind="stable")[:, :MODEL_CORNERS]
        return np.swapaxes(corners[order], 0, 1)

    def descent(self, start: Array) -> Array:
        """Points (s, n, k) of [-1, 1]^k to which coordinate descent leads."""
        x, g, h = start.copy(), self.g, self.h
        with np.errstate(divide="ignore", invalid="ignore"):
            for _ in range(SWEEPS):
                for i in range(x.shape[-1]):
                    slope = g[:, i] + np.einsum("nj,snj->sn", h[:, i], x) - h[:, i, i] * x[..., i]
                    bent = np.clip(-slope / h[:, i, i], -1.0, 1.0)
                    end = np.where(slope > 0.0, -1.0, np.where(slope < 0.0, 1.0, x[..., i]))
                    best = np.where(h[:, i, i] > 0.0, bent, end)
                    x[..., i] = np.where(np.isfinite(best), best, x[..., i])
        return x
