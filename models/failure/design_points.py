"""Design points: the points of the limit state nearest to the median in standard normal scores.

They are found by the iteration of Hasofer & Lind and of Rackwitz & Fiessler with the merit function of Zhang & Der
Kiureghian (2nd IFIP WG 7.5 conference, 1995), for all poses and starting points at once.
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

# Largest number of iterations, longest step, and the relative tolerance of the step and of the distance from the limit
# state. The error of the reliability index is of second order in both.
MOST, LONGEST, CLOSE = 60, 4.0, 1e-6
# Smallest share of a step that is tried: at an edge of the limit state it may be that no step improves the point.
SHORTEST = 2.0**-8
# Distance of the other starting points from the median; and how much farther out than the nearest design point others
# may lie. Beyond that each adds less than a thousandth of the probability if the nearest is at 3 or more.
AROUND, FURTHER = 3.0, 2.0
# Points closer than this count as the same.
SAME = 1e-2
# Samples are ranked by the limit state and by the tangent planes. A sample is unexplained if its first rank is lower by
# this share of all samples; and the share of unexplained samples that is accepted.
APPRECIABLE, STRAY = 0.1, 0.004
# Number of unexplained samples at which searches begin, and the largest cosine of the angle between two of them.
STRAYS, ALONG = 6, 0.8
# Number of failed samples that serve as likely failures, and their smallest distance from each other.
MANY, APART = 10, 1.0


@dataclass(frozen=True, eq=False)
class DesignPoints:
    """Design points of one limit state at several poses, the nearest to the median first at each pose.

    Attributes
    ----------
    scores
        Standard normal scores, (n, k).
    beta
        Reliability indices: distances from the median, (n,), negative where the median fails.
    normals
        Unit vectors of steepest descent of the limit state, (n, k). Their squares are the importance of the inputs.
    slopes
        Lengths of the gradients, (n,).
    pose
        Numbers of the poses, counted from 0, (n,).
    converged
        Whether the search converged, (n,).
    """

    scores: Array
    beta: Array
    normals: Array
    slopes: Array
    pose: Index
    converged: Mask

    def __getitem__(self, which: object) -> DesignPoints:
        """Select points."""
        return replace(self, **{name: getattr(self, name)[which] for name in self.__dataclass_fields__})

    @property
    def first_order(self) -> Array:
        """Probability beyond the tangent planes, Φ(-β), (n,)."""
        from scipy.special import ndtr

        return np.asarray(ndtr(-self.beta))

    def explain(self, scores: Array, values: Array) -> bool:
        """Whether the tangent planes rank samples (m, k) nearly as their values of the limit state (m,) do."""
        # A search that does not converge has met an edge, where planes are not enough.
        if not self.converged.size or not self.converged.all():
            return False
        return bool(np.count_nonzero(self.unexplained(scores, values)) <= STRAY * len(values))

    def unexplained(self, scores: Array, values: Array) -> Mask:
        """Samples (m, k) closer to failure, by the rank of their values (m,), than by the tangent planes, (m,)."""
        if not self.converged.size:
            return np.ones(len(values), dtype=bool)
        left = np.min(self.slopes * (self.beta - scores @ self.normals.T), axis=1)
        expected, found = (np.argsort(np.argsort(each, kind="stable"), kind="stable") for each in (left, values))
        return np.asarray(expected - found > APPRECIABLE * len(values))

    def missing(self, failed: Array) -> Mask:
        """Tangent planes without any of the failed samples (m, k) beyond them, (n,)."""
        beyond = np.any(failed @ self.normals.T >= self.beta, axis=0)
        return np.asarray(self.converged & ~beyond)

    def planes(self) -> Edges:
        """The tangent planes at the points."""
        return Edges(self.normals, self.beta)

    def paraboloids(self, limit: LimitState) -> Edges:
        """Paraboloids at the points with the curvature of the limit state."""
        found = curvatures(limit, self.scores, self.pose, self.normals, self.slopes)
        return Edges(self.normals, self.beta, *found)


def design_points(limit: LimitState, starts: int) -> DesignPoints:
    """Find design points from the median and, with several starts, from points around it, at all poses at once.

    Parameters
    ----------
    limit
        The limit state, with n poses.
    starts
        Number of starting points at each pose.
    """
    count, k = limit.poses or 1, limit.size
    begin = np.concatenate([np.zeros((1, k)), AROUND * _directions(starts - 1, k)])
    pose = np.repeat(np.arange(count), starts)
    return _distinct(_searched(limit, np.tile(begin, (count, 1)), pose))


def _searched(limit: LimitState, begin: Array, pose: Index) -> DesignPoints:
    """Points reached by searches from scores (n, k) at poses (n,)."""
    search = _Search(limit, begin, pose)
    for _ in range(MOST):
        if search.done.all():
            break
        search.advance()
    return search.found()


def added_points(limit: LimitState, points: DesignPoints, scores: Array, values: Array, pose: Index) -> DesignPoints:
    """Design points found from the worst of the samples that the known points do not explain.

    Parameters
    ----------
    limit
        The limit state.
    points
        The known design points.
    scores, values
        Samples (m, k) and their values of the limit state (m,).
    pose
        Numbers of the poses of these values, (m,).
    """
    stray = np.flatnonzero(points.unexplained(scores, values))
    unit = scores / np.maximum(np.linalg.norm(scores, axis=1, keepdims=True), 1e-300)
    begin: list[int] = []
    for row in stray[np.argsort(values[stray], kind="stable")].tolist():
        if len(begin) < STRAYS and np.all(unit[begin] @ unit[row] < ALONG):
            begin.append(row)
    return _searched(limit, scores[begin], pose[begin])


def _directions(count: int, k: int) -> Array:
    """Unit vectors in k dimensions far apart from each other, the same ones at each call, (count, k)."""
    rng, found = np.random.default_rng(0), np.zeros((0, k))
    while len(found) < count:
        axes = np.linalg.qr(rng.normal(size=(k, k)))[0]
        found = np.concatenate([found, np.stack([axes, -axes], axis=1).reshape(-1, k)])
    return found[:count]


class _Search:
    """Iteration of many points at once towards the limit state, a row each."""

    def __init__(self, limit: LimitState, scores: Array, pose: Index) -> None:
        self.limit, self.pose = limit, pose
        self.scores, self.share = scores, np.ones(len(scores))
        self.value, self.gradient = limit.linearised(scores, pose)
        # Without a slope there is no step.
        self.lost = ~self._leads(self.value, self.gradient)
        self.done = self.lost.copy()
        self._settle(np.flatnonzero(~self.lost))

    @staticmethod
    def _leads(value: Array, gradient: Array) -> Mask:
        return np.asarray(
            np.isfinite(value) & np.isfinite(gradient).all(axis=-1) & (np.linalg.norm(gradient, axis=-1) > 0.0)
        )

    def _nearest(self, rows: Index) -> tuple[Array, Array, Array]:
        """Points of the tangent planes nearest to the median, their distances, and the lengths of the gradients."""
        slope = np.linalg.norm(self.gradient[rows], axis=-1)
        normal = -self.gradient[rows] / slope[:, None]
        beta = self.value[rows] / slope + np.sum(normal * self.scores[rows], axis=-1)
        return beta[:, None] * normal, beta, slope

    def _settle(self, rows: Index) -> None:
        """Mark the rows that have converged."""
        target, _, slope = self._nearest(rows)
        size = np.maximum(1.0, np.linalg.norm(target, axis=-1))
        left = np.linalg.norm(target - self.scores[rows], axis=-1)
        self.done[rows] = (left <= CLOSE * size) & (np.abs(self.value[rows]) <= CLOSE * size * slope)

    def advance(self) -> None:
        """One iteration: every row not yet converged tries a share of its step, halved if the last one was too long."""
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
        # The margin keeps rounding from refusing a step between two equal points.
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
        """The points reached, except those off the limit state."""
        rows = np.flatnonzero(~self.lost)
        target, beta, slope = self._nearest(rows)
        near = np.abs(self.value[rows]) <= 1e-3 * slope * np.maximum(1.0, np.abs(beta))
        rows, target, beta, slope = rows[near], target[near], beta[near], slope[near]
        normals = -self.gradient[rows] / slope[:, None]
        return DesignPoints(target, beta, normals, slope, self.pose[rows], self.done[rows])


def _distinct(points: DesignPoints) -> DesignPoints:
    """Each point once, without those much farther out than the nearest, sorted by pose, convergence and distance."""
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
    """The failed samples nearest to the median and apart from each other, as points without a slope.

    Parameters
    ----------
    failed
        Scores of samples that fail, (m, k).
    pose
        Number of the pose.
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
    """Points of several searches in one table."""
    return DesignPoints(*(np.concatenate([getattr(each, name) for each in several]) for name in FIELDS))


def distinct(several: list[DesignPoints]) -> DesignPoints:
    """Points of several searches without repetitions."""
    return _distinct(joined(several))


FIELDS = tuple(DesignPoints.__dataclass_fields__)
