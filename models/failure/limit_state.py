"""The limit state as a function of the standard normal scores of the inputs, with its gradient."""

from __future__ import annotations

import inspect
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.checked import check_gradient
from ...framework.errors import FrameError
from ..propagation.inputs import JointInputs

Array = NDArray[np.float64]
Index = NDArray[np.int64]
Function = Callable[..., Any]

# Step of the central differences in scores, which have the standard deviation 1: the error is some 1e-9 times the third
# derivative, and some 1e-12 by rounding.
STEP = 1e-4
# Largest number of samples in one call of the function.
ROWS = 65536


def check_called(limit: Function, names: Sequence[str], poses: bool) -> None:
    """Raise an error if the function cannot be called with the samples of all inputs as one mapping.

    Parameters
    ----------
    limit
        The limit-state function.
    names
        Names of the inputs.
    poses
        Whether the numbers of the poses are passed as well.
    """
    try:
        inspect.signature(limit).bind(*[{}] * (2 if poses else 1))
    except ValueError:  # functions not written in Python may have no signature
        return
    except TypeError:
        given = "the samples of all inputs by name and the numbers of the poses" if poses else "the samples by name"
        first = names[0]
        raise FrameError(
            f"the limit-state function takes {inspect.signature(limit)}, but is called with {given}: "
            f"let it take one mapping x, and read x[{first!r}] for {first}"
        ) from None


def checked_values(found: ArrayLike, count: int) -> Array:
    """Values (count,) that a limit-state function returned, after a check of their shape."""
    values = np.asarray(found, dtype=np.float64)
    if values.shape != (count,):
        raise FrameError(f"the limit-state function returned shape {values.shape} for {count} samples: one each")
    return values


def nan_as_failure(found: ArrayLike) -> Array:
    """Values of a limit state with minus infinity for NaN."""
    values = np.asarray(found, dtype=np.float64)
    return np.where(np.isnan(values), -np.inf, values)


@dataclass(eq=False)
class LimitState:
    """A limit-state function of independent standard normal scores; values of zero or less are failures.

    Parameters
    ----------
    function
        Called with the samples of the inputs by name, (m,) each, and if `poses` is given with the number of the pose of
        each sample, (m,). Returns values (m,). NaN, as for a linkage that cannot be assembled, counts as failure.
    inputs
        The joint distribution of the k inputs.
    gradient
        Called in the same way; returns the derivatives with respect to the inputs, by name, (m,) each, or a pair of the
        values, (m,), and these. Differences are taken if None.
    poses
        Number of poses; None if the function does not depend on a pose.

    Attributes
    ----------
    batches, evaluations
        Number of calls of the function so far, and number of samples in them.
    """

    function: Function
    inputs: JointInputs
    gradient: Function | None = None
    poses: int | None = None
    batches: int = field(default=0, init=False)
    evaluations: int = field(default=0, init=False)

    @property
    def size(self) -> int:
        """Number of inputs."""
        return len(self.inputs.names)

    def values(self, scores: Array, pose: Index) -> Array:
        """Values (...) at scores (..., k) and poses (...); minus infinity where the function returns NaN."""
        rows, which = scores.reshape(-1, self.size), np.broadcast_to(pose, scores.shape[:-1]).reshape(-1)
        self.batches += 1
        self.evaluations += len(rows)
        parts = [slice(start, start + ROWS) for start in range(0, len(rows), ROWS)]
        found = np.concatenate([self._called(rows[part], which[part]) for part in parts] or [np.zeros(0)])
        return nan_as_failure(found).reshape(scores.shape[:-1])

    def worst(self, scores: Array) -> Array:
        """Smallest value (m,) over all poses at scores (m, k): zero or less if any pose fails."""
        return np.asarray(self.at_all_poses(scores).min(axis=1))

    def at_all_poses(self, scores: Array) -> Array:
        """Values (m, poses) at scores (m, k) and each pose."""
        count = self.poses or 1
        return self.values(np.repeat(scores[:, None], count, axis=1), np.arange(count))

    def linearised(self, scores: Array, pose: Index) -> tuple[Array, Array]:
        """Values (n,) and gradients (n, k) with respect to the scores, at scores (n, k) and poses (n,)."""
        stencil = np.concatenate([np.zeros((1, self.size)), STEP * np.eye(self.size), -STEP * np.eye(self.size)])
        if self.gradient is None:
            found = self.values(scores[:, None] + stencil, pose[:, None])
            with np.errstate(invalid="ignore"):
                slopes = (found[:, 1 : self.size + 1] - found[:, self.size + 1 :]) / (2.0 * STEP)
            return found[:, 0], np.where(np.isfinite(slopes), slopes, 0.0)
        values, by_input = self._with_gradient(self.gradient, scores, pose)
        around = self.inputs.at_scores((scores[:, None] + stencil).reshape(-1, self.size))
        slopes = np.zeros(scores.shape)
        for name, samples in around.items():
            table = samples.reshape(len(scores), -1)
            change = (table[:, 1 : self.size + 1] - table[:, self.size + 1 :]) / (2.0 * STEP)
            slopes += np.nan_to_num(by_input[name])[..., None] * change
        return values, slopes

    def _with_gradient(self, gradient: Function, scores: Array, pose: Index) -> tuple[Array, Mapping[str, Array]]:
        """Values (n,) and derivatives with respect to the inputs, in one call if the gradient returns both."""
        found = gradient(*self._arguments(self.inputs.at_scores(scores), pose))
        pair = isinstance(found, tuple) and len(found) == 2
        by_input = self._checked(found[1] if pair else found, len(scores))
        if not pair:
            return self.values(scores, pose), by_input
        self.batches += 1
        self.evaluations += len(scores)
        values = np.asarray(found[0], dtype=np.float64)
        if values.shape != (len(scores),):
            raise FrameError(
                f"the gradient returned values of shape {values.shape} for {len(scores)} samples: one each"
            )
        return nan_as_failure(values), by_input

    def _checked(self, by_input: object, count: int) -> dict[str, Array]:
        """Derivatives (m,) with respect to each input, by name."""
        if not isinstance(by_input, Mapping):
            raise FrameError(
                f"the gradient returned {type(by_input).__name__}: return derivatives by the names of the inputs, or a "
                "pair of the values and these"
            )
        check_gradient(by_input, self.inputs.names)
        out = {name: np.asarray(by_input[name], dtype=np.float64) for name in self.inputs.names}
        for name, slope in out.items():
            if slope.shape not in ((), (count,)):
                raise FrameError(f"the derivative by {name!r} has shape {slope.shape} for {count} samples: one each")
        return {name: np.broadcast_to(slope, (count,)) for name, slope in out.items()}

    def _called(self, scores: Array, pose: Index) -> Array:
        return checked_values(self.function(*self._arguments(self.inputs.at_scores(scores), pose)), len(scores))

    def _arguments(self, samples: Mapping[str, Array], pose: Index) -> tuple[object, ...]:
        return (samples,) if self.poses is None else (samples, pose)
