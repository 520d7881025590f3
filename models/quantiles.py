"""Quantiles, densities, probabilities and normal scores of uncertain inputs with any kind of distribution."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .distributions import Distribution

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

# Largest normal score used: the probability beyond it is still above zero in double precision.
FARTHEST = 37.5
# Step in a normal score that changes any quantile but those between the steps of an input with separate values.
SMALL = 1e-4


def quantiles(distribution: Distribution, probabilities: Array) -> Array:
    """Quantiles of an input, equal to those of its `ppf`.

    For the most common distributions of SciPy the closed form is used directly, because the checks in its `ppf` take
    longer than the quantiles.

    Parameters
    ----------
    distribution
        Distribution of the input.
    probabilities
        Probabilities in (0, 1), (m,).

    Returns
    -------
    array
        Quantiles, (m,), in the unit of the input.
    """
    known = _location_scale(distribution)
    if known is None:
        return np.asarray(distribution.ppf(probabilities), dtype=np.float64)
    standard, _, location, scale = known
    return standard(probabilities) * scale + location


def _location_scale(distribution: Any) -> tuple[Function, Function, float, float] | None:
    """Location, scale and closed forms of SciPy's normal, lognormal or uniform distribution, or None for others.

    The two functions give the standard quantile at a probability and at a normal score.
    """
    kind = type(getattr(distribution, "dist", None))
    name = kind.__name__.removesuffix("_gen")
    if kind.__module__ != "scipy.stats._continuous_distns" or name not in ("norm", "lognorm", "uniform"):
        return None
    names = ("s", "loc", "scale") if name == "lognorm" else ("loc", "scale")
    given = {"loc": 0.0, "scale": 1.0} | dict(zip(names, distribution.args, strict=False)) | distribution.kwds
    if any(np.ndim(value) for value in given.values()) or not min(given["scale"], given.get("s", 1.0)) > 0.0:
        return None
    from scipy.special import ndtr, ndtri

    standard: dict[str, tuple[Function, Function]] = {
        "norm": (ndtri, lambda score: score),
        "lognorm": (lambda q: np.exp(given["s"] * ndtri(q)), lambda score: np.exp(given["s"] * score)),
        "uniform": (lambda q: q, ndtr),
    }
    return *standard[name], given["loc"], given["scale"]


def log_density(name: str, distribution: Distribution, x: Array) -> Array:
    """Logarithm of the probability density of an input, (m,)."""
    found: Any = distribution
    with np.errstate(divide="ignore"):
        if hasattr(found, "logpdf"):
            return np.asarray(found.logpdf(x), dtype=np.float64)
        if hasattr(found, "pdf"):
            return np.log(np.asarray(found.pdf(x), dtype=np.float64))
    raise FrameError(f"distribution of {name!r} has no density (pdf or logpdf): it cannot be re-weighted")


def probability(name: str, distribution: Distribution, x: Array) -> Array:
    """Probability of a value below `x`, (m,)."""
    if not hasattr(distribution, "cdf"):
        raise FrameError(f"distribution of {name!r} has no cdf, which is needed here: give it a method cdf(x)")
    return np.asarray(distribution.cdf(x), dtype=np.float64)


def at_scores(distribution: Distribution, scores: Array) -> Array:
    """Values of an input at standard normal scores, (...), accurate in both tails if the distribution has `isf`.

    For SciPy's normal, lognormal and uniform distributions the closed forms are used. Scores are limited to ±37.5, so
    that no value is infinite.
    """
    from scipy.special import ndtr

    found: Any = distribution
    scores = np.clip(scores, -FARTHEST, FARTHEST)
    known = _location_scale(distribution)
    if known is not None:
        _, standard, location, scale = known
        return standard(scores) * scale + location
    below = np.asarray(found.ppf(ndtr(np.minimum(scores, 0.0 if hasattr(found, "isf") else np.inf))), dtype=np.float64)
    if not hasattr(found, "isf"):
        return below
    above = np.asarray(found.isf(ndtr(-np.maximum(scores, 0.0))), dtype=np.float64)
    return np.where(scores > 0.0, above, below)


def normal_scores(name: str, distribution: Distribution, x: Array) -> Array:
    """Standard normal scores of values of an input, (m,), accurate in both tails if the distribution has `sf`."""
    from scipy.special import ndtri

    found: Any = distribution
    below = probability(name, distribution, x)
    scores = ndtri(np.clip(below, 2.0**-1022, 1.0 - 2.0**-53))
    if not hasattr(found, "sf"):
        return np.asarray(scores)
    above = ndtri(np.clip(np.asarray(found.sf(x), dtype=np.float64), 2.0**-1022, 1.0 - 2.0**-53))
    return np.where(below > 0.5, -above, scores)


def is_stepped(distribution: Distribution) -> bool:
    """Whether an input takes separate values only, such as counts, so that small steps seldom change a quantile."""
    scores = np.linspace(-2.9, 3.1, 61)
    return bool(np.mean(at_scores(distribution, scores + SMALL) == at_scores(distribution, scores - SMALL)) > 0.5)
