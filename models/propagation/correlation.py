"""Inputs that depend on each other: a Gaussian copula, and the change of correlation that Nataf's model asks for.

With the standard normal scores z of the inputs, x = F⁻¹(Φ(z)), the scores are jointly normal. Their correlation r is
not that of the inputs, ρ; it follows from

    ρ = E[(x₁(z₁) − μ₁)(x₂(z₂) − μ₂)]/(σ₁ σ₂)

(Nataf, C. R. Acad. Sci. 225, 1962; Liu & Der Kiureghian, Probabilistic Engineering Mechanics 1, 1986,
doi:10.1016/0266-8920(86)90033-0).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import combinations
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.errors import FrameError
from ..distributions import Distribution, Interval, Normal
from ..quantiles import at_scores
from .pieces import by_pieces, resolved

Array = NDArray[np.float64]
Pairs = Mapping[tuple[str, str], float]

OF = ("inputs", "ranks", "scores")
# Scores beyond which tails of inputs are neglected: the largest one at which a distribution's inverse survival function
# (`isf`) is finite, or without one that up to which a probability can be told from 1.
FAR, NEARER, WITHOUT_TAIL = 14.0, 8.6, 8.1
# Greatest ratio of the grid's step to the narrower width of the joint density: an error of exp(-2 (pi/0.65)²) = 5e-21.
FINE = 0.65
COARSEST = 2.0**-4
# Bounds of the correlation of scores in the root search.
MOST = (0.99, 1.0 - 2.0**-10)


@dataclass(frozen=True, eq=False)
class GaussianCopula:
    """Correlation of inputs, by a Gaussian copula.

    Parameters
    ----------
    correlation
        By pair of names, such as ``{("length", "width"): 0.3}``, or a matrix (k, k) in the order of the inputs.
    of
        What the numbers are correlations of: the ``"inputs"`` themselves (Nataf's model), their ``"ranks"``
        (Spearman's), or their normal ``"scores"``.

    Examples
    --------
    >>> from scipy import stats
    >>> copula = GaussianCopula({("a", "b"): 0.3})
    >>> distributions = {"a": stats.lognorm(0.2), "b": stats.norm()}
    >>> bool(abs(copula.of_scores(distributions)[0, 1] - 0.3 * (np.exp(0.04) - 1) ** 0.5 / 0.2) < 1e-15)
    True
    """

    correlation: Pairs | ArrayLike
    of: str = "inputs"

    def of_scores(self, distributions: Mapping[str, Distribution]) -> Array:
        """Correlation matrix of the standard normal scores.

        Parameters
        ----------
        distributions
            Distributions of the k inputs by name.

        Returns
        -------
        ndarray
            Positive definite, (k, k).

        Raises
        ------
        FrameError
            If a name is no input, a number no correlation, or no joint distribution has these correlations.
        """
        if self.of not in OF:
            raise FrameError(f"a copula of {self.of!r}: choose one of {', '.join(OF)}")
        names = list(distributions)
        wanted = _matrix(self.correlation, names)
        found = np.eye(len(names))
        for i, j in combinations(range(len(names)), 2):
            rho = float(wanted[i, j])
            if rho != 0.0:
                pair = (names[i], names[j])
                found[i, j] = found[j, i] = self._score(pair, rho, distributions[names[i]], distributions[names[j]])
        least = float(np.linalg.eigvalsh(found)[0]) if names else 1.0
        if least <= 1e-12:
            raise FrameError(
                f"the correlations contradict each other (least eigenvalue {least:.3g}): no joint distribution of "
                f"{', '.join(names)} has them all; make some of them smaller"
            )
        return found

    def _score(self, pair: tuple[str, str], rho: float, one: Distribution, other: Distribution) -> float:
        if self.of == "scores":
            return rho
        if self.of == "ranks":
            return float(2.0 * np.sin(np.pi * rho / 6.0))
        return nataf(pair, rho, one, other)


def _matrix(given: Pairs | ArrayLike, names: Sequence[str]) -> Array:
    k = len(names)
    if isinstance(given, Mapping):
        out = np.eye(k)
        for pair, rho in given.items():
            if not isinstance(pair, tuple) or len(pair) != 2 or pair[0] == pair[1] or not set(pair) <= set(names):
                raise FrameError(f"correlation of {pair!r}: name two different inputs of {', '.join(names)}")
            i, j = names.index(pair[0]), names.index(pair[1])
            out[i, j] = out[j, i] = finite(rho, f"correlation of {pair[0]!r} and {pair[1]!r}")
    else:
        out = np.array(finite(given, "correlation"))
        if out.shape != (k, k) or np.any(out != out.T) or np.any(np.diag(out) != 1.0):
            raise FrameError(f"correlation has shape {out.shape}: give a symmetric ({k}, {k}), ones on the diagonal")
    off = np.abs(out - np.eye(k))
    if np.any(off >= 1.0):
        raise FrameError(f"a correlation is {out.flat[off.argmax()]:g}: give numbers between -1 and 1")
    return out


# -- change of correlation --------------------------------------------------------------------------------------------


def nataf(pair: tuple[str, str], rho: float, one: Distribution, other: Distribution) -> float:
    """Correlation of the normal scores of two inputs with correlation `rho`, in closed form or by quadrature."""
    closed = _closed(rho, _kind(one), _kind(other))
    if closed is None:
        return by_quadrature(pair, rho, one, other)
    if not abs(closed) < 1.0:
        raise _impossible(pair, rho)
    return closed


def _impossible(pair: tuple[str, str], rho: float, reach: str = "") -> FrameError:
    return FrameError(
        f"inputs {pair[0]!r} and {pair[1]!r} cannot have the correlation {rho:g} by a Gaussian copula{reach}: give a "
        "smaller one, or that of their ranks (GaussianCopula(..., of='ranks'))"
    )


def _kind(distribution: Any) -> tuple[str, float]:
    """``normal``, ``uniform``, or ``lognormal`` with the standard deviation of its logarithm; else empty."""
    if isinstance(distribution, Normal):
        return "normal", 0.0
    if isinstance(distribution, Interval):
        return "uniform", 0.0
    name = (
        getattr(getattr(distribution, "dist", None), "name", "")
        or type(getattr(distribution, "variable", distribution)).__name__
    )
    if name in ("norm", "Normal", "StandardNormal"):
        return "normal", 0.0
    if name in ("uniform", "Uniform"):
        return "uniform", 0.0
    if name == "lognorm":
        return "lognormal", float(distribution.args[0] if distribution.args else distribution.kwds["s"])
    return "", 0.0


def _closed(rho: float, one: tuple[str, float], other: tuple[str, float]) -> float | None:
    """Correlation of scores by the closed forms in Liu & Der Kiureghian's table, NaN if there is none."""
    from scipy.special import ndtri

    kinds, sigma = {one[0], other[0]}, max(one[1], other[1])
    with np.errstate(invalid="ignore"):
        growth = float(np.sqrt(np.expm1(sigma**2)))
        if kinds == {"normal"}:
            return rho
        if kinds == {"normal", "uniform"}:
            return float(rho * np.sqrt(np.pi / 3.0))
        if kinds == {"uniform"}:
            return float(2.0 * np.sin(np.pi * rho / 6.0))
        if kinds == {"normal", "lognormal"}:
            return rho * growth / sigma
        if kinds == {"uniform", "lognormal"}:
            # E[exp(s z1) Phi(z2)] = exp(s²/2) Phi(r s/sqrt 2), as exp(s z1) shifts the mean of z2 by r s.
            share = 0.5 + rho * growth / np.sqrt(12.0)
            return float(np.sqrt(2.0) / sigma * ndtri(share)) if 0.0 < share < 1.0 else float("nan")
        if kinds == {"lognormal"}:
            both = np.expm1(one[1] ** 2) * np.expm1(other[1] ** 2)
            return float(np.log1p(rho * np.sqrt(both)) / (one[1] * other[1]))
    return None


def by_quadrature(pair: tuple[str, str], rho: float, one: Distribution, other: Distribution) -> float:
    """Correlation of the normal scores, solved for with the double integral by the trapezoidal rule.

    Its error falls exponentially with the step, as the integrand is smooth and falls off with the normal density.
    """
    from scipy.optimize import brentq

    integral = _Correlated(one, other)
    # closer to 1 the grid must be finer, which is seldom needed
    for most in MOST:
        low, high = integral(-most), integral(most)
        if low < rho < high:
            return float(brentq(lambda r: integral(r) - rho, -most, most, xtol=1e-14, rtol=1e-14))
    raise _impossible(pair, rho, f", only those between {low:.4g} and {high:.4g}")


def correlation_of(one: Distribution, other: Distribution, r: float) -> float:
    """Correlation of two inputs whose normal scores have the correlation `r`."""
    return r if is_normal(one) and is_normal(other) else _Correlated(one, other)(r)


def is_normal(distribution: Distribution) -> bool:
    """Whether a distribution is known to be normal."""
    return _kind(distribution)[0] == "normal"


class _Correlated:
    """Correlation of two inputs as a function of that of their normal scores."""

    def __init__(self, one: Distribution, other: Distribution) -> None:
        self.distributions = one, other
        self.known: dict[float, tuple[Array, Array, Array]] = {}

    def grid(self, step: float) -> tuple[Array, Array, Array]:
        """Scores on a grid, and the two inputs standardised at them."""
        if step not in self.known:
            scores = _scores(step, *self.distributions)
            one, other = (standardised(distribution, scores) for distribution in self.distributions)
            self.known[step] = scores, one, other
        return self.known[step]

    def __call__(self, r: float) -> float:
        narrow = np.sqrt((1.0 - r) * (1.0 + r))
        step = float(2.0 ** np.floor(np.log2(min(COARSEST, FINE * narrow))))
        scores, one, other = self.grid(step)
        off = (scores - r * scores[:, None]) / narrow
        density = np.exp(-0.5 * (off**2 + scores[:, None] ** 2))
        return float(one @ density @ other) * step**2 / (2.0 * np.pi * float(narrow))


def over_scores(name: str, distribution: Distribution) -> tuple[Array, Array]:
    """Values of an input, and their weights over its normal score, (m,) each.

    The trapezoidal rule has the digits of the quantiles where these are smooth; where they are not, pieces have them.
    """
    scores = _scores(COARSEST, distribution)
    values, weights = at_scores(distribution, scores), normal_weights(scores)
    if not np.isfinite(values).all():
        raise FrameError(f"distribution of {name!r} has quantiles that are not finite: its moments are not known")
    if resolved(values, weights):
        return values, weights
    return by_pieces(lambda at: at_scores(distribution, at), float(scores[-1]))


def _scores(step: float, *distributions: Distribution) -> Array:
    """Equidistant normal scores, as far out as the distributions can be evaluated."""
    far = min(map(_far, distributions))
    return np.asarray(step * np.arange(-np.floor(far / step), np.floor(far / step) + 1))


def _far(distribution: Distribution) -> float:
    if not hasattr(distribution, "isf"):
        return WITHOUT_TAIL
    for far in (FAR, NEARER):
        if np.isfinite(at_scores(distribution, np.array([-far, far]))).all():
            return far
    return WITHOUT_TAIL


def normal_weights(scores: Array) -> Array:
    """Weights of the trapezoidal rule under the standard normal density at equidistant scores, (m,), of sum 1."""
    density = np.exp(-0.5 * scores**2)
    return np.asarray(density / density.sum())


def standardised(distribution: Distribution, scores: Array) -> Array:
    """Values of an input at equidistant scores, (m,), with mean 0 and standard deviation 1 under the normal density."""
    values, weights = at_scores(distribution, scores), normal_weights(scores)
    if not np.isfinite(values).all():
        raise FrameError(
            f"distribution {distribution!r} has quantiles that are not finite: give the correlation of ranks"
        )
    values = values - values[len(values) // 2]
    off = values - weights @ values
    return np.asarray(off / np.sqrt(weights @ off**2))
