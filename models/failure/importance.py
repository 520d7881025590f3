"""Probability of failure from samples about the most likely failures."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .design_points import DesignPoints

Array = NDArray[np.float64]
Index = NDArray[np.int64]
# Values (problems, m) of the limit states with these numbers, (problems,), at scores (problems, m, k).
Values = Callable[[Array, Index], Array]

# Share of the samples that are drawn as they are, so that failures away from the points found are not missed unseen.
AS_THEY_ARE = 0.1
# Samples of a problem are multiples of these; by how many times they grow at once, and how many are drawn together.
BLOCK, GROWTH, TOGETHER = 500, 10, 2**16
# Samples beyond those that are expected to be enough, so that they mostly are.
MORE = 1.05
# Failures below which a spread is not believed.
FEW = 10


@dataclass(frozen=True, eq=False)
class Estimate:
    """Probabilities of some problems, (problems,), with their standard errors and numbers of samples.

    The errors have so many degrees of freedom.
    """

    probability: Array
    standard_error: Array
    samples: Index
    freedom: float = np.inf


@dataclass(frozen=True, eq=False)
class Mixture:
    """Normal densities of unit variance about several points of each problem.

    Attributes
    ----------
    centres
        Points (problems, j, k).
    shares
        Of the samples, (problems, j); sums are 1.
    """

    centres: Array
    shares: Array

    @classmethod
    def about(cls, points: DesignPoints, size: int, problems: int, *, together: bool = False) -> Mixture:
        """About design points, each of a share that grows with the probability beyond it.

        Parameters
        ----------
        points
            Design points of all poses.
        size
            Number of inputs.
        problems
            Number of poses.
        together
            Whether the points of all poses serve the one problem of failing anywhere.
        """
        pose = np.zeros_like(points.pose) if together else points.pose
        count = 1 if together else problems
        most = int(np.bincount(pose, minlength=count).max(initial=0)) + 1
        centres, shares = np.zeros((count, most, size)), np.zeros((count, most))
        shares[:, 0] = AS_THEY_ARE
        for problem in range(count):
            mine = np.flatnonzero(pose == problem)
            # A point further out may bend towards the median: it keeps a tenth of the nearest one's share.
            weight = np.maximum(points.first_order[mine], 0.1 * points.first_order[mine].max(initial=0.0))
            centres[problem, 1 : len(mine) + 1] = points.scores[mine]
            shares[problem, 1 : len(mine) + 1] = weight * (1.0 - AS_THEY_ARE) / max(weight.sum(), 1e-300)
        return cls(centres, shares / shares.sum(axis=1, keepdims=True))

    def draw(self, rng: np.random.Generator, which: Index, count: int) -> tuple[Array, Array]:
        """Samples (problems, count, k), and the standard normal density there over that of the mixture."""
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
    """Sample until every problem is known well enough: a block, and then as many at a time as seem to be wanted.

    A call of the limit states for few samples often takes as long as one for many.

    Parameters
    ----------
    values
        The limit states.
    mixture
        Where to sample.
    rng
        Source of the samples.
    accuracy
        Coefficient of variation that is enough.
    most
        Samples of a problem after which it is left as it is.
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
        # Where little is known, as many again.
        off = np.where(few, np.sqrt(2.0), error / np.maximum(accuracy * mean, 1e-300))[left]
        active = active[left]
        count = _wanted(off, samples[active], most)
    mean = first / samples
    error = np.sqrt(np.maximum(second / samples - mean**2, 0.0) / (samples - 1.0))
    # Where nothing failed, what a 95 % bound from the samples drawn as they are leaves open.
    error = np.where(hits > 0.0, error, 3.0 / (1.96 * AS_THEY_ARE * samples))
    # Weights add up to a little more than one where nearly everything fails.
    return Estimate(np.minimum(mean, 1.0), error, samples.astype(np.int64))


def _wanted(off: Array, samples: Array, most: int) -> int:
    """How many more samples of each problem to draw, from how many times their errors are what is wanted, (problems,).

    They are what half of the problems need: others get more than that, or go on.
    """
    need = samples * np.clip(MORE * off**2 - 1.0, 0.0, GROWTH - 1.0)
    blocks = np.ceil(np.median(need) / BLOCK)
    room = np.floor(min(float((most - samples).min()), TOGETHER / len(samples)) / BLOCK)
    return BLOCK * int(max(1.0, min(blocks, room)))
