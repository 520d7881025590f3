"""What other programs ask of the distribution of one input, whatever it was given as."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.errors import FrameError
from ...distributions import Distribution, Interval, Normal, at_scores, probability
from ...propagation.correlation import over_scores

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Marginal:
    """Distribution of one input: densities, probabilities, quantiles and moments.

    Parameters
    ----------
    name
        Name of the input.
    law
        Its distribution.
    """

    name: str
    law: Distribution

    @property
    def _law(self) -> Any:
        return self.law

    def named(self) -> tuple[str, tuple[float, ...]] | None:
        """Name in `scipy.stats` with shape parameters, location and scale; None of what has no such name."""
        if isinstance(self.law, Normal):
            return "norm", (self.law.mean, self.law.deviation)
        if isinstance(self.law, Interval):
            return "uniform", (self.law.low, self.law.high - self.law.low)
        family = getattr(self.law, "dist", None)
        if family is None or not hasattr(family, "_parse_args"):
            return None
        shapes, location, scale = family._parse_args(*self._law.args, **self._law.kwds)
        return str(family.name), tuple(map(float, (*shapes, location, scale)))

    def pdf(self, x: ArrayLike) -> Array:
        """Probability density at `x`, (...)."""
        if not hasattr(self.law, "pdf"):
            raise FrameError(f"distribution of {self.name!r} has no density (pdf), which other programs need")
        return np.asarray(self._law.pdf(x), dtype=np.float64)

    def cdf(self, x: ArrayLike) -> Array:
        """Probability of a value below `x`, (...)."""
        return probability(self.name, self.law, np.asarray(x))

    def sf(self, x: ArrayLike) -> Array:
        """Probability of a value above `x`, (...), exact in the upper tail where the distribution has an own one."""
        for name in ("sf", "ccdf"):
            if hasattr(self.law, name):
                return np.asarray(getattr(self.law, name)(x), dtype=np.float64)
        return 1.0 - self.cdf(x)

    def ppf(self, q: ArrayLike) -> Array:
        """Quantile at the probability `q`, (...)."""
        return np.asarray(self._law.ppf(q), dtype=np.float64)

    def isf(self, q: ArrayLike) -> Array:
        """Value that is exceeded with the probability `q`, (...)."""
        if hasattr(self.law, "isf"):
            return np.asarray(self._law.isf(q), dtype=np.float64)
        return self.ppf(1.0 - np.asarray(q))

    @property
    def support(self) -> tuple[float, float]:
        """Bounds of what can be drawn, infinite where there are none."""
        if isinstance(self.law, Interval):
            return self.law.low, self.law.high
        low, high = self._law.support() if hasattr(self.law, "support") else self._law.ppf(np.array([0.0, 1.0]))
        return float(low), float(high)

    @cached_property
    def moments(self) -> tuple[float, float]:
        """Mean and standard deviation."""
        if isinstance(self.law, Normal):
            return self.law.mean, self.law.deviation
        if callable(getattr(self.law, "mean", None)) and callable(getattr(self.law, "std", None)):
            return float(self._law.mean()), float(self._law.std())
        values, weights = over_scores(self.name, self.law)
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
        """Median, and half of the distance of the quantiles one standard normal score either side of it.

        Every distribution has them, and the second is the unit of differences by the input.
        """
        low, median, high = at_scores(self.law, np.array([-1.0, 0.0, 1.0])).tolist()
        return median, 0.5 * (high - low)
