"""Distribution of one input with the methods that other programs need."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.errors import FrameError
from ...distributions import Distribution, Interval, Normal
from ...propagation.correlation import over_scores
from ...quantiles import at_scores, probability

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Marginal:
    """Distribution of one input: densities, probabilities, quantiles and moments.

    Parameters
    ----------
    name
        Name of the input.
    distribution
        Its distribution.
    """

    name: str
    distribution: Distribution

    @property
    def _distribution(self) -> Any:
        return self.distribution

    def named(self) -> tuple[str, tuple[float, ...]] | None:
        """Name in `scipy.stats` with shape parameters, location and scale; None if `scipy.stats` does not have it."""
        if isinstance(self.distribution, Normal):
            return "norm", (self.distribution.loc, self.distribution.scale)
        if isinstance(self.distribution, Interval):
            return "uniform", (self.distribution.low, self.distribution.high - self.distribution.low)
        family = getattr(self.distribution, "dist", None)
        if family is None or not hasattr(family, "_parse_args"):
            return None
        shapes, location, scale = family._parse_args(*self._distribution.args, **self._distribution.kwds)
        return str(family.name), tuple(map(float, (*shapes, location, scale)))

    def pdf(self, x: ArrayLike) -> Array:
        """Probability density at `x`, (...)."""
        if not hasattr(self.distribution, "pdf"):
            raise FrameError(f"distribution of {self.name!r} has no density (pdf), which other programs need")
        return np.asarray(self._distribution.pdf(x), dtype=np.float64)

    def cdf(self, x: ArrayLike) -> Array:
        """Probability of a value below `x`, (...)."""
        return probability(self.name, self.distribution, np.asarray(x))

    def sf(self, x: ArrayLike) -> Array:
        """Probability of a value above `x`, (...); accurate in the upper tail if the distribution has ``sf``."""
        for name in ("sf", "ccdf"):
            if hasattr(self.distribution, name):
                return np.asarray(getattr(self.distribution, name)(x), dtype=np.float64)
        return 1.0 - self.cdf(x)

    def ppf(self, q: ArrayLike) -> Array:
        """Quantile at the probability `q`, (...)."""
        return np.asarray(self._distribution.ppf(q), dtype=np.float64)

    def isf(self, q: ArrayLike) -> Array:
        """Value exceeded with the probability `q`, (...)."""
        if hasattr(self.distribution, "isf"):
            return np.asarray(self._distribution.isf(q), dtype=np.float64)
        return self.ppf(1.0 - np.asarray(q))

    @property
    def support(self) -> tuple[float, float]:
        """Smallest and largest possible value, infinite if there is none."""
        if isinstance(self.distribution, Interval):
            return self.distribution.low, self.distribution.high
        low, high = (
            self._distribution.support()
            if hasattr(self.distribution, "support")
            else self._distribution.ppf(np.array([0.0, 1.0]))
        )
        return float(low), float(high)

    @cached_property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation."""
        if callable(getattr(self.distribution, "mean", None)) and callable(getattr(self.distribution, "std", None)):
            return float(self._distribution.mean()), float(self._distribution.std())
        values, weights = over_scores(self.name, self.distribution)
        mean = float(weights @ values)
        return mean, float(np.sqrt(weights @ (values - mean) ** 2))

    def mean(self) -> float:
        """Mean, in the unit of the input."""
        return self.moments[0]

    def std(self) -> float:
        """Standard deviation, in the unit of the input."""
        return self.moments[1]

    @cached_property
    def middle(self) -> tuple[float, float]:
        """Median, and half the distance between the quantiles at standard normal scores of -1 and 1.

        They exist for every distribution. The second is the unit of the steps of differences.
        """
        low, median, high = at_scores(self.distribution, np.array([-1.0, 0.0, 1.0])).tolist()
        return median, 0.5 * (high - low)
