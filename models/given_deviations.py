"""What is said of an uncertain number beside its nominal value: how far it deviates, or how it is distributed."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .distributions import Distribution, Interval, Normal, Uncertain
from .given_distributions import called, distribution_of, frozen, tolerance

Array = NDArray[np.float64]

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_KIND = r"\s*(?P<kind>uniform|normal)?\s*"
_PERCENT = re.compile(rf"\s*(?P<sign>±|\+/-|\+-)?\s*(?P<half>[+-]?{_NUMBER})\s*%{_KIND}")
_HALF_WIDTH = re.compile(rf"\s*(?P<half>{_NUMBER}){_KIND}")
_DEVIATION = re.compile(rf"\s*(?P<words>[±+-].*?){_KIND}")
# Of a distribution within limits, the nominal value may lie at one of them, but not further out than this.
MOST_DEVIATIONS = 3.0
ROUNDING = 1e-9


@dataclass(frozen=True)
class Rescaled:
    """A distribution in another unit, or about another value.

    Attributes
    ----------
    distribution
        That which is given.
    factor, offset
        From its values to those that are wanted; a factor below zero turns them over.
    """

    distribution: Distribution
    factor: float
    offset: float = 0.0

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
        share = q if self.factor > 0.0 else 1.0 - q
        return np.asarray(self.offset + self.factor * self.distribution.ppf(share))


@dataclass(frozen=True)
class Deviation:
    """How a number deviates from its nominal value.

    Attributes
    ----------
    distribution
        Of the number; where `relative`, of its deviation as a share of the nominal value.
    relative
        Whether it was given in percent.
    description
        In words.
    centred
        Whether it was said how far the number deviates, so that there is no other value about which it could lie.
    """

    distribution: Distribution
    relative: bool
    description: str
    centred: bool

    def about(self, nominal: float) -> Distribution:
        """Distribution of the number itself.

        Parameters
        ----------
        nominal
            Its nominal value.

        Raises
        ------
        FrameError
            If the nominal value is zero, of which a percentage is zero.
        """
        if not self.relative:
            return self.distribution
        if nominal == 0.0:
            raise FrameError(f"{self.description!r} is in percent of a nominal value of zero: give it as a number")
        given = self.distribution
        if isinstance(given, Interval):
            low, high = sorted((nominal + nominal * given.low, nominal + nominal * given.high))
            return Interval(low, high)
        if isinstance(given, Normal):
            return Normal(nominal + nominal * given.loc, abs(nominal) * given.scale)
        return Rescaled(given, nominal, nominal)

    def require_near(self, nominal: float, what: str) -> None:
        """Refuse a distribution whose mean is further from the nominal value than it spreads.

        Parameters
        ----------
        nominal
            The nominal value.
        what
            Of which number, as the message names it.

        Raises
        ------
        FrameError
            With the mean, the spread and what would be right.
        """
        value = 0.0 if self.relative else nominal
        mean, spread, limits = _shape(self.distribution)
        off = abs(value - mean)
        within = limits[0] - ROUNDING * spread <= value <= limits[1] + ROUNDING * spread
        near = off <= (1.0 + ROUNDING) * spread
        if self.centred or near or (np.isfinite(limits).all() and within and off <= MOST_DEVIATIONS * spread):
            return
        if self.relative:
            raise FrameError(
                f"{self.description} deviates by {100.0 * mean:g} % on average, which is more than it spreads "
                f"({100.0 * spread:g} %): percentages are deviations from the nominal value, so that their mean should "
                "be near 0"
            )
        raise FrameError(
            f"{self.description} has the mean {mean:g} and spreads by {spread:g}, but {what} is {nominal:g}: give it "
            "the value about which it spreads, or loc and scale in percent, which are deviations from the nominal value"
        )


def deviation(name: str, nominal: float, given: Uncertain | float) -> Deviation:
    """What is given of an uncertain number: the one reader of files, of the command line and of Python.

    Parameters
    ----------
    name
        Name of the number, for messages.
    nominal
        Its nominal value.
    given
        What `propagate` takes; a deviation from the nominal value, ``"± 0.1"``, ``"± 5 %"`` or ``"+0.2/-0.1"``, evenly
        within it, or with ``normal`` behind it; a distribution in percent, ``"norm(scale=5 %)"``; or a number, the half
        width of the interval about the nominal value.

    Returns
    -------
    Deviation
        Its distribution, not yet held against the nominal value.

    Raises
    ------
    FrameError
        If it is none of these.

    Examples
    --------
    >>> deviation("length", 0.2, "± 5 %").about(0.2)
    Interval(low=0.19, high=0.21000000000000002)
    """
    if isinstance(given, str):
        if (call := called(given)) is not None:
            return distributed(*call)
        if (match := _PERCENT.fullmatch(given)) is not None:
            half = 0.01 * float(match["half"])
            if not half > 0.0:
                raise FrameError(f"tolerance {given!r} leaves no room: give a width above zero")
            return Deviation(tolerance(0.0, f"± {half!r}", match["kind"] or "uniform"), True, given, True)
        if (match := _HALF_WIDTH.fullmatch(given)) is not None:
            return Deviation(tolerance(nominal, f"± {match['half']}", match["kind"] or "uniform"), False, given, True)
        if (match := _DEVIATION.fullmatch(given)) is not None:
            return Deviation(tolerance(nominal, match["words"], match["kind"] or "uniform"), False, given, True)
    elif isinstance(given, int | float | np.integer | np.floating) and not isinstance(given, bool):
        width = float(given)
        if not 0.0 < width < np.inf:
            raise FrameError("give a half width above zero, or leave the tolerance out where there is none")
        return Deviation(Interval(nominal - width, nominal + width), False, f"{given}", True)
    return Deviation(distribution_of(name, given), False, f"{given}", False)


def distributed(name: str, numbers: Mapping[str, float | str]) -> Deviation:
    """A distribution of `scipy.stats` by its name, its loc and scale perhaps in percent of the nominal value.

    Parameters
    ----------
    name
        Such as ``"norm"``.
    numbers
        What it is frozen with, by name; such as ``{"scale": "5 %"}``.

    Returns
    -------
    Deviation
        Its distribution, not yet held against the nominal value.

    Raises
    ------
    FrameError
        If there is no such distribution, or it does not take these numbers.
    """
    values = {key: _share(key, value) if isinstance(value, str) else value for key, value in numbers.items()}
    relative = [key for key, value in numbers.items() if isinstance(value, str)]
    for key in ("loc", "scale"):
        if relative and key in numbers and key not in relative:
            raise FrameError(
                f"{key} is {numbers[key]:g} beside {relative[0]} in percent: in percent both are deviations from the "
                "nominal value, so that loc may be left out"
            )
    found = frozen(name, values)
    if "scale" not in numbers:
        raise FrameError(
            f"{name} has no scale: give one, such as its standard deviation; in percent it is a share, as scale = 5 %"
        )
    shown = [
        f"{key}={_shown(100.0 * value)} %" if key in relative else f"{key}={_shown(value)}"
        for key, value in values.items()
    ]
    return Deviation(found, bool(relative), f"{name}({', '.join(shown)})", False)


def _shown(value: float) -> str:
    """A number in words, short where nothing is lost by it."""
    short = f"{value:g}"
    return short if float(short) == value else f"{value:.12g}"


def _share(key: str, text: str) -> float:
    """A number in percent as a share."""
    match = _PERCENT.fullmatch(text)
    if match is None or match["kind"] or key not in ("loc", "scale") or (match["sign"] and key == "loc"):
        raise FrameError(f"{key} is {text!r}: give a number, or loc and scale in percent, such as '5 %'")
    return 0.01 * float(match["half"])


def _shape(distribution: Any) -> tuple[float, float, Array]:
    """Mean, standard deviation, and limits of a distribution; of one without moments, median and half quartiles."""
    if not all(callable(getattr(distribution, key, None)) for key in ("mean", "std", "support")):
        low, mean, high = (float(distribution.ppf(np.array(p))) for p in (0.25, 0.5, 0.75))
        limits = np.array([float(distribution.ppf(np.array(p))) for p in (0.0, 1.0)])
        return mean, 0.5 * (high - low), limits
    with np.errstate(all="ignore"):
        mean, spread = float(distribution.mean()), float(distribution.std())
        if not np.isfinite([mean, spread]).all():
            low, mean, high = (float(value) for value in distribution.ppf(np.array([0.25, 0.5, 0.75])))
            spread = 0.5 * (high - low)
        return mean, spread, np.asarray(distribution.support(), dtype=np.float64)
