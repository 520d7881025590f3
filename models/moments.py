"""Mean, spread and shape of a stream of samples, in memory that does not grow with it."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .intervals import ConfidenceInterval, by_error

Array = NDArray[np.float64]

NAN_POLICIES = ("omit", "propagate", "raise")


@dataclass(frozen=True, eq=False)
class Moments:
    """Count, mean and sums of powers of the deviations from it, up to the fourth.

    Two sets merge without loss (Chan, Golub & LeVeque, American Statistician 37, 1983,
    doi:10.1080/00031305.1983.10483115, for the second power; Pébay, Sandia report SAND2008-6212, 2008, for the third
    and fourth).

    Parameters
    ----------
    n
        Number of samples; (...) where it differs, as NaN do not count.
    mean
        Mean, (...).
    second, third, fourth
        Sums over the samples of (x − mean)², (x − mean)³, (x − mean)⁴, (...).
    """

    n: int | NDArray[np.int64]
    mean: Array
    second: Array
    third: Array
    fourth: Array

    @classmethod
    def of(cls, samples: Array, nan_policy: str = "propagate", room: tuple[Array, Array] | None = None) -> Moments:
        """Moments of `samples` (n, ...) along the first axis; with ``"omit"`` of those that are not NaN.

        They are computed in the two arrays of `room`, like `samples` and no shorter, where it is given: memory of one
        block after the other costs more than its sums.
        """
        off, square = (np.empty_like(samples), np.empty_like(samples)) if room is None else room
        off, square = off[: len(samples)], square[: len(samples)]
        n: int | NDArray[np.int64] = len(samples)
        with np.errstate(invalid="ignore"):
            mean = samples.mean(axis=0)
        # A mean tells of NaN without another look at every sample.
        if nan_policy == "omit" and np.isnan(mean).any() and np.isnan(samples).any():
            there = ~np.isnan(samples)
            n = np.count_nonzero(there, axis=0)
            with np.errstate(invalid="ignore"):
                mean = np.sum(samples, axis=0, where=there) / np.where(n > 0, n, np.nan)
            off[...] = np.where(there, samples - mean, 0.0)
        else:
            np.subtract(samples, mean, out=off)
        np.multiply(off, off, out=square)
        if off.ndim > 1 and off.strides[0] == off.itemsize:
            # Samples lie side by side: products are summed without being written.
            first, last = np.moveaxis(off, 0, -1), np.moveaxis(square, 0, -1)
            pairs = (first, first), (first, last), (last, last)
            return cls(n, mean, *(np.asarray(np.vecdot(a, b)) for a, b in pairs))
        second = square.sum(axis=0)
        off *= square
        square *= square
        return cls(n, mean, second, off.sum(axis=0), square.sum(axis=0))

    def merge(self, other: Moments) -> Moments:
        """Moments of both sets of samples together."""
        a, b, n = self.n, other.n, self.n + other.n
        empty = np.equal(a, 0)
        # The mean of no samples is NaN, and nothing is apart from it.
        d = np.where(empty | np.equal(b, 0), 0.0, other.mean - self.mean)[()]
        step = d / np.maximum(n, 1)
        second = self.second + other.second + d * step * a * b
        third = (
            self.third + other.third + d * step**2 * a * b * (a - b) + 3.0 * step * (a * other.second - b * self.second)
        )
        fourth = (
            self.fourth
            + other.fourth
            + d * step**3 * a * b * (a * a - a * b + b * b)
            + 6.0 * step**2 * (a * a * other.second + b * b * self.second)
            + 4.0 * step * (a * other.third - b * self.third)
        )
        return Moments(n, np.where(empty, other.mean, self.mean)[()] + step * b, second, third, fourth)

    @property
    def std(self) -> Array:
        """Standard deviation with n − 1 in the denominator, (...); NaN of less than two samples."""
        return np.asarray(np.sqrt(self.second / (self._enough - 1)))

    @property
    def _enough(self) -> Array:
        """Number of samples, NaN where there are less than two, (...)."""
        return np.where(np.greater(self.n, 1), self.n, np.nan)

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean of independent samples, s/√n, (...)."""
        return np.asarray(self.std / np.sqrt(self._enough))

    @property
    def std_standard_error(self) -> Array:
        """Standard error of `std`, (...), whatever the distribution.

        From var(s²) = (m₄ − s⁴ (n − 3)/(n − 1))/n (Mood, Graybill & Boes, Introduction to the Theory of Statistics,
        3rd ed., 1974, section VI.2) and ds = d(s²)/(2 s).
        """
        n, square = self._enough, self.std**2
        spread = np.maximum(self.fourth / n - square**2 * (n - 3) / (n - 1), 0.0) / n
        with np.errstate(divide="ignore", invalid="ignore"):
            error = np.sqrt(spread) / (2.0 * self.std)
        return np.where(square == 0.0, 0.0, error)


def checked_policy(nan_policy: str) -> str:
    """What to do with samples that are NaN, checked."""
    if nan_policy not in NAN_POLICIES:
        raise FrameError(f"nan_policy is {nan_policy!r}: choose one of {', '.join(NAN_POLICIES)}")
    return nan_policy


class Statistics(ABC):
    """What samples of a result say of it, in its own shape (...), by way of their moments."""

    @property
    @abstractmethod
    def moments(self) -> Moments:
        """Count, mean and sums of powers of the deviations, (...)."""

    @property
    @abstractmethod
    def missing(self) -> NDArray[np.int64]:
        """Number of samples that are NaN, (...)."""

    @property
    def mean(self) -> Array:
        """Mean, (...)."""
        return self.moments.mean

    @property
    def std(self) -> Array:
        """Standard deviation with n − 1 in the denominator, (...)."""
        return self.moments.std

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean, (...)."""
        return self.moments.standard_error

    @property
    def std_standard_error(self) -> Array:
        """Standard error of the standard deviation, (...)."""
        return self.moments.std_standard_error

    def confidence_interval(self, level: float = 0.95, of: str | float = "mean") -> ConfidenceInterval:
        """Confidence interval of a number of independent samples; those of sequences and Latin samples do better.

        Parameters
        ----------
        level
            Probability that the interval holds the true value.
        of
            ``"mean"``, by Student's distribution; ``"std"``, by its standard error; or the probability of a quantile,
            by the ordered samples, whatever the distribution.

        Returns
        -------
        ConfidenceInterval
            Bounds, (...); infinite where the samples are too few for one.

        Raises
        ------
        FrameError
            If `level` or `of` cannot be meant, or a quantile needs samples that were not kept.
        """
        if of == "mean":
            return by_error(self.mean, self.standard_error, level, np.asarray(self.moments.n) - 1)
        if of == "std":
            return by_error(self.std, self.std_standard_error, level, least=0.0)
        if isinstance(of, str):
            raise FrameError(f"confidence interval of {of!r}: choose 'mean', 'std', or the probability of a quantile")
        return self._quantile_interval(of, level)

    @abstractmethod
    def _quantile_interval(self, p: float, level: float) -> ConfidenceInterval:
        """Interval of a quantile."""
