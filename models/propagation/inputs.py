"""The joint distribution of the inputs: samples from points of the unit cube, and its density."""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.errors import FrameError
from ..distributions import Distribution, Uncertain
from ..given_distributions import distributions_of
from ..quantiles import at_scores, log_density, probability, quantiles
from .correlation import GaussianCopula, Pairs, correlation_of

Array = NDArray[np.float64]

# Probabilities whose quantiles identify a distribution.
_TOLD_BY = np.array([2.0**-40, 1e-6, 1e-3, 0.01, *np.linspace(0.05, 0.95, 19), 0.99, 0.999, 1.0 - 1e-6])


@dataclass(frozen=True, eq=False)
class JointInputs:
    """Distributions of the inputs, and how they hang together.

    Parameters
    ----------
    distributions
        Distribution of each of the k inputs, by name.
    scores
        Correlation of their standard normal scores, (k, k); None where they are independent.
    """

    distributions: Mapping[str, Distribution]
    scores: Array | None = None

    @classmethod
    def of(
        cls, distributions: Mapping[str, Uncertain], correlation: GaussianCopula | Pairs | ArrayLike | None = None
    ) -> JointInputs:
        """Inputs as given by the caller, checked."""
        known = distributions_of(distributions)
        if correlation is None:
            return cls(known)
        copula = correlation if isinstance(correlation, GaussianCopula) else GaussianCopula(correlation)
        scores = copula.of_scores(known)
        return cls(known, None if np.array_equal(scores, np.eye(len(known))) else scores)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the inputs."""
        return tuple(self.distributions)

    def require_independent(self, what: str) -> None:
        """Raise an error for what has no meaning with dependent inputs."""
        if self.scores is not None:
            raise FrameError(f"{what} need independent inputs: leave the correlation out")

    @cached_property
    def _factor(self) -> Array:
        assert self.scores is not None
        return np.asarray(np.linalg.cholesky(self.scores), dtype=np.float64)

    def samples(self, points: Array) -> dict[str, Array]:
        """Samples of the inputs, (m,) each, at points of the unit cube (m, k)."""
        if self.scores is None:
            columns = list(points.T)
        else:
            from scipy.special import ndtr

            columns = [
                column if scores is None else np.minimum(ndtr(scores), 1.0 - 2.0**-53)
                for column, scores in zip(points.T, self._dependent(points), strict=True)
            ]
        pairs = zip(self.distributions.items(), columns, strict=True)
        return {name: quantiles(distribution, column) for (name, distribution), column in pairs}

    def _dependent(self, points: Array) -> list[Array | None]:
        """Normal scores of inputs that depend on those before them, (m,) each; None for the others."""
        from scipy.special import ndtri

        normal = [ndtri(np.minimum(column, 1.0 - 2.0**-53)) for column in points.T]
        out: list[Array | None] = []
        for k, row in enumerate(self._factor):
            if not row[:k].any():
                out.append(None)
                continue
            # summed here rather than by a matrix library, for the same bits on every machine
            total = row[0] * normal[0]
            for weight, each in zip(row[1 : k + 1], normal[1 : k + 1], strict=True):
                total = total + weight * each
            out.append(total)
        return out

    def at_scores(self, normal: Array) -> dict[str, Array]:
        """Values of the inputs at independent standard normal scores (m, k)."""
        scores = normal if self.scores is None else normal @ self._factor.T
        pairs = zip(self.distributions.items(), scores.T, strict=True)
        return {name: at_scores(distribution, column) for (name, distribution), column in pairs}

    def independent(self, scores: Array) -> Array:
        """Independent standard normal scores from those of the inputs, (m, k)."""
        return np.asarray(np.linalg.solve(self._factor, scores.T).T)

    def correlation(self) -> Array:
        """Correlation of the inputs themselves, (k, k)."""
        out = np.eye(len(self.distributions))
        if self.scores is not None:
            each = list(self.distributions.values())
            for i, j in zip(*np.nonzero(np.triu(self.scores, 1)), strict=True):
                out[i, j] = out[j, i] = correlation_of(each[i], each[j], float(self.scores[i, j]))
        return out

    def log_ratio(self, before: JointInputs, samples: Mapping[str, Array]) -> Array:
        """Logarithm of the ratio of the joint density at samples to that of other distributions of the inputs, (m,)."""
        total = np.zeros(len(next(iter(samples.values()))))
        for name, distribution in self.distributions.items():
            if distribution is not before.distributions[name]:
                total += log_density(name, distribution, samples[name]) - log_density(
                    name, before.distributions[name], samples[name]
                )
        return total + self._log_copula(samples) - before._log_copula(samples)

    def _log_copula(self, samples: Mapping[str, Array]) -> Array | float:
        """Logarithm of the ratio of the joint density to that of independent inputs, (m,)."""
        if self.scores is None:
            return 0.0
        from scipy.special import ndtri

        at = [probability(name, distribution, samples[name]) for name, distribution in self.distributions.items()]
        normal = ndtri(np.clip(np.stack(at), 2.0**-60, 1.0 - 2.0**-53))
        inverse = np.linalg.inv(self.scores) - np.eye(len(at))
        return np.asarray(-0.5 * (np.sum(normal * (inverse @ normal), axis=0) + np.linalg.slogdet(self.scores)[1]))

    def told(self) -> dict[str, str]:
        """Check sums of each distribution and of the correlations, which identify the inputs."""
        each = self.distributions.items()
        found = {f"the distribution of {name!r}": np.asarray(distribution.ppf(_TOLD_BY)) for name, distribution in each}
        found["the correlation"] = np.empty(0) if self.scores is None else self.scores
        return {what: check_sum(each) for what, each in found.items()}


def check_sum(numbers: Array) -> str:
    """Check sum of an array, to tell it from others."""
    return hashlib.sha256(np.asarray(numbers, dtype=np.float64).tobytes()).hexdigest()
