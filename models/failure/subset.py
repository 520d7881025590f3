"""Probability of failure by subset simulation: a product of larger conditional probabilities.

S.-K. Au & J. L. Beck, Probabilistic Engineering Mechanics 16, 2001, doi:10.1016/S0266-8920(01)00019-4; candidates of
the chains by conditional sampling as in I. Papaioannou et al., Probabilistic Engineering Mechanics 41, 2015,
doi:10.1016/j.probengmech.2015.06.006.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
# Function of scores (m, k): values (m,) of the limit state.
Value = Callable[[Array], Array]
Enough = Callable[[Array, Array], bool]

# Share of the samples of a level that start the chains of the next one; number of levels after which the probability
# counts as 0.
SHARE, MOST = 0.1, 40
# Best share of accepted candidates, and the spread of the first candidates.
BEST, SPREAD = 0.44, 0.6


class Subset(NamedTuple):
    """Probability of failure, and the samples of the last level that failed, (m, k)."""

    probability: float
    failed: Array


def subset_simulation(
    value: Value, size: int, rng: np.random.Generator, samples: int, enough: Enough | None = None
) -> Subset:
    """Probability of failure by subset simulation.

    Parameters
    ----------
    value
        The limit state.
    size
        Number of inputs.
    rng
        Random number generator.
    samples
        Number of samples of a level, a multiple of ten.
    enough
        Function of the scores (m, k) and values (m,) of the first samples, which are independent. If it returns True,
        the run ends with NaN for the probability.
    """
    chains = int(SHARE * samples)
    scores = rng.normal(size=(samples, size))
    probability, spread = 1.0, SPREAD
    table = value(scores)[None]
    if enough is not None and enough(scores, table[0]):
        return Subset(np.nan, np.zeros((0, size)))
    for _ in range(MOST):
        flat = table.reshape(-1)
        order = np.argsort(flat, kind="stable")
        threshold = float(0.5 * (flat[order[chains - 1]] + flat[order[chains]]))
        last = threshold <= 0.0
        inside = table <= (0.0 if last else threshold)
        if inside.all():
            # If most samples have the same value, no further level is possible: the failures are counted.
            last, inside = True, table <= 0.0
        share = float(inside.mean())
        if share == 0.0:
            return Subset(0.0, np.zeros((0, size)))
        probability *= share
        if last:
            break
        begin = order[:chains]
        if np.count_nonzero(inside) > chains:
            # Among samples with equal values none is preferred: the chains start at random ones of the level.
            begin = rng.choice(np.flatnonzero(inside), chains, replace=False)
        start = scores.reshape(-1, size)[begin]
        scores, table, spread = _chains(value, start, flat[begin], threshold, rng, samples // chains, spread)
    else:
        return Subset(0.0, np.zeros((0, size)))
    failed = scores.reshape(-1, size)[table.reshape(-1) <= 0.0]
    return Subset(probability, failed)


def _chains(
    value: Value, start: Array, found: Array, threshold: float, rng: np.random.Generator, length: int, spread: float
) -> tuple[Array, Array, float]:
    """Markov chains below a threshold, (length, chains, k), their values, and the spread for the next chains."""
    scores, table = np.empty((length, *start.shape)), np.empty((length, len(start)))
    scores[0], table[0] = start, found
    for step in range(1, length):
        candidate = np.sqrt(1.0 - spread**2) * scores[step - 1] + spread * rng.normal(size=start.shape)
        there = value(candidate)
        taken = there <= threshold
        scores[step] = np.where(taken[:, None], candidate, scores[step - 1])
        table[step] = np.where(taken, there, table[step - 1])
        # The spread is adapted at every step because a level may be much narrower than the last.
        spread = min(1.0, spread * float(np.exp(taken.mean() - BEST)))
    return scores, table, spread
