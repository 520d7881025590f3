"""What is said of an uncertain input: a distribution, an interval, or a tolerance in words."""

from __future__ import annotations

import re
from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError

Array = NDArray[np.float64]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_SYMMETRIC = re.compile(
    rf"(?P<nominal>{_NUMBER})?\s*(?:±|\+/-|\+-)\s*(?P<half>{_NUMBER})\s*(?P<percent>%?)\s*(?P<kind>\w*)"
)
_LIMITS = re.compile(
    rf"(?P<nominal>{_NUMBER})?\s+(?P<up>\+{_NUMBER})\s*(?P<percent>%?)\s*/?\s*(?P<down>-{_NUMBER})\s*%?\s*(?P<kind>\w*)"
)
_CALL = re.compile(r"(?P<name>[A-Za-z_]\w*)\((?P<numbers>[^()]*)\)")
# A tolerance is taken for so many standard deviations of a normal distribution.
SIGMAS = 3.0


class Distribution(Protocol):
    """What a frozen distribution of `scipy.stats` offers and sampling needs."""

    def ppf(self, q: Array, /) -> Any:
        """Quantile at probability `q`."""


class RandomVariable(Protocol):
    """What a random variable of `scipy.stats` in its newer form, such as ``stats.Normal``, offers instead."""

    def icdf(self, p: Array, /) -> Any:
        """Quantile at probability `p`."""


# What may be given for an input.
Uncertain = Distribution | RandomVariable | tuple[float, float] | str


class ContinuousDistribution(ABC):
    """Quantiles, density and probabilities of a distribution of numbers, as those of `scipy.stats` have them."""

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
            Density, (...), in the inverse unit.
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
        """Mean.

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
        """Ends of the values, which may be infinite.

        Returns
        -------
        tuple
            Lower and upper end, in the unit of the values.
        """


@dataclass(frozen=True)
class Normal(ContinuousDistribution):
    """Normal distribution, with the bits of `scipy.stats.norm`, which takes long to load.

    Parameters
    ----------
    loc, scale
        Mean and standard deviation, in the unit of what is drawn.
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
        """Value that is exceeded with probability `q`."""
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
        """Mean."""
        return self.loc

    def std(self) -> float:
        """Standard deviation."""
        return self.scale

    def support(self) -> tuple[float, float]:
        """All numbers."""
        return -np.inf, np.inf


@dataclass(frozen=True)
class Interval(ContinuousDistribution):
    """An input of which no more is known than its bounds: every value between them is equally likely.

    That is what the Guide to the Expression of Uncertainty in Measurement (JCGM 100:2008, 4.3.7) takes for bounds.

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
        """Value that is exceeded with probability `q`.

        Parameters
        ----------
        q
            Probabilities, (...).

        Returns
        -------
        ndarray
            Values, (...).
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
        """Mean."""
        return 0.5 * (self.low + self.high)

    def std(self) -> float:
        """Standard deviation."""
        return (self.high - self.low) / float(np.sqrt(12.0))

    def support(self) -> tuple[float, float]:
        """Bounds."""
        return self.low, self.high


class _FromInverse:
    """A random variable of SciPy's newer kind under the names of the older one."""

    def __init__(self, variable: Any) -> None:
        self.variable = variable

    def ppf(self, q: Array, /) -> Any:
        return self.variable.icdf(q)

    def __getattr__(self, name: str) -> Any:
        if name.startswith("_") or name == "variable":
            raise AttributeError(name)
        return getattr(self.variable, {"isf": "iccdf", "std": "standard_deviation"}.get(name, name))

    def __repr__(self) -> str:
        return repr(self.variable)


def tolerance(nominal: float, text: str, distribution: str = "uniform", sigmas: float = SIGMAS) -> Distribution:
    """Distribution of a dimension with a tolerance, as a drawing has it.

    Parameters
    ----------
    nominal
        Nominal value, in the unit of the input.
    text
        ``"± 0.1"``, ``"± 5 %"`` of the nominal value, or ``"+0.2/-0.1"``; ``+/-`` may stand for ``±``.
    distribution
        ``"uniform"`` between the limits, or ``"normal"`` about their middle.
    sigmas
        How many standard deviations of the normal distribution the tolerance is on either side.

    Returns
    -------
    Interval or Normal
        What `propagate` takes for an input.

    Raises
    ------
    FrameError
        If the text is no tolerance, a nominal value of zero has one in percent, or the distribution is neither.

    Examples
    --------
    >>> tolerance(200.0, "± 5 %")
    Interval(low=190.0, high=210.0)
    >>> tolerance(12.0, "+1.5/-0", "normal")
    Normal(loc=12.75, scale=0.25)
    """
    match = _SYMMETRIC.fullmatch(text.strip()) or _LIMITS.fullmatch(f" {text.strip()}")
    if match is None or match["nominal"] or match["kind"]:
        raise FrameError(f"tolerance {text!r}: write it as '± 0.1', '± 5 %' or '+0.2/-0.1'")
    return _toleranced(float(nominal), match, text, distribution, sigmas)


def _toleranced(nominal: float, match: re.Match[str], text: str, kind: str, sigmas: float) -> Distribution:
    parts = match.groupdict()
    up, down = (
        (float(parts["half"]), -float(parts["half"])) if "half" in parts else (float(parts["up"]), float(parts["down"]))
    )
    if parts["percent"]:
        if nominal == 0.0:
            raise FrameError(f"tolerance {text!r} is in percent of a nominal value of zero: give it as a number")
        up, down = 0.01 * abs(nominal) * up, 0.01 * abs(nominal) * down
    if not up > down:
        raise FrameError(f"tolerance {text!r} leaves no room: give a width above zero")
    if kind == "uniform":
        return Interval(nominal + down, nominal + up)
    if kind == "normal":
        if not sigmas > 0.0:
            raise FrameError(f"sigmas is {sigmas}: give the number of standard deviations in a tolerance, above zero")
        return Normal(nominal + 0.5 * (up + down), (up - down) / (2.0 * sigmas))
    raise FrameError(f"distribution {kind!r} of tolerance {text!r}: choose uniform or normal")


def ends(distribution: Distribution) -> tuple[float, float]:
    """Limits of a distribution; those of a normal one at three standard deviations where it has none."""
    from scipy.special import ndtr

    found = []
    for limit, score in ((0.0, -SIGMAS), (1.0, SIGMAS)):
        end = float(distribution.ppf(np.array(limit)))
        found.append(end if np.isfinite(end) else float(distribution.ppf(ndtr(np.array(score)))))
    return found[0], found[1]


def called(text: str) -> tuple[str, dict[str, float | str]] | None:
    """A distribution of `scipy.stats` that is written as a call.

    Parameters
    ----------
    text
        Such as ``"norm(0.1, 0.002)"`` or ``"norm(scale=5 %)"``.

    Returns
    -------
    tuple or None
        Its name, and its numbers by their names, those in percent as they are written; None for any other text.

    Raises
    ------
    FrameError
        If a number is none, or has no name.

    Examples
    --------
    >>> called("norm(0.1, scale=2 %)")
    ('norm', {'loc': 0.1, 'scale': '2 %'})
    """
    match = _CALL.fullmatch(text.strip())
    if match is None:
        return None
    names = [*_shape_names(match["name"]), "loc", "scale"]
    found: dict[str, float | str] = {}
    for index, given in enumerate(filter(None, re.split(r"\s*,\s*", match["numbers"].strip()))):
        key, equal, value = given.rpartition("=")
        if not equal and index >= len(names):
            raise FrameError(
                f"{text!r}: {match['name']} takes {', '.join(names)}, and there is one more number: {given}"
            )
        key, value = key.strip() if equal else names[index], value.strip()
        if not re.fullmatch(rf"{_NUMBER}\s*%?|±\s*{_NUMBER}\s*%", value):
            raise FrameError(f"{text!r}: {value!r} is no number; write it as 'norm(0.1, 0.002)' or 'norm(scale=5 %)'")
        found[key] = value if value.endswith("%") else float(value)
    return match["name"], found


def _shape_names(name: str) -> list[str]:
    """What a distribution of `scipy.stats` takes before loc and scale; the usual ones take nothing."""
    if name in ("norm", "uniform"):
        return []
    from scipy import stats

    return [*filter(None, re.split(r",\s*", getattr(getattr(stats, name, None), "shapes", None) or ""))]


def continuous(name: str, numbers: Mapping[str, float]) -> Distribution | None:
    """A continuous distribution by its name in `scipy.stats`.

    The usual ones, norm and uniform, are had without loading `scipy.stats`, which takes longer than most jobs.

    Parameters
    ----------
    name
        Such as ``"norm"``.
    numbers
        What it is frozen with, by name, such as ``loc`` and ``scale``.

    Returns
    -------
    Distribution or None
        The frozen distribution; None if there is none of that name.

    Raises
    ------
    TypeError, ValueError
        By SciPy, if the distribution does not take these numbers.

    Examples
    --------
    >>> continuous("norm", {"loc": 2.0, "scale": 0.5})
    Normal(loc=2.0, scale=0.5)
    """
    loc, scale = numbers.get("loc", 0.0), numbers.get("scale", 1.0)
    if numbers.keys() <= {"loc", "scale"} and np.isfinite([loc, scale, loc + scale]).all() and loc + scale > loc:
        if name == "norm":
            return Normal(loc, scale)
        if name == "uniform":
            return Interval(loc, loc + scale)
    from scipy import stats

    kind = getattr(stats, name, None)
    return kind(**numbers) if isinstance(kind, stats.rv_continuous) else None


def distribution_of(name: str, given: object) -> Distribution:
    """What is given for an input as a distribution with `ppf`, checked; one that has it already comes back as it is."""
    found: Any = given
    if isinstance(given, str):
        found = _in_words(name, given)
    elif isinstance(given, tuple | list) and len(given) == 2 and all(isinstance(each, int | float) for each in given):
        found = Interval(float(given[0]), float(given[1]))
    elif not hasattr(given, "ppf") and hasattr(given, "icdf"):
        found = _FromInverse(given)
    if not hasattr(found, "ppf"):
        raise FrameError(
            f"distribution of {name!r} is {given!r}: give a frozen one, such as scipy.stats.norm(1.0, 0.1), an "
            "interval such as (0.9, 1.1), or a tolerance such as '1.0 ± 5 %'"
        )
    median = found.ppf(np.array(0.5))
    if np.shape(median) != () or not np.isfinite(median):
        raise FrameError(f"distribution of {name!r} has the median {median}: give finite scalar parameters")
    return found  # type: ignore[no-any-return]


def _in_words(name: str, text: str) -> Distribution:
    match = _SYMMETRIC.fullmatch(text.strip()) or _LIMITS.fullmatch(text.strip())
    if match is None:
        raise FrameError(f"{name!r} is {text!r}: write it as '0.1 ± 5 %', '0.1 ± 0.002 normal' or '0.1 +0.002/-0.001'")
    if not match["nominal"]:
        raise FrameError(f"tolerance {text!r} of {name!r} has no nominal value: write it as '0.1 {text.strip()}'")
    return _toleranced(float(match["nominal"]), match, text, match["kind"] or "uniform", SIGMAS)


def distributions_of(given: object) -> dict[str, Distribution]:
    """By name the distributions of inputs, checked."""
    if not isinstance(given, Mapping):
        raise FrameError(f"distributions are {given!r}: give a mapping of names to frozen ones of scipy.stats")
    return {name: distribution_of(name, each) for name, each in given.items()}
