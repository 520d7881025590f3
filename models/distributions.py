"""Distributions of uncertain inputs: their common methods, the normal and the uniform one, and their limits."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError

Array = NDArray[np.float64]

# Number of standard deviations of a normal distribution in half the width of a tolerance.
SIGMAS = 3.0


class Distribution(Protocol):
    """The method of frozen distributions of `scipy.stats` that sampling needs."""

    def ppf(self, q: Array, /) -> Any:
        """Quantile at probability `q`."""


class RandomVariable(Protocol):
    """The corresponding method of the newer random variables of `scipy.stats`, such as ``stats.Normal``."""

    def icdf(self, p: Array, /) -> Any:
        """Quantile at probability `p`."""


# Ways to give the distribution of an input.
Uncertain = Distribution | RandomVariable | tuple[float, float] | str


class ContinuousDistribution(ABC):
    """Distribution of a real number with the methods of those of `scipy.stats`."""

    @abstractmethod
    def ppf(self, q: Array, /) -> Array:
        """Quantile at probability `q`.

        Parameters
        ----------
        q
            Probabilities in (0, 1), (...).

        Returns
        -------
        ndarray
            Quantiles, (...).
        """

    @abstractmethod
    def pdf(self, x: Array, /) -> Array:
        """Probability density.

        Parameters
        ----------
        x
            Values, (...).

        Returns
        -------
        ndarray
            Density, (...), in the inverse of the unit of the values.
        """

    @abstractmethod
    def cdf(self, x: Array, /) -> Array:
        """Probability of a value below `x`.

        Parameters
        ----------
        x
            Values, (...).

        Returns
        -------
        ndarray
            Probabilities, (...).
        """

    @abstractmethod
    def mean(self) -> float:
        """Expected value of the distribution.

        Returns
        -------
        float
            Mean, in the unit of the values.
        """

    @abstractmethod
    def std(self) -> float:
        """Standard deviation.

        Returns
        -------
        float
            Standard deviation, in the unit of the values.
        """

    @abstractmethod
    def support(self) -> tuple[float, float]:
        """Smallest and largest possible value, which may be infinite.

        Returns
        -------
        tuple
            Lower and upper limit, in the unit of the values.
        """


@dataclass(frozen=True)
class Normal(ContinuousDistribution):
    """Normal distribution; its quantiles equal those of `scipy.stats.norm`, which takes long to import.

    Parameters
    ----------
    loc, scale
        Mean and standard deviation, in the unit of the values.
    """

    loc: float
    scale: float

    def ppf(self, q: Array, /) -> Array:
        """Quantile at probability `q`."""
        from scipy.special import ndtri

        return np.asarray(ndtri(q) * self.scale + self.loc)

    def pdf(self, x: Array, /) -> Array:
        """Probability density."""
        off = (x - self.loc) / self.scale
        return np.asarray(np.exp(-0.5 * off**2) / (np.sqrt(2.0 * np.pi) * self.scale))

    def cdf(self, x: Array, /) -> Array:
        """Probability of a value below `x`."""
        from scipy.special import ndtr

        return np.asarray(ndtr((x - self.loc) / self.scale))

    def isf(self, q: Array, /) -> Array:
        """Value exceeded with probability `q`."""
        from scipy.special import ndtri

        return np.asarray(-ndtri(q) * self.scale + self.loc)

    def sf(self, x: Array, /) -> Array:
        """Probability of a value above `x`."""
        from scipy.special import ndtr

        return np.asarray(ndtr((self.loc - x) / self.scale))

    def logpdf(self, x: Array, /) -> Array:
        """Logarithm of the probability density."""
        off = (x - self.loc) / self.scale
        return np.asarray(-0.5 * off**2 - np.log(np.sqrt(2.0 * np.pi) * self.scale))

    def mean(self) -> float:
        """Expected value, where the density is greatest."""
        return self.loc

    def std(self) -> float:
        """Standard deviation."""
        return self.scale

    def support(self) -> tuple[float, float]:
        """All numbers."""
        return -np.inf, np.inf


@dataclass(frozen=True)
class Interval(ContinuousDistribution):
    """Uniform distribution, for an input of which only the bounds are known.

    This follows the Guide to the Expression of Uncertainty in Measurement (JCGM 100:2008, 4.3.7).

    Parameters
    ----------
    low, high
        Bounds, in the unit of the input.
    """

    low: float
    high: float

    def __post_init__(self) -> None:
        if not (np.isfinite(self.low) and np.isfinite(self.high) and self.low < self.high):
            raise FrameError(f"interval ({self.low}, {self.high}): give two finite bounds, the lower one first")

    def ppf(self, q: Array, /) -> Array:
        """Quantile at probability `q`."""
        return np.asarray(self.low + (self.high - self.low) * np.asarray(q))

    def isf(self, q: Array, /) -> Array:
        """Value exceeded with probability `q`.

        Parameters
        ----------
        q
            Probabilities, (...).

        Returns
        -------
        ndarray
            Values, (...), in the unit of the input.
        """
        return np.asarray(self.high - (self.high - self.low) * np.asarray(q))

    def pdf(self, x: Array, /) -> Array:
        """Probability density."""
        inside = (x >= self.low) & (x <= self.high)
        return np.where(inside, 1.0 / (self.high - self.low), 0.0)

    def cdf(self, x: Array, /) -> Array:
        """Probability of a value below `x`."""
        return np.clip((np.asarray(x) - self.low) / (self.high - self.low), 0.0, 1.0)

    def sf(self, x: Array, /) -> Array:
        """Probability of a value above `x`.

        Parameters
        ----------
        x
            Values, (...).

        Returns
        -------
        ndarray
            Probabilities, (...).
        """
        return np.clip((self.high - np.asarray(x)) / (self.high - self.low), 0.0, 1.0)

    def mean(self) -> float:
        """Expected value, half way between the limits."""
        return 0.5 * (self.low + self.high)

    def std(self) -> float:
        """Standard deviation."""
        return (self.high - self.low) / float(np.sqrt(12.0))

    def support(self) -> tuple[float, float]:
        """Bounds."""
        return self.low, self.high


def ends(distribution: Distribution) -> tuple[float, float]:
    """Smallest and largest value; on an unbounded side the quantile at a normal score of ±3."""
    from scipy.special import ndtr

    found = []
    for limit, score in ((0.0, -SIGMAS), (1.0, SIGMAS)):
        end = float(distribution.ppf(np.array(limit)))
        found.append(end if np.isfinite(end) else float(distribution.ppf(ndtr(np.array(score)))))
    return found[0], found[1]
