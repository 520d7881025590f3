"""Cuts of a fuzzy result from the cuts of the fuzzy inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.checked import check_gradient, whole_number
from ...framework.errors import FrameError
from ..sampling import samples_first
from .number import FuzzyNumber, fuzzy_of, levels_of, membership_within
from .search import Extremes, corners_only, search

Array = NDArray[np.float64]

METHODS = ("search", "corners", "first order")
# Largest number of inputs for which all corners are evaluated.
MOST_CORNERS = 16
# Step of the differences as a share of half the widest cut: the error is some 3e-14 times the fifth derivative.
STEP = 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class FuzzyResult:
    """Cuts of a result at each level of membership; made by `propagate_fuzzy` and `Motion.fuzzy`.

    Attributes
    ----------
    levels
        Levels of membership, rising from 0 to 1, (a,).
    lower, upper
        Lower and upper ends of the cuts, (a, ...), in the unit of the result.
    at_lower, at_upper
        Inputs at which the result has these values, by name, (a, ...); empty for the method ``"first order"``.
    method
        Name of the method, as for `propagate_fuzzy`.
    evaluations
        Number of points at which the function was evaluated.
    failed
        Number of those points at which a result was NaN; such results are ignored.
    """

    levels: Array
    lower: Array
    upper: Array
    at_lower: Mapping[str, Array]
    at_upper: Mapping[str, Array]
    method: str
    evaluations: int = 0
    failed: int = 0

    def __repr__(self) -> str:
        lost = f", {self.failed} of them without a result" if self.failed else ""
        told = f"{self.method}, {self.evaluations} evaluations{lost}" if self.evaluations else self.method
        if self.lower.ndim > 1:
            return f"<FuzzyResult of shape {self.lower.shape[1:]} at {len(self.levels)} levels: {told}>"
        core = f"{self.lower[-1]:.6g} to {self.upper[-1]:.6g} possible"
        return f"<FuzzyResult: {core}, {self.lower[0]:.6g} to {self.upper[0]:.6g} at all: {told}>"

    def membership(self, value: ArrayLike) -> Array:
        """Membership of values of the result: the highest level whose cut contains them.

        Parameters
        ----------
        value
            Values (...) of a shape that broadcasts with the result, in its unit.

        Returns
        -------
        ndarray
            Membership (...) from 0 to 1, 0 outside all cuts, interpolated linearly between levels.
        """
        return membership_within(self.levels, self.lower, self.upper, np.asarray(value, dtype=np.float64))

    def number(self, *index: int) -> FuzzyNumber:
        """One component of the result as a fuzzy number.

        Parameters
        ----------
        *index
            Indices of the component in the result; none for a scalar result.

        Returns
        -------
        FuzzyNumber
            The fuzzy number with the cuts of the component.

        Raises
        ------
        FrameError
            If a cut is NaN.
        """
        lower, upper = (np.moveaxis(each, 0, -1)[index] for each in (self.lower, self.upper))
        return FuzzyNumber(self.levels, lower, upper)


def propagate_fuzzy(
    fn: Callable[..., ArrayLike],
    inputs: Mapping[str, Any],
    *,
    levels: int | ArrayLike = 11,
    method: str = "search",
    gradient: Callable[..., Mapping[str, ArrayLike]] | None = None,
    samples: int = 128,
    axis: int = 0,
) -> FuzzyResult:
    """Find the cuts of a result from those of its inputs, at each level of membership.

    The cut of a result is the interval from its smallest to its largest value while every input is within its own cut:
    the extension principle for independent inputs (H. T. Nguyen, 1978; W. Dong & H. Shah,
    *Vertex method for computing functions of fuzzy variables*, 1987).

    Parameters
    ----------
    fn
        Function of arrays, as for `propagate`: for n values of each input, passed by keyword, it returns n results
        (n, ...).
    inputs
        Fuzzy inputs by the name of the argument: a `FuzzyNumber`, an interval (low, high), a triangle (low, peak,
        high), four corners of a trapezium, or a tolerance as text, such as ``"0.4 ± 0.5 %"``.
    levels
        Number of evenly spaced levels, or the levels themselves, (a,), rising from 0 to 1.
    method
        ``"search"``: search for the smallest and largest values from the corners and from points within each box, for
        any function; smooth functions are solved to rounding unless all points miss the region of the extreme value.
        ``"corners"``: exact if the result is monotonic in each input. ``"first order"``: by the derivatives at the
        middle of the core, exact if the function is linear.
    gradient
        For ``"first order"``: function called by keyword with the inputs at the middle, which returns the derivatives
        by name, (...) each. Differences are taken if None.
    samples
        Number of points within the box of each level at which the function is evaluated before the search.
    axis
        Axis of the n values in the array that `fn` returns.

    Returns
    -------
    FuzzyResult
        Cuts of every component of the result.

    Raises
    ------
    FrameError
        If an argument is invalid.

    Examples
    --------
    A function that is not monotonic: the squares of the numbers from -1 to 2 lie between 0 and 4.

    >>> found = propagate_fuzzy(lambda x: x**2, {"x": (-1.0, 0.5, 2.0)}, levels=3)
    >>> found.lower.round(9).tolist(), found.upper.tolist()
    ([0.0, 0.0, 0.25], [4.0, 1.5625, 0.25])
    >>> float(found.membership(1.5625))
    0.5
    """
    if not isinstance(inputs, Mapping) or not inputs:
        raise FrameError("propagate_fuzzy was given no input: name an argument of the function and its fuzzy number")
    if method not in METHODS:
        raise FrameError(f"method of propagate_fuzzy is {method!r}: choose one of {', '.join(METHODS)}")
    if method == "corners" and len(inputs) > MOST_CORNERS:
        raise FrameError(f"{len(inputs)} inputs have {2 ** len(inputs)} corners: take the method 'search'")
    given = {name: fuzzy_of(name, each) for name, each in inputs.items()}
    at = levels_of(levels)
    cuts = np.array([each.cut(at) for each in given.values()])
    function = _Function(fn, tuple(given), axis)
    lower, upper = np.ascontiguousarray(cuts[:, 0].T), np.ascontiguousarray(cuts[:, 1].T)
    if method == "first order":
        return _first_order(function, at, lower, upper, gradient)
    found = Extremes(function, lower, upper)
    if method == "corners":
        corners_only(found)
    else:
        search(found, whole_number(samples, "samples", 1))
    least, greatest = np.where(found.value < np.inf, found.value, np.nan) * np.array([1.0, -1.0])[:, None, None]
    at_least, at_greatest = (
        {name: function.shaped(points[..., k]) for k, name in enumerate(given)} for points in found.point
    )
    return FuzzyResult(
        at,
        function.shaped(least),
        function.shaped(greatest),
        at_least,
        at_greatest,
        method,
        found.evaluations,
        found.failed,
    )


def _first_order(
    function: _Function,
    levels: Array,
    lower: Array,
    upper: Array,
    gradient: Callable[..., Mapping[str, ArrayLike]] | None,
) -> FuzzyResult:
    middle = 0.5 * (lower[-1] + upper[-1])
    half = 0.5 * (upper[0] - lower[0])
    steps = np.array([-2.0, -1.0, 1.0, 2.0])[:, None, None] * STEP * np.diag(half)
    stencil = np.concatenate([middle[None], (middle + steps).reshape(-1, len(middle))])
    values = function(stencil if gradient is None else np.stack([middle] * 2))
    if gradient is None:
        two, one, other, last = values[1:].reshape(4, len(middle), values.shape[1])
        width = np.where(half > 0.0, 12.0 * STEP * half, 1.0)[:, None]
        slopes = (8.0 * (other - one) - (last - two)) / width
    else:
        given = gradient(**dict(zip(function.names, middle.tolist(), strict=True)))
        check_gradient(given, function.names)
        slopes = np.stack([np.broadcast_to(given[name], function.shape).reshape(-1) for name in function.names])
    ends = np.stack([(lower - middle)[..., None] * slopes, (upper - middle)[..., None] * slopes])
    least, greatest = values[0] + ends.min(axis=0).sum(axis=1), values[0] + ends.max(axis=0).sum(axis=1)
    count = len(stencil) if gradient is None else 2
    return FuzzyResult(levels, function.shaped(least), function.shaped(greatest), {}, {}, "first order", count)


class _Function:
    """The user's function, called with points (n, k), with its results flattened to (n, m)."""

    def __init__(self, fn: Callable[..., ArrayLike], names: tuple[str, ...], axis: int) -> None:
        self.fn, self.names, self.axis = fn, names, axis
        self.shape: tuple[int, ...] = ()

    def __call__(self, points: Array) -> Array:
        # A single point is evaluated twice, because functions may treat a batch of one differently.
        rows = np.concatenate([points, points[:1]]) if len(points) == 1 else points
        found = samples_first(self.fn(**dict(zip(self.names, rows.T.copy(), strict=True))), len(rows), self.axis)
        self.shape = found.shape[1:]
        return found[: len(points)].reshape(len(points), -1)

    def shaped(self, values: Array) -> Array:
        """Values (a, m) in the shape of the result, (a, ...)."""
        return values.reshape(len(values), *self.shape)
