"""First- and second-order moments of a result from its derivatives at the mean of the inputs."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import numbers
from ...framework.checked import check_gradient
from ...framework.errors import FrameError
from ..distributions import Uncertain
from ..sampling import samples_first
from .chunk import Function
from .correlation import GaussianCopula, Pairs, is_normal, over_scores
from .inputs import JointInputs

Array = NDArray[np.float64]

# Step of the differences, in standard deviations; the error of fourth-order formulas is then some 1e-7.
STEP = 0.05


@dataclass(frozen=True, eq=False, repr=False)
class TaylorMoments:
    """Mean and spread of a result by its expansion about the mean of the inputs; made by `taylor_moments`.

    Attributes
    ----------
    inputs
        Names of the k inputs.
    order
        1 or 2.
    value
        The result at the mean of the inputs, (...).
    gradient
        First derivatives, (..., k).
    hessian
        Second derivatives, (..., k, k); None of first order.
    mean, std
        Of the result, (...).
    covariance
        Of the inputs, (k, k).
    """

    inputs: tuple[str, ...]
    order: int
    value: Array
    gradient: Array
    hessian: Array | None
    mean: Array
    std: Array
    covariance: Array

    @property
    def shares(self) -> Array:
        """Share of each input in the variance to first order, (..., k); with correlated inputs half of what two share.

        That is g_i Σ_j C_ij g_j/gᵀ C g.
        """
        parts = self.gradient * np.einsum("ij,...j->...i", self.covariance, self.gradient)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(parts / parts.sum(axis=-1, keepdims=True))

    @property
    def result_covariance(self) -> Array:
        """Covariance to first order of the components along the last axis of the result, ``G C G^T``, (..., c, c)."""
        rows = self.gradient if self.mean.ndim else self.gradient[None]
        return np.asarray(rows @ self.covariance @ np.swapaxes(rows, -1, -2))

    def __repr__(self) -> str:
        text = f"TaylorMoments of order {self.order}: mean {self.mean}, std {self.std}"
        if self.mean.ndim:
            return text
        rows = [f"{name:>16}{100 * share:>8.1f} %" for name, share in zip(self.inputs, self.shares, strict=True)]
        return "\n".join([text, *rows])


def taylor_moments(
    fn: Function,
    distributions: Mapping[str, Uncertain],
    *,
    order: int = 1,
    gradient: Callable[..., Any] | None = None,
    hessian: Callable[..., ArrayLike] | None = None,
    axis: int = 0,
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
) -> TaylorMoments:
    """Estimate mean and spread of a result from its derivatives at the mean of the inputs, without samples.

    To first order ``mean = f`` and ``variance = gᵀ C g``. To second order and for independent inputs with the central
    moments σ², μ₃, μ₄ (Hahn & Shapiro, *Statistical Models in Engineering*, 1967, section 7.2)::

        mean = f + ½ Σ H_ii σ_i²
        variance = Σ g_i² σ_i² + Σ g_i H_ii μ₃_i + ¼ Σ H_ii² (μ₄_i − σ_i⁴) + ½ Σ_{i≠j} H_ij² σ_i² σ_j²

    Parameters
    ----------
    fn
        Function of arrays, as for `propagate`.
    distributions
        By the name of the argument, as for `propagate`.
    order
        1 or 2.
    gradient
        First derivatives where they are known, as from an adjoint: called by keyword with the mean of each input, it
        returns them by name, (...) each, or as (..., k). Left out, they are differences of `fn`, in one call.
    hessian
        Second derivatives likewise, (..., k, k).
    axis
        Axis of the samples in what `fn` returns.
    correlation
        As for `propagate`; to second order for normal inputs alone.

    Returns
    -------
    TaylorMoments
        Mean, standard deviation and derivatives.

    Raises
    ------
    FrameError
        If an input or option cannot be meant, or derivatives have another shape than the result.

    Examples
    --------
    >>> from scipy import stats
    >>> found = taylor_moments(lambda x: x**2, {"x": stats.norm(3.0, 0.5)}, order=2)
    >>> bool(abs(found.mean - 9.25) < 1e-9), bool(abs(found.std**2 - (36 * 0.25 + 2 * 0.0625)) < 1e-8)
    (True, True)
    """
    if not distributions:
        raise FrameError("taylor_moments was given no input: name an argument of the function and its distribution")
    if order not in (1, 2):
        raise FrameError(f"order is {order!r}: give 1 or 2")
    joint = JointInputs.of(distributions, correlation)
    if order == 2 and joint.scores is not None and not all(map(is_normal, joint.distributions.values())):
        raise FrameError("second-order moments of correlated inputs need normal ones: take polynomial_chaos")
    means, central = _central(joint)
    sigma = np.sqrt(central[:, 0])
    if not np.all(sigma > 0.0):
        raise FrameError(f"{joint.names[int(np.argmin(sigma))]!r} does not vary: leave it out")
    covariance = joint.correlation() * np.outer(sigma, sigma)
    differences = _Differences(fn, joint.names, means, sigma, axis)
    at = dict(zip(joint.names, means.tolist(), strict=True))
    needs_second = order == 2 and hessian is None
    differences.call(first=gradient is None, second=needs_second)
    value = differences.value
    g = differences.first() if gradient is None else _given_gradient(gradient(**at), joint.names, value)
    h = None
    if order == 2:
        h = differences.second() if hessian is None else _shaped(hessian(**at), (*value.shape, *covariance.shape))
    mean, variance = _moments(value, g, h, covariance, central, joint.scores is None)
    return TaylorMoments(joint.names, order, value, g, h, mean, np.sqrt(np.maximum(variance, 0.0)), covariance)


def _moments(
    value: Array, g: Array, h: Array | None, covariance: Array, central: Array, independent: bool
) -> tuple[Array, Array]:
    variance = np.einsum("...i,ij,...j->...", g, covariance, g)
    if h is None:
        return value, variance
    mean = value + 0.5 * np.einsum("...ij,ij->...", h, covariance)
    rotated = h @ covariance
    both = 0.5 * np.einsum("...ij,...ji->...", rotated, rotated)
    if independent:
        # The sum over i = j of what holds for normal inputs, ½ H_ii² σ_i⁴, is replaced.
        own = np.diagonal(h, axis1=-2, axis2=-1)
        square, third, fourth = central.T
        both = both + np.sum(g * own * third + 0.25 * own**2 * (fourth - 3.0 * square**2), axis=-1)
    return mean, variance + both


def _central(joint: JointInputs) -> tuple[Array, Array]:
    """Means of the inputs, (k,), and their second to fourth central moments, (k, 3), over a grid of normal scores."""
    means, central = [], []
    for name, distribution in joint.distributions.items():
        values, weights = over_scores(name, distribution)
        middle = values[len(values) // 2]
        mean = middle + weights @ (values - middle)
        off = values - mean
        means.append(mean)
        central.append([weights @ off**power for power in (2, 3, 4)])
    return np.array(means), np.array(central)


def _given_gradient(given: Any, names: tuple[str, ...], value: Array) -> Array:
    if isinstance(given, Mapping):
        check_gradient(given, names)
        given = np.stack([np.broadcast_to(given[name], value.shape) for name in names], axis=-1)
    return _shaped(given, (*value.shape, len(names)))


def _shaped(given: ArrayLike, shape: tuple[int, ...]) -> Array:
    found = numbers(given, "the derivatives")
    if found.shape != shape:
        raise FrameError(f"the derivatives have shape {found.shape}: give {shape}, those of the result and the inputs")
    return found


class _Differences:
    """Derivatives by central differences of fourth order, all from one call of the function."""

    def __init__(self, fn: Function, names: tuple[str, ...], means: Array, sigma: Array, axis: int) -> None:
        self.fn, self.names, self.means, self.axis = fn, names, means, axis
        self.step = STEP * sigma
        self.rows: dict[tuple[int, ...], int] = {}

    def call(self, *, first: bool, second: bool) -> None:
        """Call the function at the mean and, for differences, around it."""
        k = len(self.names)
        at: list[tuple[int, ...]] = [(0,) * k]
        if first or second:
            at += [self._moved({i: by}) for i in range(k) for by in (-2, -1, 1, 2)]
        if second:
            corners = [(p, q) for size in (1, 2) for p in (size, -size) for q in (size, -size)]
            at += [self._moved({i: p, j: q}) for i, j in combinations(range(k), 2) for p, q in corners]
        self.rows = {each: row for row, each in enumerate(at)}
        points = self.means + np.array(at) * self.step
        # A single point would be a batch of its own kind.
        points = np.concatenate([points, points[:1]])
        inputs = dict(zip(self.names, points.T.copy(), strict=True))
        self.results = samples_first(self.fn(**inputs), len(points), self.axis)

    def _moved(self, by: Mapping[int, int]) -> tuple[int, ...]:
        return tuple(by.get(i, 0) for i in range(len(self.names)))

    @property
    def value(self) -> Array:
        """The result at the mean, (...)."""
        return np.asarray(self.results[0])

    def _result(self, by: Mapping[int, int]) -> Array:
        return np.asarray(self.results[self.rows[self._moved(by)]])

    def first(self) -> Array:
        """First derivatives, (..., k)."""
        out = []
        for i, h in enumerate(self.step):
            one = self._result({i: 1}) - self._result({i: -1})
            two = self._result({i: 2}) - self._result({i: -2})
            out.append((8.0 * one - two) / (12.0 * h))
        return np.stack(out, axis=-1)

    def second(self) -> Array:
        """Second derivatives, (..., k, k)."""
        k = len(self.names)
        out = np.empty((*self.value.shape, k, k))
        for i, h in enumerate(self.step):
            one = self._result({i: 1}) - 2.0 * self.value + self._result({i: -1})
            two = self._result({i: 2}) - 2.0 * self.value + self._result({i: -2})
            out[..., i, i] = (16.0 * one - two) / (12.0 * h**2)
        for i, j in combinations(range(k), 2):
            wide, narrow = (self._corners(i, j, size) for size in (2, 1))
            mixed = (4.0 * narrow - wide) / (3.0 * self.step[i] * self.step[j])
            out[..., i, j] = out[..., j, i] = mixed
        return out

    def _corners(self, i: int, j: int, size: int) -> Array:
        same = self._result({i: size, j: size}) + self._result({i: -size, j: -size})
        other = self._result({i: size, j: -size}) + self._result({i: -size, j: size})
        return np.asarray((same - other) / (4.0 * size**2))
