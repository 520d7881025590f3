"""Reading the distribution of an input: an object, parameters by name, an interval, or a tolerance as text."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from .distributions import SIGMAS, Distribution, Interval, Normal

Array = NDArray[np.float64]

_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?"
_SYMMETRIC = re.compile(
    rf"(?P<nominal>{_NUMBER})?\s*(?:±|\+/-|\+-)\s*(?P<half>{_NUMBER})\s*(?P<percent>%?)\s*(?P<kind>\w*)"
)
# Of two limits each has a sign or is zero. A sign of percent behind the second number is that of both.
_LIMIT = rf"(?:(?=[+-]){_NUMBER}|0(?![.\d]))"
_LIMITS = re.compile(
    rf"(?P<nominal>{_NUMBER})?\s+(?P<one>{_LIMIT})\s*(?P<first>%?)(?:\s*/\s*|\s+|(?=[+-]))(?P<other>{_LIMIT})"
    r"\s*(?P<percent>%?)\s*(?P<kind>\w*)"
)
_CALL = re.compile(r"(?P<name>[A-Za-z_]\w*)\((?P<numbers>[^()]*)\)")


class _FromInverse:
    """A newer random variable of SciPy with the method names of the older distributions."""

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
    """Distribution of a dimension with a tolerance, written as on a drawing.

    Parameters
    ----------
    nominal
        Nominal value, in the unit of the input.
    text
        Tolerance: ``"± 0.1"``, ``"± 5 %"`` of the nominal value, or two limits, ``"+0.2/-0.1"``, which may be on one
        side, ``"-0.007/-0.020"``; ``+/-`` may replace ``±``.
    distribution
        ``"uniform"`` between the limits, or ``"normal"`` about their middle.
    sigmas
        Number of standard deviations of the normal distribution in half the width of the tolerance.

    Returns
    -------
    Interval or Normal
        Distribution for `propagate`, in the unit of the input.

    Raises
    ------
    FrameError
        If the text is not a tolerance, the tolerance is in percent of zero, or there is no such distribution.

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
        (float(parts["half"]), -float(parts["half"]))
        if "half" in parts
        else sorted((float(parts["one"]), float(parts["other"])), reverse=True)
    )
    if parts.get("first") and not parts["percent"]:
        raise FrameError(f"tolerance {text!r} has one limit in percent: give both so, '+0.2 %/-0.1 %', or neither")
    if parts["percent"]:
        if nominal == 0.0:
            raise FrameError(f"tolerance {text!r} is in percent of a nominal value of zero: give it as a number")
        down, up = sorted((0.01 * nominal * up, 0.01 * nominal * down))
    if not up > down:
        raise FrameError(f"tolerance {text!r} leaves no room: give a width above zero")
    if kind == "uniform":
        return Interval(nominal + down, nominal + up)
    if kind == "normal":
        if not sigmas > 0.0:
            raise FrameError(f"sigmas is {sigmas}: give the number of standard deviations in a tolerance, above zero")
        return Normal(nominal + 0.5 * (up + down), (up - down) / (2.0 * sigmas))
    raise FrameError(f"distribution {kind!r} of tolerance {text!r}: choose uniform or normal")


def called(text: str) -> tuple[str, dict[str, float | str]] | None:
    """Parse a distribution of `scipy.stats` written as a call.

    Parameters
    ----------
    text
        Text such as ``"norm(0.1, 0.002)"`` or ``"norm(scale=5 %)"``.

    Returns
    -------
    tuple or None
        Name of the distribution, and its parameters by name, with percentages as text; None for any other text.

    Raises
    ------
    FrameError
        If a value is not a number, there are too many values, or one is given twice.

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
        if key in found:
            raise FrameError(f"{text!r}: {key} is given twice: write it as 'norm(0.1, 0.002)' or 'norm(scale=5 %)'")
        if not re.fullmatch(rf"{_NUMBER}\s*%?|±\s*{_NUMBER}\s*%", value):
            raise FrameError(f"{text!r}: {value!r} is no number; write it as 'norm(0.1, 0.002)' or 'norm(scale=5 %)'")
        found[key] = value if value.endswith("%") else float(value)
    return match["name"], found


def _shape_names(name: str) -> list[str]:
    """Names of the shape parameters of a distribution of `scipy.stats`, which come before loc and scale."""
    if name in ("norm", "uniform"):
        return []
    from scipy import stats

    return [*filter(None, re.split(r",\s*", getattr(getattr(stats, name, None), "shapes", None) or ""))]


def is_known(name: str) -> bool:
    """Whether `scipy.stats` has a continuous distribution of this name."""
    if name in ("norm", "uniform"):
        return True
    from scipy import stats

    return isinstance(getattr(stats, name, None), stats.rv_continuous)


def continuous(name: str, numbers: Mapping[str, float]) -> Distribution | None:
    """Continuous distribution by its name in `scipy.stats`.

    For norm and uniform `scipy.stats` is not imported, which takes longer than most jobs.

    Parameters
    ----------
    name
        Name in `scipy.stats`, such as ``"norm"``.
    numbers
        Parameters by name, such as ``loc`` and ``scale``.

    Returns
    -------
    Distribution or None
        The frozen distribution; None if there is none of that name.

    Raises
    ------
    TypeError, ValueError
        By SciPy, if the distribution does not take these parameters.

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

    return getattr(stats, name)(**numbers) if is_known(name) else None


def frozen(name: str, numbers: Mapping[str, float]) -> Distribution:
    """Continuous distribution by its name in `scipy.stats`, with an error message that explains what is wrong.

    Parameters
    ----------
    name
        Name in `scipy.stats`, such as ``"norm"``.
    numbers
        Parameters by name, such as ``loc`` and ``scale``.

    Returns
    -------
    Distribution
        The frozen distribution.

    Raises
    ------
    FrameError
        If there is none of that name, it does not take these parameters, or it is not defined for them.
    """
    try:
        found = continuous(name, numbers)
    except (TypeError, ValueError) as error:
        raise FrameError(_not_taken(name, numbers)) from error
    if found is None:
        raise FrameError(f"there is no distribution {name!r}: give a continuous one of scipy.stats, such as norm")
    with np.errstate(all="ignore"):
        undefined = np.isnan(found.ppf(np.array(0.5)))
    if undefined:
        given = ", ".join(f"{key} = {value:g}" for key, value in numbers.items())
        why = "scale must be above 0" if numbers.get("scale", 1.0) <= 0.0 else f"see scipy.stats.{name} for its range"
        raise FrameError(f"{name} is not defined for {given}: {why}")
    return found


def _not_taken(name: str, numbers: Mapping[str, float]) -> str:
    """Message about the parameters that a distribution does not take, or that are missing."""
    taken = [*_shape_names(name), "loc", "scale"]
    more = [key for key in numbers if key not in taken]
    less = [key for key in taken[:-2] if key not in numbers]
    if more:
        return f"{name} does not take {', '.join(more)}: it takes {', '.join(taken)}"
    return f"{name} lacks {', '.join(less)}: it takes {', '.join(taken)}, and loc and scale may be left out"


def distribution_of(name: str, given: object) -> Distribution:
    """Check and convert what is given for an input to a distribution with `ppf`; one that has it is returned itself."""
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
        raise FrameError(
            f"distribution of {name!r} has the median {median}: give finite scalar parameters for which it is defined, "
            "such as a scale above 0"
        )
    return found  # type: ignore[no-any-return]


def _in_words(name: str, text: str) -> Distribution:
    table = called(text)
    if table is not None:
        values = {key: value for key, value in table[1].items() if not isinstance(value, str)}
        if values.keys() < table[1].keys():
            raise FrameError(
                f"{name!r} is {text!r}, and there is no nominal value of which it could be a percentage: give numbers, "
                "or write it as '0.1 ± 5 %'"
            )
        try:
            return frozen(table[0], values)
        except FrameError as error:
            raise FrameError(f"{name!r} is {text!r}: {error}") from error
    match = _SYMMETRIC.fullmatch(text.strip()) or _LIMITS.fullmatch(text.strip())
    if match is None:
        raise FrameError(
            f"{name!r} is {text!r}: write it as '0.1 ± 5 %', '0.1 ± 0.002 normal', '0.1 +0.002/-0.001' or "
            "'norm(0.1, 0.002)'"
        )
    if not match["nominal"]:
        raise FrameError(f"tolerance {text!r} of {name!r} has no nominal value: write it as '0.1 {text.strip()}'")
    return _toleranced(float(match["nominal"]), match, text, match["kind"] or "uniform", SIGMAS)


def distributions_of(given: object) -> dict[str, Distribution]:
    """Check and convert the distributions of several inputs, by name."""
    if not isinstance(given, Mapping):
        raise FrameError(f"distributions are {given!r}: give a mapping of names to frozen ones of scipy.stats")
    return {name: distribution_of(name, each) for name, each in given.items()}
