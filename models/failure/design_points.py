"""The most likely failures: points of the limit state that are nearest the median in standard normal scores.

The search is that of Hasofer & Lind and of Rackwitz & Fiessler with the merit function of Zhang & Der Kiureghian (2nd
IFIP WG 7.5 conference, 1995), for all poses and starting points at once.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from .edges import Edges
from .limit_state import Index, LimitState
from .second_order import curvatures

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]

# Batches of the search, its longest step, and the step and the distance from the limit state with which it ends. The
# reliability index is second order in both.
MOST, LONGEST, CLOSE = 60, 4.0, 1e-6
# Least share of a step that is tried: at an edge of the limit state no step may be better.
SHORTEST = 2.0**-8
# Distance from the median of the other starting points; and by how much further than the nearest a point may lie to be
# kept, when it adds less than a thousandth.
AROUND, FURTHER = 3.0, 2.0
# Points closer than this are one.
SAME = 1e-2
# Of samples in the order of their values, by which share they stand appreciably before where the likely failures expect
# them, and the share of those that may.
APPRECIABLE, STRAY = 0.1, 0.004
# Samples that are not explained, from which searches begin, and the cosine of the angle that lies between two of them.
STRAYS, ALONG = 6, 0.8
# Samples of failures that stand for likely ones, and how far they are apart.
MANY, APART = 10, 1.0


@dataclass(frozen=True, eq=False)
class DesignPoints:
    """Most likely failures of one limit state at several poses, the nearest to the median first at each.

    Attributes
    ----------
    scores
        Standard normal scores, (n, k).
    beta
        Reliability indices: distances from the median, (n,), negative where the median fails.
    normals
        Directions of failure, of unit length, (n, k). Their squares are the importance of the inputs.
    slopes
        Sizes of the gradients, (n,).
    pose
        Numbers of their poses, (n,).
    converged
        Whether the search ended, (n,).
    """

    scores: Array
    beta: Array
    normals: Array
    slopes: Array
    pose: Index
    converged: Mask

    def __getitem__(self, which: object) -> DesignPoints:
        """Some of them."""
        return replace(self, **{name: getattr(self, name)[which] for name in self.__dataclass_fields__})

    @property
    def first_order(self) -> Array:
        """Probability beyond the tangent planes, Φ(-β), (n,)."""
        from scipy.special import ndtr

        return np.asarray(ndtr(-self.beta))

    def explain(self, scores: Array, values: Array) -> bool:
        """Whether none of some samples (m, k) is worse, by its value (m,) among theirs, than by the tangent planes."""
        # At an edge, where a search does not end, there is more than planes tell.
        if not self.converged.size or not self.converged.all():
            return False
        return bool(np.count_nonzero(self.unexplained(scores, values)) <= STRAY * len(values))

    def unexplained(self, scores: Array, values: Array) -> Mask:
        """Which samples (m, k) are appreciably worse, by their values (m,) among theirs, than by the tangent planes."""
        if not self.converged.size:
            return np.ones(len(values), dtype=bool)
        left = np.min(self.slopes * (self.beta - scores @ self.normals.T), axis=1)
        expected, found = (np.argsort(np.argsort(each, kind="stable"), kind="stable") for each in (left, values))
        return np.asarray(expected - found > APPRECIABLE * len(values))

    def missing(self, failed: Array) -> Mask:
        """Beyond which tangent planes, (n,), none of some failures (m, k) lies."""
        beyond = np.any(failed @ self.normals.T >= self.beta, axis=0)
        return np.asarray(self.converged & ~beyond)

    def planes(self) -> Edges:
        """The tangent planes."""
        return Edges(self.normals, self.beta)

    def paraboloids(self, limit: LimitState) -> Edges:
        """Paraboloids with the curvature of the limit state."""
        found = curvatures(limit, self.scores, self.pose, self.normals, self.slopes)
        return Edges(self.normals, self.beta, *found)


def design_points(limit: LimitState, starts: int) -> DesignPoints:
    """Search from the median and, with several starts, from points around it, at all poses at once.

    Parameters
    ----------
    limit
        The limit state.
    starts
        Starting points a pose.
    """
    count, k = limit.poses or 1, limit.size
    begin = np.concatenate([np.zeros((1, k)), AROUND * _directions(starts - 1, k)])
    pose = np.repeat(np.arange(count), starts)
    return _distinct(_searched(limit, np.tile(begin, (count, 1)), pose))


def _searched(limit: LimitState, begin: Array, pose: Index) -> DesignPoints:
    """Where searches from scores (n, k) at the poses (n,) come to."""
    search = _Search(limit, begin, pose)
    for _ in range(MOST):
        if search.done.all():
            break
        search.advance()
    return search.found()


def added_points(limit: LimitState, points: DesignPoints, scores: Array, values: Array, pose: Index) -> DesignPoints:
    """Points to which searches lead from the worst of the samples that some points of a pose do not explain.

    Parameters
    ----------
    limit
        The limit state.
    points
        What is known of it.
    scores, values
        Samples (m, k) and their values (m,).
    pose
        Poses (m,) at which the samples have their values.
    """
    stray = np.flatnonzero(points.unexplained(scores, values))
    unit = scores / np.maximum(np.linalg.norm(scores, axis=1, keepdims=True), 1e-300)
    begin: list[int] = []
    for row in stray[np.argsort(values[stray], kind="stable")].tolist():
        if len(begin) < STRAYS and np.all(unit[begin] @ unit[row] < ALONG):
            begin.append(row)
    return _searched(limit, scores[begin], pose[begin])


def _directions(count: int, k: int) -> Array:
    """Directions in k dimensions that lie far apart, the same ones at each call, (count, k)."""
    rng, found = np.random.default_rng(0), np.zeros((0, k))
    while len(found) < count:
        axes = np.linalg.qr(rng.normal(size=(k, k)))[0]
        found = np.concatenate([found, np.stack([axes, -axes], axis=1).reshape(-1, k)])
    return found[:count]


class _Search:
    """Rows of points on their way to the limit state."""

    def __init__(self, limit: LimitState, scores: Array, pose: Index) -> None:
        self.limit, self.pose = limit, pose
        self.scores, self.share = scores, np.ones(len(scores))
        self.value, self.gradient = limit.linearised(scores, pose)
        # A row without a slope leads nowhere.
        self.lost = ~self._leads(self.value, self.gradient)
        self.done = self.lost.copy()
        self._settle(np.flatnonzero(~self.lost))

    @staticmethod
    def _leads(value: Array, gradient: Array) -> Mask:
        return np.asarray(
            np.isfinite(value) & np.isfinite(gradient).all(axis=-1) & (np.linalg.norm(gradient, axis=-1) > 0.0)
        )

    def _nearest(self, rows: Index) -> tuple[Array, Array, Array]:
        """Nearest points of the tangent planes, their distances, and the sizes of the gradients."""
        slope = np.linalg.norm(self.gradient[rows], axis=-1)
        normal = -self.gradient[rows] / slope[:, None]
        beta = self.value[rows] / slope + np.sum(normal * self.scores[rows], axis=-1)
        return beta[:, None] * normal, beta, slope

    def _settle(self, rows: Index) -> None:
        """Mark the rows that have arrived."""
        target, _, slope = self._nearest(rows)
        size = np.maximum(1.0, np.linalg.norm(target, axis=-1))
        left = np.linalg.norm(target - self.scores[rows], axis=-1)
        self.done[rows] = (left <= CLOSE * size) & (np.abs(self.value[rows]) <= CLOSE * size * slope)

    def advance(self) -> None:
        """One batch: every row that has not arrived tries a share of its step, half as much where it was too long."""
        rows = np.flatnonzero(~self.done)
        target, _, slope = self._nearest(rows)
        step = target - self.scores[rows]
        length = np.linalg.norm(step, axis=-1)
        step = step * (np.minimum(1.0, LONGEST / length) * self.share[rows])[:, None]
        tried = self.scores[rows] + step
        value, gradient = self.limit.linearised(tried, self.pose[rows])
        far = np.maximum(np.linalg.norm(self.scores[rows], axis=-1), np.linalg.norm(target, axis=-1))
        weight = 2.0 * np.maximum(far, 0.5) / slope
        before = 0.5 * np.sum(self.scores[rows] ** 2, axis=-1) + weight * np.abs(self.value[rows])
        after = 0.5 * np.sum(tried**2, axis=-1) + weight * np.abs(value)
        # Rounding decides between two points that are the same.
        better = after <= before + 1e-9 * np.maximum(1.0, before)
        leads = self._leads(value, gradient)
        taken = leads & (better | (self.share[rows] <= SHORTEST))
        self.share[rows] = np.where(taken, 1.0, 0.5 * self.share[rows])
        stuck = rows[~leads & (self.share[rows] < SHORTEST)]
        self.lost[stuck] = self.done[stuck] = True
        moved = rows[taken]
        self.scores[moved], self.value[moved], self.gradient[moved] = tried[taken], value[taken], gradient[taken]
        self._settle(moved)

    def found(self) -> DesignPoints:
        """Where the rows have come to."""
        rows = np.flatnonzero(~self.lost)
        target, beta, slope = self._nearest(rows)
        near = np.abs(self.value[rows]) <= 1e-3 * slope * np.maximum(1.0, np.abs(beta))
        rows, target, beta, slope = rows[near], target[near], beta[near], slope[near]
        normals = -self.gradient[rows] / slope[:, None]
        return DesignPoints(target, beta, normals, slope, self.pose[rows], self.done[rows])


def _distinct(points: DesignPoints) -> DesignPoints:
    """Each point once, those that add something, sorted by pose and distance."""
    distance = np.abs(points.beta)
    order = np.lexsort((distance, ~points.converged, points.pose))
    points, distance = points[order], distance[order]
    kept: list[int] = []
    for pose in np.unique(points.pose):
        here = np.flatnonzero(points.pose == pose)
        here = here[distance[here] <= distance[here][points.converged[here]].min(initial=np.inf) + FURTHER]
        mine: list[int] = []
        for row in here:
            off = np.linalg.norm(points.scores[mine] - points.scores[row], axis=-1)
            if not np.any(off <= SAME * max(1.0, float(distance[row]))):
                mine.append(int(row))
        kept += mine
    return points[np.array(kept, dtype=np.int64)]


def likely(failed: Array, pose: int) -> DesignPoints:
    """The samples of failures that are nearest the median and apart from each other, as points without a slope.

    Parameters
    ----------
    failed
        Scores of samples that fail, (m, k).
    pose
        Number of their pose.
    """
    distance = np.linalg.norm(failed, axis=1)
    kept: list[int] = []
    for row in np.argsort(distance, kind="stable").tolist():
        if len(kept) < MANY and np.all(np.linalg.norm(failed[kept] - failed[row], axis=-1) > APART):
            kept.append(row)
    scores, beta = failed[kept], distance[kept]
    normals = scores / np.maximum(beta, 1e-300)[:, None]
    nothing = np.zeros(len(kept))
    return DesignPoints(scores, beta, normals, nothing, np.full(len(kept), pose), nothing.astype(bool))


def joined(several: list[DesignPoints]) -> DesignPoints:
    """Points of several searches as one."""
    return DesignPoints(*(np.concatenate([getattr(each, name) for each in several]) for name in FIELDS))


def distinct(several: list[DesignPoints]) -> DesignPoints:
    """Points of several searches, each once."""
    return _distinct(joined(several))


FIELDS = tuple(DesignPoints.__dataclass_fields__)
