"""A function of uncertain inputs as a function of a table of values, with first and second derivatives."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.checked import whole_number
from ....framework.errors import FrameError
from ...distributions import Uncertain
from ...propagation.correlation import GaussianCopula, Pairs
from ...propagation.inputs import JointInputs
from ...sampling import samples_first
from ..limit_state import Function, checked_values, nan_as_failure
from .marginal import Marginal

Array = NDArray[np.float64]

# Steps of the differences for first and second derivatives, in half distances between the quantiles at ±1 standard
# deviation of a normal distribution.
STEP, WIDER = 1e-4, 1e-3


@dataclass(frozen=True, eq=False)
class InputFunction:
    """A function of uncertain inputs called with a table of their values, a row for each sample.

    Parameters
    ----------
    function
        Function as for `reliability` or, with `by_keyword`, for `propagate`.
    inputs
        Joint distribution of the k inputs.
    gradient
        Derivatives with respect to the inputs, as for `reliability`; differences are taken if None.
    poses
        Numbers of the poses, counted from 0, one result for each, (p,); None if there are no poses.
    anywhere
        Whether the only result is the smallest value over all poses.
    by_keyword
        Whether the inputs are passed by keyword, as in `propagate`.
    outputs
        Number p of the results.
    """

    function: Function
    inputs: JointInputs
    gradient: Function | None
    poses: NDArray[np.int64] | None
    anywhere: bool
    by_keyword: bool
    outputs: int = 1

    @classmethod
    def of(
        cls,
        function: Function,
        distributions: Mapping[str, Uncertain],
        correlation: GaussianCopula | Pairs | ArrayLike | None,
        gradient: Function | None,
        poses: int | None,
        anywhere: bool,
        by_keyword: bool,
    ) -> InputFunction:
        """Check the arguments of `to_openturns` or `to_pystra` and build the function."""
        inputs = JointInputs.of(distributions, correlation)
        if not inputs.names:
            raise FrameError("no distributions were given: nothing is uncertain")
        if by_keyword and (poses is not None or gradient is not None):
            raise FrameError("by_keyword is for functions of propagate, which have no poses and no gradient: omit them")
        at = None if poses is None else np.arange(whole_number(poses, "number of poses", 1))
        found = cls(function, inputs, gradient, at, anywhere and at is not None, by_keyword)
        return replace(found, outputs=found._count())

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return self.inputs.names

    @property
    def marginals(self) -> list[Marginal]:
        """Distribution of each input."""
        return [Marginal(name, distribution) for name, distribution in self.inputs.distributions.items()]

    def _count(self) -> int:
        if self.poses is not None and not self.anywhere:
            return len(self.poses)
        if not self.by_keyword:
            return 1
        median = np.array([each.middle[0] for each in self.marginals])
        return int(self(np.stack([median, median])).shape[1])

    def only(self, output: int | None) -> InputFunction:
        """Function with one of the results only; NaN becomes minus infinity, so that it counts as failure."""
        if output is None and self.outputs > 1:
            raise FrameError(f"there are {self.outputs} results: give the number of one, from 0 on")
        number = 0 if output is None else whole_number(output, "number of the result", 0)
        if number >= self.outputs:
            raise FrameError(f"result number {number} of {self.outputs}: count from 0 on")
        if self.by_keyword:
            function = self.function

            def one(**samples: Array) -> Array:
                found = function(**samples)
                results = samples_first(_without_status(found), len(next(iter(samples.values()))), 0)
                return nan_as_failure(results.reshape(len(results), -1)[:, number])

            return replace(self, function=one, outputs=1)
        chosen = self.poses if self.poses is None or self.anywhere else self.poses[[number]]
        failing = self.function
        return replace(self, function=lambda *given: nan_as_failure(failing(*given)), poses=chosen, outputs=1)

    def __call__(self, points: Array) -> Array:
        """Results (m, p) for inputs (m, k), in one call of the function."""
        samples = dict(zip(self.names, np.ascontiguousarray(points.T), strict=True))
        if self.by_keyword:
            found = samples_first(_without_status(self.function(**samples)), len(points), 0)
            return found.reshape(len(points), -1)
        table = self._called(self.function, points)
        return table.min(axis=1, keepdims=True) if self.anywhere else table

    def slopes(self, points: Array) -> Array:
        """Derivatives (n, k, p) of the results with respect to the inputs, at inputs (n, k)."""
        if self.gradient is None:
            return self._differences(points)
        by_input = self._arguments_of(self.gradient, points)
        if isinstance(by_input, tuple):
            # The gradient returned a pair of the values and the derivatives.
            by_input = by_input[1]
        table = np.stack(
            [np.asarray(by_input[name], dtype=np.float64).reshape(len(points), -1) for name in self.names], axis=1
        )
        if self.anywhere:
            least = self._called(self.function, points).argmin(axis=1)
            table = np.take_along_axis(table, least[:, None, None], axis=2)
        return table

    def curvature(self, point: Array) -> Array:
        """Second derivatives (k, k, p) at inputs (k,)."""
        around, widths = self._around(point[None], WIDER)
        slopes = self.slopes(around[0]).reshape(2, len(point), len(point), self.outputs)
        found = (slopes[0] - slopes[1]) / widths[0][:, None, None]
        return np.asarray(0.5 * (found + np.swapaxes(found, 0, 1)))

    def _differences(self, points: Array) -> Array:
        n, k = points.shape
        around, widths = self._around(points, STEP)
        found = self(around.reshape(-1, k)).reshape(n, 2, k, self.outputs)
        return np.asarray((found[:, 0] - found[:, 1]) / widths[:, :, None])

    def _around(self, points: Array, step: float) -> tuple[Array, Array]:
        """Inputs one step above and below in each component, (n, 2 k, k), and the distances between them, (n, k).

        The values stay within the supports of the distributions.
        """
        marginals = self.marginals
        steps = step * np.array([each.middle[1] for each in marginals])
        low, high = np.array([each.support for each in marginals]).T
        above, below = np.minimum(points + steps, high), np.maximum(points - steps, low)
        rows = np.repeat(points[:, None, None], 2, axis=1).repeat(points.shape[1], axis=2)
        every = np.arange(points.shape[1])
        rows[:, 0, every, every], rows[:, 1, every, every] = above, below
        return rows.reshape(len(points), -1, points.shape[1]), above - below

    def _called(self, function: Callable[..., Any], points: Array) -> Array:
        count = 1 if self.poses is None else len(self.poses)
        found = checked_values(self._arguments_of(function, points), len(points) * count)
        return found.reshape(len(points), count)

    def _arguments_of(self, function: Callable[..., Any], points: Array) -> Any:
        if self.poses is None:
            return function(dict(zip(self.names, np.ascontiguousarray(points.T), strict=True)))
        rows = np.repeat(points, len(self.poses), axis=0)
        samples = dict(zip(self.names, np.ascontiguousarray(rows.T), strict=True))
        return function(samples, np.tile(self.poses, len(points)))


def _without_status(found: Any) -> Any:
    """Results without the status that a function for `propagate` may return as well."""
    return (
        found[0] if isinstance(found, tuple) and len(found) == 2 and np.asarray(found[1]).dtype.kind in "UT" else found
    )
