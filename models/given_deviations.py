"""Deviation or distribution of an uncertain number that has a nominal value."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, cast

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .distributions import Distribution, Interval, Normal, Uncertain
from .given_distributions import called, distribution_of, frozen, tolerance

Array = NDArray[np.float64]

_NUMBER = r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_KIND = r"\s*(?P<kind>uniform|normal)?\s*"
_PERCENT = re.compile(rf"\s*(?:±|\+/-|\+-)?\s*(?P<half>{_NUMBER})\s*%{_KIND}")
_SHARE = re.compile(rf"\s*(?P<sign>±)?\s*(?P<share>[+-]?{_NUMBER})\s*%\s*")
_HALF_WIDTH = re.compile(rf"\s*(?P<half>{_NUMBER}){_KIND}")
_DEVIATION = re.compile(rf"\s*(?P<words>(?:[±+-]|0\s*/).*?){_KIND}")
# Largest distance of the nominal value from the mean of a bounded distribution, in standard deviations.
MOST_DEVIATIONS = 3.0
ROUNDING = 1e-9


@dataclass(frozen=True)
class Rescaled:
    """Distribution of ``offset + factor * x``, where x has the given distribution.

    Attributes
    ----------
    distribution
        Distribution of x.
    factor, offset
        Factor, not zero, and offset in the unit of the result; a factor below zero turns the order of values round.
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
        if self.factor > 0.0:
            return self._scaled(self.distribution.ppf(q))
        upper = getattr(self.distribution, "isf", None)
        return self._scaled(self.distribution.ppf(1.0 - q) if upper is None else upper(q))

    @property
    def isf(self) -> Callable[[Array], Array]:
        """Inverse survival function, which keeps the digits of the upper tail; there if the distribution has one."""
        upper = cast(Any, self.distribution).isf
        return lambda q: self._scaled(upper(q) if self.factor > 0.0 else self.distribution.ppf(q))

    def _scaled(self, values: Any) -> Array:
        return np.asarray(self.offset + self.factor * values)


@dataclass(frozen=True)
class Deviation:
    """Deviation of a number from its nominal value.

    Attributes
    ----------
    distribution
        Distribution of the number or, if `relative`, of its deviation as a share of the nominal value.
    relative
        Whether the deviation was given in percent.
    description
        The deviation as text, for messages.
    centred
        Whether a deviation from the nominal value was given, rather than a distribution with a mean of its own.
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
            Nominal value, in the unit of the number.

        Raises
        ------
        FrameError
            If the deviation is in percent and the nominal value is zero.
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
        """Raise an error if the mean is more than a standard deviation from the nominal value.

        A bounded distribution may have its mean up to three standard deviations away if the nominal value lies within
        the bounds.

        Parameters
        ----------
        nominal
            Nominal value, in the unit of the number.
        what
            Name of the number in the message.

        Raises
        ------
        FrameError
            If the mean is too far from the nominal value.
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
    """Read the deviation of an uncertain number, as given in a file, on the command line or in Python.

    Parameters
    ----------
    name
        Name of the number, for messages.
    nominal
        Nominal value of the number.
    given
        A distribution as for `propagate`; a deviation from the nominal value, ``"± 0.1"``, ``"± 5 %"`` or
        ``"+0.2/-0.1"``, uniform or, followed by ``normal``, normal; a distribution in percent, ``"norm(scale=5 %)"``;
        or a number, the half width of the interval about the nominal value.

    Returns
    -------
    Deviation
        The deviation, not yet compared with the nominal value.

    Raises
    ------
    FrameError
        If `given` is none of these.

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
    """Deviation by the name of a distribution of `scipy.stats`, with loc and scale possibly in percent.

    Parameters
    ----------
    name
        Name in `scipy.stats`, such as ``"norm"``.
    numbers
        Parameters by name, such as ``{"scale": "5 %"}``; a percentage is a share of the nominal value.

    Returns
    -------
    Deviation
        The deviation, not yet compared with the nominal value.

    Raises
    ------
    FrameError
        If there is no such distribution, or it does not take these parameters.
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
    """Convert a percentage as text, for loc or scale, to a share."""
    match = _SHARE.fullmatch(text)
    if match is None or key not in ("loc", "scale") or (match["sign"] and key == "loc"):
        raise FrameError(f"{key} is {text!r}: give a number, or loc and scale in percent, such as '5 %'")
    return 0.01 * float(match["share"])


def _shape(distribution: Any) -> tuple[float, float, Array]:
    """Mean, standard deviation and limits of a distribution.

    Without finite moments they are the median and half the distance between the quartiles.
    """
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
