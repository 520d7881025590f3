"""Other distributions of the same inputs without new solutions, by importance weights of the samples."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.errors import FrameError
from ..intervals import ConfidenceInterval, by_error, checked_level, checked_probability, interval_of
from ..quantiles import log_density
from .inputs import JointInputs

Array = NDArray[np.float64]

# Probabilities of the new distribution at whose quantiles the old one must have a density.
_ASKED = np.array([1e-6, 1e-4, 0.01, 0.1, 0.5, 0.9, 0.99, 1 - 1e-4, 1 - 1e-6])


@dataclass(frozen=True, eq=False)
class Reweighted:
    """Statistics of weighted samples; made by `Propagation.reweighted`.

    Attributes
    ----------
    samples
        Samples of the result, (n, ...).
    weights
        Ratio of the new density of the inputs to the old, scaled to a sum of one, (n,).
    nan_policy
        What is done with samples that are NaN.
    """

    samples: Array
    weights: Array
    nan_policy: str

    @property
    def effective_sample_size(self) -> float:
        """Effective number of independent samples of the new distributions (Kish): (Σ w)²/Σ w²."""
        return float(1.0 / np.sum(self.weights**2))

    @property
    def _of_each(self) -> Array:
        """Normalised weights for each entry of the result, (n, ...)."""
        weights = self.weights.reshape(-1, *(1,) * (self.samples.ndim - 1))
        lost = np.isnan(self.samples)
        if self.nan_policy != "omit" or not lost.any():
            return np.broadcast_to(weights, self.samples.shape)
        there = np.where(lost, 0.0, weights)
        with np.errstate(invalid="ignore"):
            return np.asarray(there / there.sum(axis=0))

    @property
    def _filled(self) -> Array:
        if self.nan_policy != "omit":
            return self.samples
        return np.nan_to_num(self.samples, nan=0.0, posinf=np.inf, neginf=-np.inf)

    @property
    def mean(self) -> Array:
        """Mean of the result under the other inputs, (...)."""
        return np.asarray(np.sum(self._of_each * self._filled, axis=0))

    @property
    def std(self) -> Array:
        """Standard deviation, (...)."""
        weights = self._of_each
        share = 1.0 - np.sum(weights**2, axis=0)
        with np.errstate(invalid="ignore", divide="ignore"):
            return np.asarray(np.sqrt(np.sum(weights * (self._filled - self.mean) ** 2, axis=0) / share))

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean of independent samples, √Σ w² (x − mean)², (...)."""
        with np.errstate(invalid="ignore"):
            return np.asarray(np.sqrt(np.sum((self._of_each * (self._filled - self.mean)) ** 2, axis=0)))

    @property
    def std_standard_error(self) -> Array:
        """Standard error of `std`, (...), by the derivative of the weighted variance to each weight."""
        with np.errstate(invalid="ignore", divide="ignore"):
            square = (self._filled - self.mean) ** 2
            error = np.sqrt(np.sum((self._of_each * (square - self.std**2)) ** 2, axis=0))
            return np.where(self.std == 0.0, 0.0, error / (2.0 * self.std))

    def quantile(self, p: ArrayLike) -> Array:
        """Quantile of the result at one or more probabilities.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Least samples at which the sum of the weights reaches `p`, (k..., ...).
        """
        asked = finite(p, "probability p of a quantile")
        order = np.argsort(self.samples, axis=0, kind="stable")
        ordered = np.take_along_axis(self.samples, order, axis=0)
        total = np.cumsum(np.take_along_axis(self._of_each, order, axis=0), axis=0)
        lost = np.isnan(self.samples)
        none = lost.all(axis=0) if self.nan_policy == "omit" else lost.any(axis=0)
        last = np.maximum(np.count_nonzero(~np.isnan(ordered), axis=0) - 1, 0)
        found = []
        for each in asked.ravel():
            below = total < checked_probability(float(each)) * (1.0 - 1e-14)
            at = np.minimum(np.count_nonzero(below, axis=0), last)
            found.append(np.where(none, np.nan, np.take_along_axis(ordered, at[None], axis=0)[0]))
        return np.reshape(np.array(found), (*asked.shape, *self.samples.shape[1:]))

    def confidence_interval(self, level: float = 0.95, of: str | float = "mean") -> ConfidenceInterval:
        """Confidence interval of a number of independent samples.

        Parameters
        ----------
        level
            Probability that the interval holds the true value.
        of
            ``"mean"``, ``"std"``, or the probability of a quantile, by the standard error of the weights
            below it.

        Returns
        -------
        ConfidenceInterval
            Bounds, (...).

        Raises
        ------
        FrameError
            If `level` or `of` cannot be meant.
        """
        return interval_of(self, of, level, self._quantile_interval)

    def _quantile_interval(self, p: float, level: float) -> ConfidenceInterval:
        p, level = checked_probability(p), checked_level(level)
        value = self.quantile(p)
        error = np.sqrt(np.sum((self._of_each * ((self.samples <= value) - p)) ** 2, axis=0))
        low, high = by_error(p, error, level)
        flat = self.samples.reshape(len(self.samples), -1)
        parts = [Reweighted(flat[:, [k]], self.weights, self.nan_policy) for k in range(flat.shape[1])]
        bounds = [
            [float(part.quantile(float(np.clip(each.flat[k], 0.0, 1.0)))[0]) for k, part in enumerate(parts)]
            for each in (np.nan_to_num(low), np.nan_to_num(high))
        ]
        below, above = (np.reshape(each, self.samples.shape[1:]) for each in bounds)
        return ConfidenceInterval(below, above)

    def __repr__(self) -> str:
        return (
            f"Reweighted, {len(self.weights)} samples worth {self.effective_sample_size:.4g} independent ones\n"
            f"  mean {self.mean} ± {self.standard_error}\n  std {self.std} ± {self.std_standard_error}"
        )


def reweighted(
    samples: Array, inputs: dict[str, Array], before: JointInputs, after: JointInputs, nan_policy: str
) -> Reweighted:
    """Samples weighted by the ratio of two densities of their inputs."""
    for name, distribution in after.distributions.items():
        if distribution is before.distributions[name]:
            continue
        reach = np.asarray(distribution.ppf(_ASKED))
        beyond = reach[np.isneginf(log_density(name, before.distributions[name], reach))]
        if beyond.size:
            raise FrameError(
                f"the new distribution of {name!r} reaches {beyond[0]:.6g}, where the old one has no density: no "
                "sample lies there; propagate the new one, or a wider one that covers both"
            )
    logarithm = after.log_ratio(before, inputs)
    weights = np.exp(logarithm - logarithm.max())
    return Reweighted(samples, weights / weights.sum(), nan_policy)
