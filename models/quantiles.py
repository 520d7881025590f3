"""Quantiles, densities, probabilities and normal scores of uncertain inputs, whoever made their distributions."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .distributions import Distribution

Array = NDArray[np.float64]
Function = Callable[[Array], Array]

# Normal scores whose probability is still above zero.
FARTHEST = 37.5


def quantiles(distribution: Distribution, probabilities: Array) -> Array:
    """Quantiles of an input: those of its `ppf`, bit by bit.

    SciPy takes apart what has a quantile and what has none, which takes longer than the quantiles of the distributions
    that are used most.

    Parameters
    ----------
    distribution
        Distribution of the input.
    probabilities
        Within (0, 1), (m,).

    Returns
    -------
    array
        (m,).
    """
    known = _location_scale(distribution)
    if known is None:
        return np.asarray(distribution.ppf(probabilities), dtype=np.float64)
    standard, _, location, scale = known
    return standard(probabilities) * scale + location


def _location_scale(distribution: Any) -> tuple[Function, Function, float, float] | None:
    """SciPy's standard normal, lognormal or uniform distribution by probability and by normal score, its location and
    scale; else None."""
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
    """Values of an input whose standard normal score is `scores`, (...), exact in both tails where it has `isf`.

    SciPy's normal, lognormal and uniform distributions by their closed forms. Scores beyond those that have a
    probability count as the last that has one, so that no input is infinite.
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
    """Standard normal scores of values of an input, (m,), exact in both tails where it has `sf`."""
    from scipy.special import ndtri

    found: Any = distribution
    below = probability(name, distribution, x)
    scores = ndtri(np.clip(below, 2.0**-1022, 1.0 - 2.0**-53))
    if not hasattr(found, "sf"):
        return np.asarray(scores)
    above = ndtri(np.clip(np.asarray(found.sf(x), dtype=np.float64), 2.0**-1022, 1.0 - 2.0**-53))
    return np.where(below > 0.5, -above, scores)
