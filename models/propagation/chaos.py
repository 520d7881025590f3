"""Polynomial chaos: a polynomial of the inputs in place of the function; moments and Sobol indices in closed form."""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from itertools import product
from math import comb

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.checked import whole_number
from ...framework.errors import FrameError, SampleWarning
from ..distributions import Uncertain
from ..intervals import ConfidenceInterval, by_error, checked_level
from ..sampling import BLOCK, Sampler, Seed, points_of, root_seed, samples_first
from ..sensitivity import SobolIndices, constant
from .chunk import Function
from .correlation import GaussianCopula, Pairs
from .germ import Germ
from .inputs import JointInputs
from .orthogonal import MOST

Array = NDArray[np.float64]
Powers = NDArray[np.int64]

METHODS = ("regression", "quadrature")
# Samples for each coefficient, and the largest number of quadrature nodes.
OVERSAMPLED, MOST_NODES = 3, 1_000_000
# Number of random points at which a polynomial by quadrature is checked.
CHECKED = 256
# Polynomials of normal scores are preferred if they leave at most this share of what those of the inputs leave.
PREFERRED = 0.5


@dataclass(frozen=True, eq=False)
class LeftOver:
    """What a polynomial leaves of the variance at points that it was not fitted to.

    Attributes
    ----------
    share
        Share of the variance, (...).
    error
        Its standard error, by the scatter of the squared errors, (...).
    points
        Which points, in words.
    """

    share: Array
    error: Array
    points: str

    @classmethod
    def of(cls, errors: Array, results: Array, shape: tuple[int, ...], points: str) -> LeftOver:
        """Share of variance from errors (m, e) at points and results (m', e) of the function; 0 for a constant."""
        steady = _constant(results)
        square = errors**2 / np.where(steady, 1.0, np.var(results, axis=0))
        share, error = np.mean(square, axis=0), np.std(square, axis=0, ddof=1) / np.sqrt(len(square))
        share, error = (np.where(steady, 0.0, each).reshape(shape) for each in (share, error))
        return cls(share, error, points)

    def interval(self, level: float) -> ConfidenceInterval:
        """Bounds on the share, (...), taking its estimate as log-normal."""
        from scipy.special import ndtri

        z = ndtri(0.5 + 0.5 * checked_level(level))
        with np.errstate(invalid="ignore", divide="ignore"):
            spread = np.exp(z * np.sqrt(np.log1p(np.where(self.share > 0.0, self.error / self.share, 0.0) ** 2)))
        return ConfidenceInterval(self.share / spread, self.share * spread)


@dataclass(frozen=True, eq=False, repr=False)
class PolynomialChaos:
    """A polynomial of the inputs that stands for a function; made by `polynomial_chaos`.

    It is called as the function is, with the samples first, and so can itself be propagated.

    Attributes
    ----------
    inputs
        Names of the inputs.
    powers
        Degree of each term in each of the k inputs, (terms, k).
    coefficients
        Of the orthonormal terms, (terms, ...).
    n
        Number of samples, or of nodes and those random points, at which the function was called.
    """

    inputs: tuple[str, ...]
    powers: Powers
    coefficients: Array
    n: int
    _germ: Germ = field(repr=False)
    _covariance: Array | None = field(repr=False)
    _residual: Array = field(repr=False)
    _left: LeftOver = field(repr=False)

    def __call__(self, **inputs: Array) -> Array:
        """Values of the polynomial, (m, ...)."""
        terms = self._germ.terms(self.powers, {name: np.asarray(inputs[name], np.float64) for name in self.inputs})
        return np.asarray(np.tensordot(terms, self.coefficients, axes=1))

    @property
    def mean(self) -> Array:
        """Mean of the result, the coefficient of the constant polynomial, (...)."""
        return np.asarray(self.coefficients[0])

    @property
    def variance(self) -> Array:
        """Variance of the result, the sum of the squares of the other coefficients, (...)."""
        return np.asarray(np.sum(self.coefficients[1:] ** 2, axis=0))

    @property
    def unexplained(self) -> Array:
        """Share of the variance that the polynomial leaves, at points that it was not fitted to, (...).

        By leaving out one sample after the other, or of a quadrature at random points. What the function does in tails
        that none of them reached is not in it.
        """
        return self._left.share

    @property
    def std(self) -> Array:
        """Standard deviation, (...)."""
        return np.asarray(np.sqrt(self.variance))

    @cached_property
    def sobol(self) -> SobolIndices:
        """First-order and total Sobol indices, sums of squares of coefficients (Sudret, 2008)."""
        self._germ.joint.require_independent("Sobol indices")
        uses = self.powers > 0
        alone = uses & (np.count_nonzero(uses, axis=1) == 1)[:, None]
        parts = [self._share(which) for which in (alone, uses)]
        return SobolIndices(self.inputs, parts[0][0], parts[1][0], parts[0][1], parts[1][1])

    def _share(self, which: NDArray[np.bool_]) -> tuple[Array, Array]:
        """Shares of the variance by groups of terms, mask (terms, k), and their standard errors, (..., k)."""
        square = self.coefficients**2
        # no input has a share in a constant
        variance = np.where(self.variance == 0.0, 1.0, self.variance)
        share = np.moveaxis(np.tensordot(which.T, square, axes=1) / variance, 0, -1)
        slopes = []
        for k in range(which.shape[1]):
            inside = which[:, k].reshape(len(which), *(1,) * (square.ndim - 1)) - share[..., k]
            slope = 2.0 * self.coefficients * inside / variance
            slope[0] = 0.0
            slopes.append(self._error(slope))
        return share, np.stack(slopes, axis=-1)

    def _error(self, slope: Array) -> Array:
        """Standard error of a statistic with the gradient (terms, ...) by the coefficients; NaN for a quadrature."""
        if self._covariance is None:
            return np.full(self.mean.shape, np.nan)
        spread = np.einsum("i...,ij,j...->...", slope, self._covariance, slope)
        return np.asarray(np.sqrt(np.maximum(spread, 0.0) * self._residual))

    def confidence_interval(self, level: float = 0.95, of: str = "mean") -> ConfidenceInterval:
        """Confidence interval by the residuals of the regression; what no polynomial of the degree can say is in it.

        Parameters
        ----------
        level
            Probability that the interval holds the value for the polynomial that fits best.
        of
            ``"mean"`` or ``"std"``; ``"unexplained"``, by the scatter of the squared errors at the points left out.

        Returns
        -------
        ConfidenceInterval
            Bounds, (...).

        Raises
        ------
        FrameError
            If `level` or `of` cannot be meant, or the coefficients are from a quadrature, which draws nothing.
        """
        if of == "unexplained":
            return self._left.interval(level)
        if of not in ("mean", "std"):
            raise FrameError(f"confidence interval of {of!r}: choose 'mean', 'std' or 'unexplained'")
        if self._covariance is None:
            raise FrameError("a quadrature draws no samples and has no confidence interval: see `unexplained`")
        freedom = self.n - len(self.powers)
        if of == "mean":
            slope = np.zeros_like(self.coefficients)
            slope[0] = 1.0
            return by_error(self.mean, self._error(slope), level, freedom)
        slope = self.coefficients / np.where(self.std == 0.0, 1.0, self.std)
        slope[0] = 0.0
        return by_error(self.std, self._error(slope), level, freedom, least=0.0)

    def __repr__(self) -> str:
        share, where = self.unexplained, ""
        if share.size > 1:
            worst_at = np.unravel_index(np.argmax(np.nan_to_num(share, nan=np.inf)), share.shape)
            where = f" of entry {[int(k) for k in worst_at]}, the worst,"
        worst = float(np.max(share, initial=0.0))
        return (
            f"PolynomialChaos of {', '.join(self.inputs)}: {len(self.powers)} terms up to degree "
            f"{self.powers.sum(axis=1).max()}, {self.n} calls, left {100.0 * worst:.3g} % of the variance{where} at "
            f"{self._left.points}"
        )


def polynomial_chaos(
    fn: Function,
    distributions: Mapping[str, Uncertain],
    *,
    degree: int = 3,
    method: str = "regression",
    n: int | None = None,
    rng: Seed = None,
    sampler: Sampler = "sobol",
    axis: int = 0,
    correlation: GaussianCopula | Pairs | ArrayLike | None = None,
) -> PolynomialChaos:
    """Fit a polynomial of the inputs to a smooth function, of terms that are orthonormal under their distributions.

    Parameters
    ----------
    fn
        Function of arrays, as for `propagate`.
    distributions
        By the name of the argument, as for `propagate`.
    degree
        Greatest total degree of a term, at most 20.
    method
        ``"regression"`` on samples, by polynomials of the inputs or, where that leaves less than half as much
        unexplained, of the normal scores of those that are neither bounded nor normal; or ``"quadrature"`` by the
        product of Gauss rules with degree + 1 nodes an input, for few of them; it is checked at 256 random points.
    n
        Number of samples of the regression; three a coefficient where it is left out.
    rng, sampler
        Of the regression, as for `propagate`. The points by which a quadrature is checked are Sobol's; without a seed
        they are always the same.
    axis
        Axis of the samples in what `fn` returns.
    correlation
        As for `propagate`. The polynomial is then one of independent normal scores.

    Returns
    -------
    PolynomialChaos
        With mean, standard deviation and Sobol indices in closed form, to be called in place of `fn`.

    Raises
    ------
    FrameError
        If an input or option cannot be meant, one of correlated inputs takes separate values only, there are more nodes
        than a million, or samples are too few.

    Warns
    -----
    SampleWarning
        If some samples are NaN or infinite; they are left out.

    Examples
    --------
    >>> from scipy import stats
    >>> chaos = polynomial_chaos(lambda a, b: a * b, {"a": stats.norm(2.0, 1.0), "b": stats.uniform(0.0, 1.0)},
    ...                          degree=2, method="quadrature")
    >>> bool(abs(chaos.mean - 1.0) < 1e-12), bool(abs(chaos.variance - (4 / 12 + 1 / 4 + 1 / 12)) < 1e-12)
    (True, True)
    """
    if not distributions:
        raise FrameError("polynomial_chaos was given no input: name an argument of the function and its distribution")
    if whole_number(degree, "degree", 1) > MOST:
        raise FrameError(f"degree is {degree}: give at most {MOST}")
    if method not in METHODS:
        raise FrameError(f"method is {method!r}: choose one of {', '.join(METHODS)}")
    joint = JointInputs.of(distributions, correlation)
    germ = Germ.of(joint, degree)
    powers = _powers(len(joint.names), degree)
    if method == "quadrature":
        return _by_quadrature(fn, germ, powers, axis, root_seed(0 if rng is None else rng))
    count = max(OVERSAMPLED * len(powers), 32) if n is None else whole_number(n, "number of samples n", 2)
    if count <= len(powers):
        raise FrameError(f"{count} samples for {len(powers)} coefficients: give more than that, or a lower degree")
    return _by_regression(fn, germ, powers, axis, _drawn(joint, count, root_seed(rng), sampler))


def _drawn(joint: JointInputs, count: int, root: np.random.SeedSequence, sampler: Sampler) -> dict[str, Array]:
    """Samples of the inputs, (count,) each."""
    points = points_of(joint.names, count, root, sampler)
    blocks = [joint.samples(points.take(start, min(BLOCK, count - start))) for start in range(0, count, BLOCK)]
    return {name: np.concatenate([block[name] for block in blocks]) for name in joint.names}


def _powers(k: int, degree: int) -> Powers:
    """Degrees of the terms in each input, up to a total degree, the constant first."""
    if comb(k + degree, degree) > 20_000:
        raise FrameError(f"{comb(k + degree, degree)} coefficients for {k} inputs: give a lower degree than {degree}")

    def each(inputs: int, left: int) -> Iterator[tuple[int, ...]]:
        if inputs == 0:
            yield ()
            return
        for power in range(left + 1):
            yield from ((power, *rest) for rest in each(inputs - 1, left - power))

    found = np.array(list(each(k, degree)), dtype=np.int64)
    return found[np.lexsort((*found.T, found.sum(axis=1)))]


def _by_quadrature(
    fn: Function, germ: Germ, powers: Powers, axis: int, root: np.random.SeedSequence
) -> PolynomialChaos:
    joint = germ.joint
    rules = [basis.gauss() for basis in germ.bases]
    count = len(rules[0][0]) ** len(rules)
    if count > MOST_NODES:
        raise FrameError(f"the quadrature has {count} nodes: give a lower degree, or the method 'regression'")
    nodes = np.array(list(product(*(rule[0] for rule in rules))))
    weights = np.array([np.prod(each) for each in product(*(rule[1] for rule in rules))])
    inputs = dict(zip(joint.names, nodes.T, strict=True)) if joint.scores is None else joint.at_scores(nodes)
    others = _drawn(joint, CHECKED, root, "sobol")
    together = {name: np.concatenate([inputs[name], others[name]]) for name in joint.names}
    results = samples_first(fn(**together), count + CHECKED, axis)
    flat = results.reshape(len(results), -1)
    flat = np.where(np.isfinite(flat), flat, np.nan)
    found = _of_varying((germ.terms_at(powers, list(nodes.T)) * weights[:, None]).T @ flat[:count], flat)
    expected = germ.terms(powers, others) @ found
    shape = results.shape[1:]
    left = LeftOver.of(flat[count:] - expected, flat[count:], shape, f"{CHECKED} random points")
    nothing = np.zeros(shape)
    return PolynomialChaos(
        joint.names, powers, found.reshape(len(powers), *shape), len(results), germ, None, nothing, left
    )


def _by_regression(fn: Function, germ: Germ, powers: Powers, axis: int, inputs: Mapping[str, Array]) -> PolynomialChaos:
    n = len(next(iter(inputs.values())))
    results = samples_first(fn(**inputs), n, axis)
    flat, kept = _without_failures(results.reshape(n, -1), len(powers))
    there = {name: values[kept] for name, values in inputs.items()}
    found, shape = _fitted(germ, powers, there, flat, results.shape[1:]), results.shape[1:]
    scored = germ.of_scores()
    if scored is not None:
        other = _fitted(scored, powers, there, flat, shape)
        # what rounding leaves has no meaning
        if float(np.sum(other.unexplained)) + 1e-24 < PREFERRED * float(np.sum(found.unexplained)):
            return other
    return found


def _fitted(
    germ: Germ, powers: Powers, inputs: Mapping[str, Array], flat: Array, shape: tuple[int, ...]
) -> PolynomialChaos:
    """Coefficients by least squares from results (m, e)."""
    terms = germ.terms(powers, inputs)
    q, r = np.linalg.qr(terms)
    if np.linalg.cond(r) > 1e8:
        raise FrameError(f"{len(flat)} samples do not determine {len(powers)} coefficients: give more")
    found = _of_varying(np.linalg.solve(r, q.T @ flat), flat)
    residual = flat - terms @ found
    without = residual / (1.0 - np.sum(q**2, axis=1))[:, None]
    inverse = np.linalg.inv(r)
    freedom = len(flat) - len(powers)
    return PolynomialChaos(
        germ.joint.names,
        powers,
        found.reshape(len(powers), *shape),
        len(flat),
        germ,
        inverse @ inverse.T,
        (np.sum(residual**2, axis=0) / freedom).reshape(shape),
        LeftOver.of(without, flat, shape, "samples, left out of the fit one after the other"),
    )


def _constant(results: Array) -> NDArray[np.bool_]:
    """Whether each entry of results (m, e) is constant within rounding, (e,)."""
    return constant(results.min(axis=0), results.max(axis=0))


def _of_varying(coefficients: Array, results: Array) -> Array:
    """Coefficients (terms, e) from results (m, e); entries that are constant have the constant term alone."""
    steady = _constant(results)
    coefficients[:, steady] = 0.0
    coefficients[0, steady] = results[0, steady]
    return coefficients


def _without_failures(flat: Array, terms: int) -> tuple[Array, NDArray[np.bool_]]:
    """The samples that have a result in every entry where any has one, and their indices."""
    lost = ~np.isfinite(flat)
    kept = np.asarray(~(lost & ~lost.all(axis=0)).any(axis=1))
    count = int(np.count_nonzero(~kept))
    flat = np.where(lost, np.nan, flat)
    if len(flat) - count <= terms:
        raise FrameError(
            f"{count} of {len(flat)} samples are NaN or infinite: too few are left for {terms} coefficients"
        )
    if count:
        warnings.warn(
            f"{count} of {len(flat)} samples are NaN or infinite and left out of the regression",
            SampleWarning,
            stacklevel=4,
        )
    return flat[kept], kept
