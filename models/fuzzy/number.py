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
    """A fuzzy number, given by its cuts at some levels of membership and interpolated linearly between them.

    The cut at a level is the interval of all values whose membership is that level or more (L. A. Zadeh,
    *Fuzzy sets*, 1965).

    Attributes
    ----------
    levels
        Levels of membership, rising from 0 to 1, (n,).
    lower, upper
        Lower and upper ends of the cuts, (n,), in the unit of the input; each cut lies within those of lower levels.

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
                f"a fuzzy number has levels of shape {levels.shape} and cuts of shapes {lower.shape}, {upper.shape}: "
                "give as many of each, two or more"
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
        """Triangular fuzzy number: membership 1 at the peak, falling linearly to 0 on both sides.

        Parameters
        ----------
        low
            Smallest possible value, in the unit of the input.
        peak
            Value with membership 1, in the same unit.
        high
            Largest possible value, in the same unit.

        Returns
        -------
        FuzzyNumber
            The fuzzy number with cuts at levels 0 and 1.

        Raises
        ------
        FrameError
            If the values do not rise from `low` to `high`.
        """
        return cls.trapezoidal(low, peak, peak, high)

    @classmethod
    def trapezoidal(cls, low: float, first: float, last: float, high: float) -> FuzzyNumber:
        """Trapezoidal fuzzy number: membership 1 over an interval, falling linearly to 0 on both sides.

        Parameters
        ----------
        low
            Smallest possible value, in the unit of the input.
        first, last
            Ends of the interval with membership 1, in the same unit.
        high
            Largest possible value, in the same unit.

        Returns
        -------
        FuzzyNumber
            The fuzzy number with cuts at levels 0 and 1.

        Raises
        ------
        FrameError
            If the values do not rise from `low` to `high`.
        """
        return cls.from_cuts([0.0, 1.0], [low, first], [high, last])

    @classmethod
    def from_cuts(cls, levels: ArrayLike, lower: ArrayLike, upper: ArrayLike) -> FuzzyNumber:
        """Fuzzy number with given cuts.

        Parameters
        ----------
        levels
            Levels of membership, rising from 0 to 1, (n,).
        lower, upper
            Lower and upper ends of the cuts, (n,), in the unit of the input.

        Returns
        -------
        FuzzyNumber
            The fuzzy number, interpolated linearly between the cuts.

        Raises
        ------
        FrameError
            If the levels do not rise from 0 to 1, or a cut does not lie within the one below it.
        """
        return cls(np.asarray(levels), np.asarray(lower), np.asarray(upper))

    def __repr__(self) -> str:
        first, last = self.lower[-1], self.upper[-1]
        core = f"{first:.6g}" if first == last else f"{first:.6g} to {last:.6g}"
        return f"<FuzzyNumber: {core}, from {self.lower[0]:.6g} to {self.upper[0]:.6g}>"

    def cut(self, level: ArrayLike) -> tuple[Any, Any]:
        """Cut at a level: the interval of all values whose membership is that level or more.

        Parameters
        ----------
        level
            Levels from 0 to 1, (...).

        Returns
        -------
        tuple of float or ndarray
            Lower and upper end of the cut, (...), in the unit of the input.
        """
        at = np.asarray(level, dtype=np.float64)
        ends = (np.interp(at, self.levels, each) for each in (self.lower, self.upper))
        low, high = (float(each) if each.ndim == 0 else each for each in map(np.asarray, ends))
        return low, high

    def membership(self, value: ArrayLike) -> Any:
        """Membership of values: the highest level whose cut contains them, 0 outside all cuts.

        Parameters
        ----------
        value
            Values (...), in the unit of the input.

        Returns
        -------
        float or ndarray
            Membership (...), from 0 to 1.
        """
        x = np.asarray(value, dtype=np.float64)
        found = membership_within(self.levels, self.lower, self.upper, x)
        return float(found) if found.ndim == 0 else found


def membership_within(levels: Array, lower: Array, upper: Array, x: Array) -> Array:
    """Membership (...) of values (...) for nested cuts (n, ...), interpolated linearly between the levels (n,)."""
    return np.minimum(_side(levels, lower, x), _side(levels, -upper, -x))


def _side(levels: Array, rising: Array, x: Array) -> Array:
    """Highest level at which the end `rising` (n, ...), which grows with the level, is at most x; 0 if none is."""
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
    """Fuzzy number from a fuzzy number, an interval, three or four corners, or a tolerance as text."""
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
    """Levels of membership, rising from 0 to 1, from their number or from the levels themselves."""
    if isinstance(given, int | np.integer) and not isinstance(given, bool):
        if given < 2:
            raise FrameError(f"levels is {given}: give 2 or more, or the levels themselves, which rise from 0 to 1")
        return np.linspace(0.0, 1.0, int(given))
    levels = finite(np.asarray(given), "levels")
    if levels.ndim != 1 or len(levels) < 2 or levels[0] != 0.0 or levels[-1] != 1.0 or np.any(np.diff(levels) <= 0.0):
        raise FrameError(f"levels are {levels.tolist()}: let them rise from 0 to 1, or give their number")
    return levels
