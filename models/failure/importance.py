"""Probability of failure by importance sampling about the design points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .design_points import DesignPoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]
# Function of scores (problems, m, k) and numbers of the problems (problems,): values of the limit state (problems, m).
Values = Callable[[Array, Index], Array]

# Share of the samples drawn from the standard normal density itself, so that failures away from the points are seen.
AS_THEY_ARE = 0.1
# Samples of a problem are drawn in multiples of BLOCK; their number grows at most by the factor GROWTH at a time, and
# at most TOGETHER are drawn at once for all problems.
BLOCK, GROWTH, TOGETHER = 500, 10, 2**16
# Factor on the number of samples expected to be enough.
MORE = 1.05
# Number of failures below which the estimated error is not trusted.
FEW = 10


@dataclass(frozen=True, eq=False)
class Estimate:
    """Probabilities (problems,), their standard errors with degrees of freedom, and numbers of samples."""

    probability: Array
    standard_error: Array
    samples: Index
    freedom: float = np.inf


@dataclass(frozen=True, eq=False)
class Mixture:
    """Mixture of normal densities of unit variance about several points, for each problem.

    Attributes
    ----------
    centres
        Means of the densities, (problems, j, k).
    shares
        Weights of the densities, (problems, j); they add up to 1 for each problem.
    """

    centres: Array
    shares: Array

    @classmethod
    def about(cls, points: DesignPoints, size: int, problems: int, *, together: bool = False) -> Mixture:
        """Mixture about design points, each with a weight in proportion to the probability beyond it.

        Parameters
        ----------
        points
            Design points of all poses.
        size
            Number of inputs.
        problems
            Number of poses.
        together
            Whether the points of all poses serve one problem, that of failing at any pose.
        """
        pose = np.zeros_like(points.pose) if together else points.pose
        count = 1 if together else problems
        most = int(np.bincount(pose, minlength=count).max(initial=0)) + 1
        centres, shares = np.zeros((count, most, size)), np.zeros((count, most))
        shares[:, 0] = AS_THEY_ARE
        for problem in range(count):
            mine = np.flatnonzero(pose == problem)
            # At a farther point the limit state may curve towards the median: it has at least a tenth of the largest.
            weight = np.maximum(points.first_order[mine], 0.1 * points.first_order[mine].max(initial=0.0))
            centres[problem, 1 : len(mine) + 1] = points.scores[mine]
            shares[problem, 1 : len(mine) + 1] = weight * (1.0 - AS_THEY_ARE) / max(weight.sum(), 1e-300)
        return cls(centres, shares / shares.sum(axis=1, keepdims=True))

    def draw(self, rng: np.random.Generator, which: Index, count: int) -> tuple[Array, Array]:
        """Samples (problems, count, k), and the ratio of the standard normal density to that of the mixture there."""
        centres, shares = self.centres[which], self.shares[which]
        chosen = (rng.random((len(which), count, 1)) > np.cumsum(shares, axis=1)[:, None, :-1]).sum(axis=-1)
        scores = rng.normal(size=(len(which), count, centres.shape[-1]))
        scores += np.take_along_axis(centres, chosen[..., None], axis=1)
        exponent = np.einsum("pmk,pjk->pmj", scores, centres) - 0.5 * np.sum(centres**2, axis=-1)[:, None]
        most = exponent.max(axis=-1, keepdims=True)
        ratio = np.exp(-most[..., 0]) / np.sum(shares[:, None] * np.exp(exponent - most), axis=-1)
        return scores, ratio


def importance_sampling(
    values: Values, mixture: Mixture, rng: np.random.Generator, *, accuracy: float, most: int
) -> Estimate:
    """Sample until every probability is accurate enough: one block first, then as many as the errors so far call for.

    Few large calls are used because a call of the limit state for few samples often takes as long as one for many.

    Parameters
    ----------
    values
        The limit state at each problem.
    mixture
        Density from which the samples are drawn.
    rng
        Random number generator.
    accuracy
        Coefficient of variation at which the sampling of a problem ends.
    most
        Largest number of samples of a problem.
    """
    problems = len(mixture.centres)
    first, second, samples, hits = (np.zeros(problems) for _ in range(4))
    active, count = np.arange(problems), min(BLOCK, most)
    while active.size:
        scores, ratio = mixture.draw(rng, active, count)
        failed = values(scores, active) <= 0.0
        weight = np.where(failed, ratio, 0.0)
        first[active] += weight.sum(axis=1)
        second[active] += (weight**2).sum(axis=1)
        hits[active] += failed.sum(axis=1)
        samples[active] += count
        mean = first[active] / samples[active]
        error = np.sqrt(np.maximum(second[active] / samples[active] - mean**2, 0.0) / samples[active])
        few = hits[active] < FEW
        left = ~((~few & (error <= accuracy * mean)) | (samples[active] + BLOCK > most))
        if not left.any():
            break
        # With few failures the number of samples is doubled.
        off = np.where(few, np.sqrt(2.0), error / np.maximum(accuracy * mean, 1e-300))[left]
        active = active[left]
        count = _wanted(off, samples[active], most)
    mean = first / samples
    error = np.sqrt(np.maximum(second / samples - mean**2, 0.0) / (samples - 1.0))
    # Without a failure: the 95 % bound 3 / n for the n samples of the standard normal density, as a standard error.
    error = np.where(hits > 0.0, error, 3.0 / (1.96 * AS_THEY_ARE * samples))
    # The mean weight may slightly exceed one if nearly everything fails.
    return Estimate(np.minimum(mean, 1.0), error, samples.astype(np.int64))


def _wanted(off: Array, samples: Array, most: int) -> int:
    """Number of samples to draw next for each problem, from the ratio of its error to the accuracy, (problems,).

    It is the median of the numbers needed: some problems get more than they need, the others continue.
    """
    need = samples * np.clip(MORE * off**2 - 1.0, 0.0, GROWTH - 1.0)
    blocks = np.ceil(np.median(need) / BLOCK)
    room = np.floor(min(float((most - samples).min()), TOGETHER / len(samples)) / BLOCK)
    return BLOCK * int(max(1.0, min(blocks, room)))
