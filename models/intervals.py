"""Confidence intervals of means, standard deviations and quantiles from samples."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.errors import FrameError

Array = NDArray[np.float64]
Ranks = NDArray[np.int64]


class ConfidenceInterval(NamedTuple):
    """Bounds that contain the true value with a given confidence.

    Attributes
    ----------
    low, high
        Lower and upper bound, (...), in the unit of the estimate.
    """

    low: Array
    high: Array


def checked_level(level: float) -> float:
    """Check a confidence level and return it as a float."""
    if isinstance(level, bool) or not isinstance(level, int | float | np.floating) or not 0.0 < level < 1.0:
        raise FrameError(f"confidence level is {level!r}: give a number between 0 and 1, such as 0.95")
    return float(level)


def checked_probability(p: object) -> float:
    """Check the probability of a quantile and return it as a float."""
    if isinstance(p, bool) or not isinstance(p, int | float | np.floating) or not 0.0 <= p <= 1.0:
        raise FrameError(f"probability p of a quantile is {p!r}: give a number from 0 to 1")
    return float(p)


class Estimates(Protocol):
    """Mean and standard deviation with their standard errors, (...) each."""

    @property
    def mean(self) -> Array: ...

    @property
    def standard_error(self) -> Array: ...

    @property
    def std(self) -> Array: ...

    @property
    def std_standard_error(self) -> Array: ...


def interval_of(
    found: Estimates,
    of: str | float,
    level: float,
    of_quantile: Callable[[float, float], ConfidenceInterval],
    freedom: ArrayLike = np.inf,
) -> ConfidenceInterval:
    """Interval of the mean, of the standard deviation, or of a quantile.

    Parameters
    ----------
    found
        What is estimated.
    of
        ``"mean"``, ``"std"``, or the probability of a quantile.
    level
        Probability, between 0 and 1.
    of_quantile
        Called with a probability and the level; returns the interval of that quantile.
    freedom
        Degrees of freedom of the error of the mean, (...).

    Raises
    ------
    FrameError
        If `of` is none of these.
    """
    if of == "mean":
        return by_error(found.mean, found.standard_error, level, freedom)
    if of == "std":
        return by_error(found.std, found.std_standard_error, level, least=0.0)
    if isinstance(of, str):
        raise FrameError(f"confidence interval of {of!r}: choose 'mean', 'std', or the probability of a quantile")
    return of_quantile(of, level)


def by_error(
    value: ArrayLike, error: ArrayLike, level: float, freedom: ArrayLike = np.inf, least: float = -np.inf
) -> ConfidenceInterval:
    """Interval from a standard error, by Student's distribution, or by the normal one if `freedom` is infinite.

    Parameters
    ----------
    value, error
        Estimate and its standard error, (...).
    level
        Confidence level, between 0 and 1.
    freedom
        Degrees of freedom of the error, (...).
    least
        Smallest possible value of the estimated quantity; the lower bound is not below it.

    Returns
    -------
    ConfidenceInterval
        Bounds, (...), in the unit of the estimate; NaN where there are no degrees of freedom.
    """
    from scipy.special import ndtri, stdtrit

    p = 0.5 + 0.5 * checked_level(level)
    many = np.asarray(freedom, dtype=np.float64)
    with np.errstate(invalid="ignore"):
        finite = np.where(np.isfinite(many) & (many > 0.0), many, 1.0)
        factor = np.where(np.isinf(many), ndtri(p), np.where(many > 0.0, stdtrit(finite, p), np.nan))
        half = factor * np.asarray(error)
        low, high = np.asarray(value - half), np.asarray(value + half)
        return ConfidenceInterval(np.asarray(np.maximum(low, least)), high)


def quantile_ranks(n: ArrayLike, p: float, level: float) -> tuple[Ranks, Ranks]:
    """Ranks of the two ordered samples, counted from 0, between which a quantile lies with at least a confidence level.

    For any distribution, the number of samples below its quantile is binomial (David & Nagaraja, Order Statistics,
    3rd ed., 2003, section 7.1). If the samples are too few the rank is −1 or n: there is no bound on that side.

    Parameters
    ----------
    n
        Number of samples, (...).
    p
        Probability of the quantile.
    level
        Confidence level.

    Returns
    -------
    tuple
        Lower and upper rank, (...) each.
    """
    from scipy.stats import binom

    half = 0.5 * (1.0 - checked_level(level))
    count = np.asarray(n)
    at_least = np.maximum(count, 1)
    # Fewer than `low` samples lie below the quantile with probability <= half, and so do more than `high`.
    low = binom.ppf(half, at_least, p).astype(np.int64) - 1
    high = binom.isf(half, at_least, p).astype(np.int64)
    return np.maximum(low, -1), np.minimum(high, count)


def quantile_interval(samples: Array, p: object, level: float, nan_policy: str) -> ConfidenceInterval:
    """Confidence interval of a quantile from ordered samples (n, ...), for any distribution."""
    there = np.count_nonzero(~np.isnan(samples), axis=0)
    return _between_ranks(samples, *quantile_ranks(there, checked_probability(p), level), nan_policy)


def interval_between(samples: Array, low: Array, high: Array, nan_policy: str) -> ConfidenceInterval:
    """Interval between quantiles of samples (n, ...) at two probabilities, (...), each rounded outwards to a sample."""
    there = np.count_nonzero(~np.isnan(samples), axis=0)
    last = np.maximum(there - 1, 0)
    with np.errstate(invalid="ignore"):
        ranks = np.floor(low * last), np.ceil(high * last)
    below, above = (np.nan_to_num(each, nan=0.0).astype(np.int64) for each in ranks)
    return _between_ranks(samples, np.maximum(below, -1), np.minimum(above, there), nan_policy)


def _between_ranks(samples: Array, low: Ranks, high: Ranks, nan_policy: str) -> ConfidenceInterval:
    """Interval between ordered samples (n, ...) with given ranks, (...); infinite where there is no such sample."""
    lost = np.isnan(samples)
    ordered = np.sort(samples, axis=0)
    there = np.count_nonzero(~lost, axis=0)
    last = len(samples) - 1
    below = np.take_along_axis(ordered, np.clip(low, 0, last)[None], axis=0)[0]
    above = np.take_along_axis(ordered, np.clip(high, 0, last)[None], axis=0)[0]
    none = there == 0 if nan_policy == "omit" else lost.any(axis=0)
    return ConfidenceInterval(
        np.where(none, np.nan, np.where(low < 0, -np.inf, below)),
        np.where(none, np.nan, np.where(high >= there, np.inf, above)),
    )
