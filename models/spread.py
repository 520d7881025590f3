"""Statistics of samples of a vector, at every pose."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import finite
from ..framework.errors import FrameError
from .intervals import ConfidenceInterval, quantile_interval
from .moments import Moments, Statistics, checked_policy

Array = NDArray[np.float64]


class SampleStatistics(Statistics):
    """Statistics over the last axis but one of `samples`, with NaN treated according to `nan_policy`."""

    samples: Array
    nan_policy: str

    @cached_property
    def moments(self) -> Moments:
        """Number of samples, mean and sums of powers of the deviations, (..., 3)."""
        return Moments.of(np.moveaxis(self.samples, -2, 0), self.nan_policy)

    @cached_property
    def missing(self) -> NDArray[np.int64]:
        """Number of samples that are NaN, (..., 3)."""
        return np.asarray(np.count_nonzero(np.isnan(self.samples), axis=-2))

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the components with n − 1 in the denominator, (..., 3, 3), of the same samples as `std`."""
        apart = self.samples - self.mean[..., None, :]
        if self.nan_policy == "omit":
            apart = np.where(np.isnan(self.samples), 0.0, apart)
        with np.errstate(invalid="ignore", divide="ignore"):
            scaled = apart / np.sqrt(self.samples.shape[-2] - self.missing - 1)[..., None, :]
        return np.asarray(scaled.mT @ scaled)

    def quantile(self, p: ArrayLike) -> Array:
        """Quantile of each component at one or more probabilities, interpolated linearly between samples.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Quantiles, (k..., ..., 3), in the unit of the samples.
        """
        return quantiles(self.samples, p, axis=-2, nan_policy=self.nan_policy)

    def _quantile_interval(self, p: float, level: float) -> ConfidenceInterval:
        return quantile_interval(np.moveaxis(self.samples, -2, 0), p, level, self.nan_policy)

    @cached_property
    def envelope(self) -> tuple[Array, Array]:
        """Smallest and largest sample of each component, (..., 3) each."""
        if self.nan_policy != "omit":
            return self.samples.min(axis=-2), self.samples.max(axis=-2)
        # The result is NaN only where every sample is NaN.
        return np.fmin.reduce(self.samples, axis=-2), np.fmax.reduce(self.samples, axis=-2)


@dataclass(frozen=True, eq=False)
class Spread(SampleStatistics):
    """Statistics of samples over their last axis but one.

    Parameters
    ----------
    samples
        Samples, (..., n, 3); NaN where there is no result.
    nan_policy
        Treatment of samples that are NaN while others are not: ``"propagate"``, then the statistics are NaN, too;
        ``"omit"`` them; or ``"raise"`` an error.

    Raises
    ------
    FrameError
        If a sample is NaN and the policy is to raise.

    Examples
    --------
    >>> spread = Spread(np.array([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]))
    >>> spread.mean.tolist(), spread.quantile(0.75).tolist()
    ([2.0, 0.0, 0.0], [2.5, 0.0, 0.0])
    """

    samples: Array
    nan_policy: str = "propagate"

    def __post_init__(self) -> None:
        if checked_policy(self.nan_policy) != "raise":
            return
        some = self.missing[(self.missing > 0) & (self.missing < self.n)]
        if some.size:
            raise FrameError(
                f"{some.max()} of {self.n} samples are NaN: find why, or choose the nan_policy 'omit' or 'propagate'"
            )

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.samples.shape[-2])


def quantiles(samples: Array, p: ArrayLike, axis: int, nan_policy: str = "propagate") -> Array:
    """Quantiles at probabilities `p` (k...) of samples along an axis, (k..., ...)."""
    asked = finite(p, "probability p of a quantile")
    if np.any((asked < 0.0) | (asked > 1.0)):
        raise FrameError(f"probability p of a quantile is {asked.tolist()}: give numbers from 0 to 1")
    lost = np.isnan(samples)
    if nan_policy != "omit" or not lost.any():
        return _linear(np.quantile, samples, asked, axis)
    # Where every sample is NaN, nanquantile would warn.
    none = lost.all(axis=axis, keepdims=True)
    found = _linear(np.nanquantile, np.where(none, 0.0, samples), asked, axis)
    return np.where(np.squeeze(none, axis=axis), np.nan, found)


def _linear(quantile: Callable[..., ArrayLike], samples: Array, asked: Array, axis: int) -> Array:
    """Quantiles by a function of NumPy, corrected where it gives NaN because one of the two samples is infinite."""
    with np.errstate(invalid="ignore"):
        found = np.asarray(quantile(samples, asked, axis=axis))
    if not np.isnan(found).any():
        return found
    low, high = (np.asarray(quantile(samples, asked, axis=axis, method=side)) for side in ("lower", "higher"))
    return np.where(np.isnan(found), between(low, high, np.full(found.shape, 0.5)), found)


def between(low: Array, high: Array, share: Array) -> Array:
    """Linear interpolation between two samples, (...); if one is infinite, the result is that infinite value."""
    with np.errstate(invalid="ignore"):
        infinite = np.where(low == high, low, low + high)
        return np.where(np.isinf(low) | np.isinf(high), infinite, low + share * (high - low))
