"""The methods of reliability: FORM, SORM, importance sampling, subset simulation and plain Monte Carlo."""

from __future__ import annotations

import warnings
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from ...framework.errors import FrameError, SampleWarning
from ..sampling import stream
from .design_points import DesignPoints, added_points, distinct, joined, likely
from .edges import Edges, beyond_edges
from .importance import Estimate, Mixture, importance_sampling
from .limit_state import LimitState
from .second_order import STEP
from .subset import Value, subset_simulation

Array = NDArray[np.float64]

# Number of samples of a level of the subset simulation that explores the failures.
EXPLORED = 500
# Largest number of rounds of searches from unexplained samples.
SEARCHES = 3
# Curvature from which on the differences must have met an edge.
SHARP = 0.1 / STEP
# Number of runs of subset simulation.
RUNS = 5


@dataclass(frozen=True, eq=False)
class LimitStateProblems:
    """One limit state at several poses; each pose is a problem of its own, or all together are one."""

    state: LimitState
    together: bool
    root: np.random.SeedSequence

    @property
    def problems(self) -> int:
        """Number of probabilities to find."""
        return 1 if self.together else self.state.poses or 1

    def _where(self, problem: int) -> str:
        """End of a sentence that names the pose; empty if there is one problem."""
        return f" at pose number {problem}" if self.state.poses and not self.together else ""

    def _values(self, scores: Array, which: NDArray[np.int64]) -> Array:
        if self.together:
            return self.state.worst(scores[0])[None]
        return self.state.values(scores, np.broadcast_to(which[:, None], scores.shape[:2]))

    def first_order(self, points: DesignPoints) -> Estimate:
        """Probabilities beyond the tangent planes at the points."""
        return self._beyond(points.planes(), points.pose)

    def second_order(self, points: DesignPoints) -> Estimate:
        """Probabilities beyond the paraboloids at the points."""
        edges = points.paraboloids(self.state)
        if edges.curvature is not None:
            # The first point of each pose is the nearest.
            nearest = np.unique(points.pose, return_index=True)[1]
            kinks = nearest[(np.abs(edges.curvature[nearest]) >= SHARP).any(axis=1)]
            if kinks.size:
                problem = 0 if self.together else int(points.pose[kinks[0]])
                raise FrameError(
                    f"sorm: the design point{self._where(problem)}, at a distance of {points.beta[kinks[0]]:.3g} from "
                    "the median, lies at an edge of the limit state, where no paraboloid fits: use the method "
                    "'importance'"
                )
        known = ~np.isnan(edges.probability)
        if not known.any():
            raise FrameError("sorm: no point that was found is the nearest to the median: use the method 'importance'")
        return self._beyond(edges[known], points.pose[known])

    def _beyond(self, edges: Edges, poses: NDArray[np.int64]) -> Estimate:
        """Probabilities beyond the surfaces at the points."""
        pose = np.zeros_like(poses) if self.together else poses
        out = np.zeros(self.problems)
        for problem in np.unique(pose):
            mine, rng = pose == problem, stream(self.root, f"planes {problem}")
            out[problem] = beyond_edges(edges[mine], poses[mine], rng)
            if out[problem] == 0.0 and (edges.beta[mine] < 0.0).any():
                where = self._where(int(problem))
                raise FrameError(
                    f"the median fails{where}, and the surfaces found around it enclose almost no probability: planes "
                    "and paraboloids cannot represent a small closed surface; use the method 'importance'"
                )
        lost = np.setdiff1d(np.arange(self.problems), pose)
        if lost.size:
            where = self._where(int(lost[0]))
            raise FrameError(f"no failure was found{where}: use the method 'importance' or 'subset', or more starts")
        return Estimate(out, np.full(self.problems, np.nan), np.zeros(self.problems, dtype=np.int64))

    def importance(self, points: DesignPoints, accuracy: float, most: int) -> tuple[DesignPoints, Estimate]:
        """The points, with those found by exploration, and the estimate by importance sampling."""
        points, near = self._explored(points)
        mixture = Mixture.about(joined([points, *near]), self.state.size, self.problems, together=self.together)
        rng = stream(self.root, "importance")
        return points, importance_sampling(self._values, mixture, rng, accuracy=accuracy, most=most)

    def _explored(self, points: DesignPoints) -> tuple[DesignPoints, list[DesignPoints]]:
        """More design points, and failed samples of a subset simulation.

        The samples of the first level show whether the points explain the limit state; unexplained ones are where
        further searches begin. If the points explain it in the end, the simulation stops there. One problem of several
        is explored only if some search for it did not converge.
        """
        near = []
        for problem in range(self.problems):
            own = points[(points.pose == problem) | self.together]
            if own.converged.size and own.converged.all() and self.problems > 1:
                continue
            explorer = Explorer(self, problem, own)
            rng = stream(self.root, f"exploration {problem}")
            value = self._of_one(np.array([problem]))
            explored = subset_simulation(value, self.state.size, rng, EXPLORED, explorer)
            near.append(likely(explored.failed, problem))
            points = distinct([points, *explorer.further])
        return points, near

    def _of_one(self, pose: NDArray[np.int64]) -> Value:
        return lambda scores: self._values(scores[None], pose)[0]

    def worst_pose(self, scores: Array, problem: int) -> NDArray[np.int64]:
        """Number of the pose (m,) at which scores (m, k) are closest to failure, among the poses of a problem."""
        if not self.together:
            return np.full(len(scores), problem)
        return np.asarray(np.argmin(self.state.at_all_poses(scores), axis=1))

    def random(self, most: int) -> Estimate:
        """Share of failures among `most` samples."""
        scores = stream(self.root, "random").normal(size=(self.problems, most, self.state.size))
        share = (self._values(scores, np.arange(self.problems)) <= 0.0).mean(axis=1)
        # Without a failure: the 95 % bound 3 / n, as a standard error.
        error = np.where(share > 0.0, np.sqrt(share * (1.0 - share) / most), 3.0 / (1.96 * most))
        return Estimate(share, error, np.full(self.problems, most))

    def subset(self, samples: int, points: DesignPoints) -> Estimate:
        """Mean of several runs of subset simulation, with the standard error from their spread.

        The samples within a run depend on each other, so a run alone gives no reliable error.
        """
        out = np.zeros((RUNS, self.problems))
        failed: dict[int, list[Array]] = {problem: [] for problem in range(self.problems)}
        for (run, problem), _ in np.ndenumerate(out):
            pose, rng = np.array([problem]), stream(self.root, f"subset {problem} {run}")
            found = subset_simulation(self._of_one(pose), self.state.size, rng, 10 * (samples // 10))
            out[run, problem] = found.probability
            failed[problem].append(found.failed)
        error = out.std(axis=0, ddof=1) / np.sqrt(RUNS)
        # Without a failure: the 95 % bound 3 / n for the samples of the first levels, as a standard error.
        error = np.where(out.any(axis=0), error, 3.0 / (1.96 * RUNS * samples))
        missed = np.zeros(self.problems)
        for problem, rows in failed.items():
            own = points[(points.pose == problem) | self.together]
            missed[problem] = own.first_order[own.missing(np.concatenate(rows))].max(initial=0.0)
        self._warn(missed, error)
        error = np.where(missed > error, np.hypot(error, missed), error)
        return Estimate(out.mean(axis=0), error, np.full(self.problems, RUNS * samples), RUNS - 1.0)

    def _warn(self, missed: Array, error: Array) -> None:
        """Warn if all runs missed a likely failure with a first-order probability `missed` above the error."""
        if not np.any(missed > error):
            return
        worst = int(np.argmax(np.where(missed > error, missed, 0.0)))
        where = self._where(worst)
        warnings.warn(
            f"subset simulation missed a likely failure{where}: no sample lies beyond the tangent plane at one of the "
            f"design points, where the probability is {missed[worst]:.3g} to first order. The estimate is too low, and "
            "its standard error was increased by that: use the method 'importance', or more samples",
            SampleWarning,
            stacklevel=4,
        )


@dataclass(eq=False)
class Explorer:
    """Search for further design points of a problem until they explain the samples."""

    run: LimitStateProblems
    problem: int
    points: DesignPoints
    further: list[DesignPoints] = field(default_factory=list)

    def __call__(self, scores: Array, values: Array) -> bool:
        """Whether the points, with those found here, explain samples (m, k) with values (m,)."""
        for _ in range(SEARCHES):
            if not self.points.converged.all() or self.points.explain(scores, values):
                break
            pose = self.run.worst_pose(scores, self.problem)
            found = added_points(self.run.state, self.points, scores, values, pose)
            known = len(self.points.beta)
            self.further.append(found)
            self.points = distinct([self.points, found])
            if len(self.points.beta) == known:
                break
        return self.points.explain(scores, values)
