"""Sobol indices: the shares of the inputs in the variance of a result."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import one_entry
from ..framework.checked import whole_number
from ..framework.errors import FrameError, SampleWarning
from ..framework.graphics.shares import draw_shares, height_of_shares
from ..framework.graphics.style import new_axes, set_title, styled
from ..framework.listing import MOST, text_table
from .distributions import Distribution, Uncertain
from .given_distributions import distributions_of
from .intervals import ConfidenceInterval, by_error
from .sampling import LEAST, Seed, replicate_seeds, root_seed, samples_first, samples_of_each, stream

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Relative variation between samples up to which a result counts as constant.
ROUNDING = 16.0 * np.finfo(np.float64).eps
# Default number of inputs shown by name in the figure.
MOST_DRAWN = 12
# Largest number of inputs for which the table of an array result has columns.
MOST_COLUMNS = 6


@dataclass(frozen=True, eq=False, repr=False)
class SobolIndices:
    """Sobol indices, the shares of the inputs in the variance of a result; made by `sobol_indices`.

    Attributes
    ----------
    inputs
        Names of the k inputs.
    first
        First-order index: share due to each input alone, (..., k).
    total
        Total index: share due to each input with all its interactions, (..., k).
    first_standard_error, total_standard_error
        Standard errors of the indices, (..., k), estimated as for independent samples or from the replicates.
    freedom
        Degrees of freedom of the standard errors.

    Examples
    --------
    The variance of a product of two inputs with mean zero comes from both together and from neither alone.

    >>> from scipy import stats
    >>> product = sobol_indices(lambda a, b: a * b, {"a": stats.norm(), "b": stats.norm()}, n=4096, rng=0)
    >>> bool((abs(product.first) < 0.1).all() and (abs(product.total - 1.0) < 0.1).all())
    True
    """

    inputs: tuple[str, ...]
    first: Array
    total: Array
    first_standard_error: Array
    total_standard_error: Array
    freedom: float = np.inf

    def confidence_interval(self, level: float = 0.95, of: str = "total") -> ConfidenceInterval:
        """Confidence interval of the indices.

        With a single randomisation the interval is that of independent samples, usually too wide for a sequence.

        Parameters
        ----------
        level
            Confidence level, between 0 and 1.
        of
            Indices of order ``"first"`` or ``"total"``.

        Returns
        -------
        ConfidenceInterval
            Bounds, (..., k); they may lie outside 0 and 1, as the estimates may.

        Raises
        ------
        FrameError
            If `level` or `of` is invalid.
        """
        if of not in ("first", "total"):
            raise FrameError(f"confidence interval of {of!r}: choose 'first' or 'total'")
        first = of == "first"
        error = self.first_standard_error if first else self.total_standard_error
        return by_error(self.first if first else self.total, error, level, self.freedom)

    @styled
    def plot(
        self, ax: Axes | None = None, *, entry: int | tuple[int, ...] | None = None, most: int = MOST_DRAWN
    ) -> Axes:
        """Draw the total and first-order indices as bars with their standard errors, the largest at the top.

        Parameters
        ----------
        ax
            Axes of matplotlib to draw on; new ones if None.
        entry
            Position of one entry in the array of results; may be None if the result has only one.
        most
            Number of inputs shown by name; the others are added up in one bar.

        Returns
        -------
        matplotlib.axes.Axes
            The axes.

        Raises
        ------
        FrameError
            If there is no such entry, or its indices are NaN.
        """
        shape = self.total.shape[:-1]
        if entry is None and int(np.prod(shape)) != 1:
            raise FrameError(f"the result has shape {shape}: choose an entry of it to plot, entry=...")
        at = (0,) * len(shape) if entry is None else one_entry(shape, entry, "the figure of the Sobol indices")
        shares = {"total": 100.0 * self.total[at], "first order": 100.0 * self.first[at]}
        if not np.isfinite(shares["total"]).all():
            raise FrameError("the Sobol indices are NaN, as samples failed: there is nothing to plot")
        errors = {"total": self.total_standard_error, "first order": self.first_standard_error}
        found = new_axes(5.2, height_of_shares(len(self.inputs), most)) if ax is None else ax
        draw_shares(found, self.inputs, shares, most, {kind: 100.0 * each[at] for kind, each in errors.items()})
        set_title(found, "shares of the variance, with standard errors")
        return found

    def __repr__(self) -> str:
        if self.total.ndim > 1:
            return self._of_array()
        lines = [f"{'input':>16}{'first':>10}{'± s.e.':>10}{'total':>10}{'± s.e.':>10}"]
        columns = (self.first, self.first_standard_error, self.total, self.total_standard_error)
        for k in np.argsort(-self.total, kind="stable"):
            lines.append(f"{self.inputs[k]:>16}" + "".join(f"{column[k]:>10.4f}" for column in columns))
        return "\n".join(lines)

    def _of_array(self) -> str:
        """Table of the total indices for the first entries of a result that is an array."""
        shape = self.total.shape[:-1]
        title = f"Sobol indices of {', '.join(self.inputs)} for a result of shape {shape}"
        if len(self.inputs) > MOST_COLUMNS:
            return title
        more = int(np.prod(shape)) - MOST
        rows = [
            [str(list(at)), *(f"{value:.4f}" for value in self.total[at])] for at in islice(np.ndindex(shape), MOST)
        ]
        table = text_table(f"{title}, total:", ["result", *self.inputs], rows)
        return f"{table}\n  ... {more} more" if more > 0 else table


def sobol_indices(
    fn: Callable[..., ArrayLike],
    distributions: Mapping[str, Uncertain],
    *,
    n: int = 1024,
    rng: Seed = None,
    axis: int = 0,
    chunk: int = 16384,
    replicates: int = 1,
) -> SobolIndices:
    """Sobol indices of a function of independent uncertain inputs, by `scipy.stats.sobol_indices`.

    Parameters
    ----------
    fn
        Function of arrays (m,) that returns m results, as for `propagate`.
    distributions
        Distributions of the inputs by the name of the argument, as for `propagate`.
    n
        Number of samples, a power of two; `fn` is evaluated for n (k + 2) samples with k inputs.
    rng
        Seed, as for `propagate`.
    axis
        Axis of the samples in the array that `fn` returns.
    chunk
        Largest number of samples in one call of `fn`.
    replicates
        Number of independent randomisations from whose scatter the standard errors are estimated; each has
        n / replicates samples, a power of two.

    Returns
    -------
    SobolIndices
        First-order and total indices (Saltelli et al., Computer Physics Communications 181, 2010,
        doi:10.1016/j.cpc.2009.09.018); NaN where a sample is NaN or infinite, 0 where the result is constant.

    Raises
    ------
    FrameError
        If `n` is not a power of two, or the results of `fn` do not have the samples along `axis`.

    Examples
    --------
    >>> from scipy import stats
    >>> shares = sobol_indices(lambda a, b: a + 2.0 * b, {"a": stats.norm(), "b": stats.norm()}, rng=0)
    >>> bool(abs(shares.first - [0.2, 0.8]).max() < 0.02)
    True
    """
    if whole_number(replicates, "replicates", 1) > 1:
        return _replicated(fn, distributions, n, root_seed(rng), axis, chunk, replicates)
    if whole_number(n, "number of samples n", 2) & (n - 1):
        raise FrameError(f"number of samples n is {n!r}: Sobol indices need a power of two")
    if not distributions:
        raise FrameError("sobol_indices was given no input: name an argument of the function and its distribution")
    given = distributions_of(distributions)
    whole_number(chunk, "chunk", 1)
    from scipy import stats

    names = tuple(given)
    shape: list[tuple[int, ...]] = []
    lost: list[int] = []
    holes: list[NDArray[np.bool_]] = []
    ends: list[Array] = []

    def rows(points: Array) -> Array:
        """Results (s, m) at points (k, m)."""
        parts = []
        for start in range(0, points.shape[1], chunk):
            part = points[:, start : start + chunk]
            parts.append(samples_first(fn(**dict(zip(names, part, strict=False))), part.shape[1], axis))
        results = np.concatenate(parts)
        flat = results.reshape(len(results), -1)
        missing = ~np.isfinite(flat)
        lost.append(int(np.count_nonzero(missing.any(axis=1))))
        holes.append(np.asarray(missing.any(axis=0)))
        shape.append(results.shape[1:])
        there = np.where(missing, 0.0, flat)
        ends.append(np.stack([there.min(axis=0), there.max(axis=0)]))
        return np.asarray(there.T)

    marginals = [_Inside(distribution) for distribution in given.values()]
    # SciPy needs two inputs or more: a single one gets a second without effect.
    marginals += [_Inside(stats.uniform())] * (len(marginals) == 1)
    generator = stream(root_seed(rng), "sobol indices")
    errors: list[Array] = []

    def method(f_A: Array, f_B: Array, f_AB: Array) -> tuple[Array, Array]:
        first, total, *more = _saltelli(f_A, f_B, f_AB)
        errors[:] = more
        return first, total

    found = stats.sobol_indices(func=rows, n=n, dists=marginals, rng=generator, method=method)
    if any(lost):
        warnings.warn(
            f"{sum(lost)} of {n * (len(marginals) + 2)} samples are NaN or infinite somewhere; the Sobol indices are "
            "NaN there, as each needs all samples",
            SampleWarning,
            stacklevel=2,
        )
    hole, steady = np.any(holes, axis=0), constant(np.min(ends, axis=(0, 1)), np.max(ends, axis=(0, 1)))
    each = (
        np.where(steady[:, None], 0.0, order.reshape(len(hole), len(marginals)))
        for order in (found.first_order, found.total_order, *errors)
    )
    first, total, alone, together = (
        np.reshape(np.where(hole[:, None], np.nan, order), (*shape[0], len(marginals)))[..., : len(names)]
        for order in each
    )
    return SobolIndices(names, first, total, alone, together)


def constant(least: Array, greatest: Array) -> NDArray[np.bool_]:
    """Whether results between smallest and largest values, (...) each, differ only by rounding, (...)."""
    return np.asarray(greatest - least <= ROUNDING * np.maximum(np.abs(least), np.abs(greatest)))


def _replicated(
    fn: Callable[..., ArrayLike],
    distributions: Mapping[str, Uncertain],
    n: int,
    root: np.random.SeedSequence,
    axis: int,
    chunk: int,
    replicates: int,
) -> SobolIndices:
    """Means of the indices of independent randomisations, with standard errors from their scatter."""
    size = samples_of_each(whole_number(n, "number of samples n", 2), replicates)
    each = [
        sobol_indices(fn, distributions, n=size, rng=own, axis=axis, chunk=chunk)
        for own in replicate_seeds(root, replicates)
    ]
    first, total = (np.stack([getattr(found, name) for found in each]) for name in ("first", "total"))
    alone, together = (np.std(values, axis=0, ddof=1) / np.sqrt(replicates) for values in (first, total))
    means = first.mean(axis=0), total.mean(axis=0)
    return SobolIndices(each[0].inputs, *means, alone, together, replicates - 1.0)


def _saltelli(f_A: Array, f_B: Array, f_AB: Array) -> tuple[Array, Array, Array, Array]:
    """First-order and total indices (s, k) of centred results, as computed by SciPy, and their standard errors.

    Each index is a ratio of means over the samples. The error of a ratio q = mean(a) / mean(b) is that of the mean of
    ``a - q b``, divided by mean(b).

    Parameters
    ----------
    f_A, f_B
        Results at two sets of independent points, (s, n).
    f_AB
        Results at the first set with each input in turn taken from the second, (k, s, n).
    """
    variance = np.var([f_A, f_B], axis=(0, -1))
    square = 0.5 * (f_A**2 + f_B**2)
    with np.errstate(invalid="ignore", divide="ignore"):
        alone, together = f_B * (f_AB - f_A), 0.5 * (f_A - f_AB) ** 2
        first, total = np.mean(alone, axis=-1) / variance, np.mean(together, axis=-1) / variance
        scale = variance * np.sqrt(f_A.shape[-1])
        errors = [
            np.array([np.std(each - value[:, None] * square, axis=-1) / scale for each, value in pairs]).T
            for pairs in (zip(alone, first, strict=True), zip(together, total, strict=True))
        ]
    return first.T, total.T, errors[0], errors[1]


class _Inside:
    """A distribution whose quantiles stay finite at probability zero."""

    def __init__(self, distribution: Distribution) -> None:
        self.distribution = distribution

    def ppf(self, q: Array) -> Any:
        return self.distribution.ppf(np.maximum(q, LEAST))
