"""Fuzzy numbers: nested intervals, one at each level of membership."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.errors import FrameError
from ..distributions import Interval
from ..given_distributions import distribution_of

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class FuzzyNumber:
    """A number of which is known how possible each value is, by its cuts: straight lines lie between the given ones.

    The cut at a level is the interval of all values whose membership is that level or more (L. A. Zadeh,
    *Fuzzy sets*, 1965).

    Attributes
    ----------
    levels
        Levels of membership, rising from 0 to 1, (n,).
    lower, upper
        Ends of the cut at each of them, (n,): cuts of higher levels lie within those of lower ones.

    Examples
    --------
    >>> length = FuzzyNumber.triangular(0.9, 1.0, 1.2)
    >>> length
    <FuzzyNumber: 1, from 0.9 to 1.2>
    >>> length.cut(0.5)
    (0.95, 1.1)
    >>> round(length.membership(1.05), 12)
    0.75
    """

    levels: Array
    lower: Array
    upper: Array

    def __post_init__(self) -> None:
        levels, lower, upper = (finite(getattr(self, name), f"{name} of a fuzzy number") for name in vars(self))
        if levels.ndim != 1 or levels.shape != lower.shape or levels.shape != upper.shape or len(levels) < 2:
            raise FrameError(
                f"a fuzzy number has levels {levels.shape} and cuts {lower.shape}, {upper.shape}: give as many, two "
                "or more"
            )
        if levels[0] != 0.0 or levels[-1] != 1.0 or np.any(np.diff(levels) <= 0.0):
            raise FrameError(f"levels of a fuzzy number are {levels.tolist()}: let them rise from 0 to 1")
        if np.any(np.diff(lower) < 0.0) or np.any(np.diff(upper) > 0.0) or lower[-1] > upper[-1]:
            raise FrameError(
                f"cuts of a fuzzy number are {lower.tolist()} to {upper.tolist()}: those of higher levels must lie "
                "within those of lower ones"
            )
        for name, values in zip(vars(self), (levels, lower, upper), strict=True):
            object.__setattr__(self, name, values)

    @classmethod
    def triangular(cls, low: float, peak: float, high: float) -> FuzzyNumber:
        """One possible value, and others the less possible the further they are from it.

        Parameters
        ----------
        low
            The least value that is at all possible, in the unit of the input.
        peak
            The value with membership 1.
        high
            The greatest value that is at all possible.

        Returns
        -------
        FuzzyNumber
            With straight flanks.

        Raises
        ------
        FrameError
            If the three are not in their order.
        """
        return cls.trapezoidal(low, peak, peak, high)

    @classmethod
    def trapezoidal(cls, low: float, first: float, last: float, high: float) -> FuzzyNumber:
        """Several values that are fully possible, and others the less possible the further they are from these.

        Parameters
        ----------
        low
            The least value that is at all possible, in the unit of the input.
        first, last
            Ends of the interval with membership 1.
        high
            The greatest value that is at all possible.

        Returns
        -------
        FuzzyNumber
            With straight flanks.

        Raises
        ------
        FrameError
            If the four are not in their order.
        """
        return cls.from_cuts([0.0, 1.0], [low, first], [high, last])

    @classmethod
    def from_cuts(cls, levels: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> FuzzyNumber:
        """Make a fuzzy number of its cuts.

        Parameters
        ----------
        levels
            Levels of membership, rising from 0 to 1, (n,).
        lower, upper
            Ends of the cut at each of them, (n,).

        Returns
        -------
        FuzzyNumber
            With straight lines between the cuts.

        Raises
        ------
        FrameError
            If the levels do not rise from 0 to 1, or a cut does not lie within that below.
        """
        return cls(np.asarray(levels), np.asarray(lower), np.asarray(upper))

    def __repr__(self) -> str:
        first, last = self.lower[-1], self.upper[-1]
        core = f"{first:.6g}" if first == last else f"{first:.6g} to {last:.6g}"
        return f"<FuzzyNumber: {core}, from {self.lower[0]:.6g} to {self.upper[0]:.6g}>"

    def cut(self, level: ArrayLike) -> tuple[Any, Any]:
        """Interval of all values whose membership is a level or more.

        Parameters
        ----------
        level
            Levels from 0 to 1, (...).

        Returns
        -------
        tuple of float or ndarray
            Its lower and upper end, (...).
        """
        at = np.asarray(level, dtype=np.float64)
        ends = (np.interp(at, self.levels, each) for each in (self.lower, self.upper))
        low, high = (float(each) if each.ndim == 0 else each for each in map(np.asarray, ends))
        return low, high

    def membership(self, value: ArrayLike) -> Any:
        """How possible values are: the highest level whose cut holds them, 0 outside.

        Parameters
        ----------
        value
            Values, (...).

        Returns
        -------
        float or ndarray
            Membership, (...).
        """
        x = np.asarray(value, dtype=np.float64)
        found = membership_within(self.levels, self.lower, self.upper, x)
        return float(found) if found.ndim == 0 else found


def membership_within(levels: Array, lower: Array, upper: Array, x: Array) -> Array:
    """Membership (...) of values (...) in cuts (n, ...) that lie within one another, straight lines between them."""
    return np.minimum(_side(levels, lower, x), _side(levels, -upper, -x))


def _side(levels: Array, rising: Array, x: Array) -> Array:
    """Highest level whose end, which rises with the level, is x at most; 0 where even the first is above."""
    shape = np.broadcast_shapes(rising.shape[1:], x.shape)
    padded = rising.reshape(len(levels), *(1,) * (len(shape) + 1 - rising.ndim), *rising.shape[1:])
    ends = np.broadcast_to(padded, (len(levels), *shape))
    at = np.clip(np.sum(ends <= x, axis=0) - 1, 0, len(levels) - 2)
    low, high = (np.take_along_axis(ends, (at + k)[None], axis=0)[0] for k in (0, 1))
    rise = high - low
    share = np.clip(np.where(rise > 0.0, (x - low) / np.where(rise > 0.0, rise, 1.0), x >= high), 0.0, 1.0)
    found = levels[at] + share * (levels[at + 1] - levels[at])
    return np.where(np.isnan(ends).any(axis=0) | np.isnan(x), np.nan, np.where(x >= ends[0], found, 0.0))


def fuzzy_of(name: str, given: object) -> FuzzyNumber:
    """What is given for an input as a fuzzy number: one, an interval, three or four corners, a tolerance in words."""
    if isinstance(given, FuzzyNumber):
        return given
    if isinstance(given, str):
        found = distribution_of(name, given)
        if isinstance(found, Interval):
            given = (found.low, found.high)
    if isinstance(given, Iterable) and not isinstance(given, str):
        corners = finite(np.asarray([*given]), f"fuzzy input {name!r}")
        if corners.shape in ((2,), (3,), (4,)):
            low, high = corners[0], corners[-1]
            core = {2: (low, high), 3: (corners[1], corners[1]), 4: (corners[1], corners[-2])}[len(corners)]
            return FuzzyNumber.trapezoidal(low, *core, high)
    raise FrameError(
        f"fuzzy input {name!r} is {given!r}: give a FuzzyNumber, an interval (low, high), a triangle "
        "(low, peak, high), four corners of a trapezium, or a tolerance such as '0.4 ± 0.5 %'"
    )


def levels_of(given: int | ArrayLike) -> Array:
    """Levels of membership, rising from 0 to 1: so many evenly spaced ones, or those that are given."""
    if isinstance(given, int | np.integer) and not isinstance(given, bool):
        if given < 2:
            raise FrameError(f"levels is {given}: give 2 or more, or the levels themselves, which rise from 0 to 1")
        return np.linspace(0.0, 1.0, int(given))
    levels = finite(np.asarray(given), "levels")
    if levels.ndim != 1 or len(levels) < 2 or levels[0] != 0.0 or levels[-1] != 1.0 or np.any(np.diff(levels) <= 0.0):
        raise FrameError(f"levels are {levels.tolist()}: let them rise from 0 to 1, or give their number")
    return levels
