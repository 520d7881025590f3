"""What propagation tells of a result: its statistics, each with its error, and the samples that failed."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite, one_entry
from ...framework.errors import FrameError
from ...framework.graphics.style import new_axes, styled
from ..convergence import draw_convergence
from ..distributions import Uncertain
from ..histograms import plot_histogram
from ..intervals import (
    ConfidenceInterval,
    by_error,
    checked_probability,
    interval_between,
    quantile_interval,
    quantile_ranks,
)
from ..moments import Moments, Statistics
from ..sampling import BLOCK
from ..sensitivity import SobolIndices
from ..spread import quantiles
from .chunk import ChunkTask
from .comoments import Comoments
from .correlation import GaussianCopula, Pairs
from .failures import MOST_NAMED, Failures
from .histogram import BinnedSamples, Bins, Histogram
from .inputs import JointInputs
from .reweighting import Reweighted, reweighted

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

BinnedQuantiles = Callable[[BinnedSamples, Array], tuple[Array, ...]]

# Entries of a result that its table shows.
MOST_SHOWN = 6
FIGURES = ("histogram", "convergence")


@dataclass(frozen=True, eq=False, repr=False)
class Propagation(Statistics):
    """Statistics of a result under uncertain inputs; made by `propagate`.

    Standard errors are those of independent random samples; sequences and Latin samples do better than they say, unless
    there are several `replicates` of them, between which the errors then are.
    Samples that are NaN do not count, or make the statistics NaN, as `nan_policy` has it; `failures` tells how many
    there are, which, and why.

    Attributes
    ----------
    inputs
        Names of the inputs.
    n
        Number of samples, those that are NaN included.
    nan_policy
        What was done with samples that are NaN.
    failures
        The samples that are NaN where others are not.
    kept
        Samples of the result, (n, ...), or None where they were not kept.
    """

    inputs: tuple[str, ...]
    n: int
    nan_policy: str
    failures: Failures
    kept: Array | None
    _missing: NDArray[np.int64] = field(repr=False)
    _moments: Moments = field(repr=False)
    _envelope: tuple[Array, Array] = field(repr=False)
    _comoments: Comoments | None = field(repr=False)
    _binned: BinnedSamples | None = field(repr=False)
    _task: ChunkTask = field(repr=False)
    _indices: Callable[..., SobolIndices] = field(repr=False)
    _replicated: Moments | None = field(default=None, repr=False)

    @property
    def moments(self) -> Moments:
        """Count, mean and sums of powers of the deviations, (...)."""
        return self._moments

    @property
    def replicates(self) -> int:
        """Number of independent randomisations of the sampler."""
        return self._task.replicates

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean, (...); between the replicates where there are several."""
        return super().standard_error if self._replicated is None else self._between(self._replicated.mean)

    @property
    def std_standard_error(self) -> Array:
        """Standard error of the standard deviation, (...); between the replicates where there are several."""
        if self._replicated is None:
            return super().std_standard_error
        with np.errstate(divide="ignore", invalid="ignore"):
            error = self._between(self._replicated.std**2) / (2.0 * self.std)
        return np.where(self.std == 0.0, 0.0, error)

    def _between(self, values: Array) -> Array:
        """Standard error of a mean of values (r, ...) of independent replicates, (...)."""
        return np.asarray(np.std(values, axis=0, ddof=1) / np.sqrt(len(values)))

    def require_independent_inputs(self, what: str) -> None:
        """Refuse what has no meaning where inputs depend on each other.

        Parameters
        ----------
        what
            What was asked for, in words.
        """
        self._task.inputs.require_independent(what)

    @property
    def missing(self) -> NDArray[np.int64]:
        """Number of samples that are NaN, (...)."""
        return self._missing

    @property
    def failed(self) -> tuple[int, ...]:
        """Numbers of the first samples that are NaN where others are not."""
        return tuple(int(number) for number in self.failures.numbers[:MOST_NAMED])

    @property
    def envelope(self) -> tuple[Array, Array]:
        """Least and greatest sample, (...) each."""
        return self._envelope

    @property
    def samples(self) -> Array:
        """Samples of the result, sample axis first, (n, ...)."""
        if self.kept is None:
            raise FrameError("the samples were not kept: call propagate with keep_samples=True")
        return self.kept

    @cached_property
    def input_samples(self) -> dict[str, Array]:
        """Samples of the inputs by name, (n,) each, drawn again from the seed."""
        return self._task.drawn(0, self.n)

    # -- quantiles and histogram ------------------------------------------------------------------------------------

    def quantile(self, p: ArrayLike) -> Array:
        """Quantile of the result at one or more probabilities.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Quantiles, (k..., ...), interpolated linearly between samples, or within the bins of the histogram where the
            samples were not kept; `quantile_bounds` tells how much that can be off.

        Raises
        ------
        FrameError
            If neither samples nor histogram were kept, or a probability is not in [0, 1].
        """
        if self.kept is not None:
            return quantiles(self.kept, p, axis=0, nan_policy=self.nan_policy)
        return self._each_quantile(p, lambda binned, rank: (binned.at_rank(rank),))[0]

    def quantile_bounds(self, p: ArrayLike) -> tuple[Array, Array]:
        """Lower and upper bound on the quantile of the samples that were drawn, by the bins where they were not kept.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        tuple
            Lower and upper bound, (k..., ...) each; the same where the samples were kept. What sampling leaves
            uncertain comes on top: see `confidence_interval`.
        """
        if self.kept is not None:
            exact = self.quantile(p)
            return exact, exact
        low, high = self._each_quantile(p, lambda binned, rank: binned.bounds(rank, rank))
        return low, high

    def _each_quantile(
        self, p: ArrayLike, of: Callable[[BinnedSamples, Array], tuple[Array, ...]]
    ) -> tuple[Array, ...]:
        asked = finite(p, "probability p of a quantile")
        binned, shape = self._bins(), np.shape(self.mean)
        found = []
        for each in asked.ravel():
            rank = checked_probability(float(each)) * np.maximum(binned.n - 1, 0)
            below = np.floor(rank)
            pair = zip(of(binned, below), of(binned, np.ceil(rank)), strict=True)
            # Between two samples as NumPy does it.
            found.append([low + (rank - below) * (high - low) for low, high in pair])
        there = self._there()
        return tuple(
            np.where(there, np.reshape(np.array(each), (*asked.shape, *shape)), np.nan)
            for each in zip(*found, strict=True)
        )

    def _there(self) -> NDArray[np.bool_]:
        """Where the policy leaves statistics, (...)."""
        return np.asarray(self.missing < self.n if self.nan_policy == "omit" else self.missing == 0)

    def _bins(self) -> BinnedSamples:
        if self._binned is None:
            raise FrameError(
                "the samples were not kept: call propagate with keep_samples=True, or with also=('histogram',), which "
                "takes memory that does not grow with n"
            )
        return self._binned

    def histogram(self) -> Histogram:
        """Histogram of the samples, in bins that the first 1024 of them lay out.

        Returns
        -------
        Histogram
            Edges and counts for each entry of the result.
        """
        shape = np.shape(self.mean)
        if self._binned is not None or self.kept is None:
            return self._bins().histogram(shape)
        flat = self.kept.reshape(self.n, -1)
        bins = Bins.of(flat[:BLOCK])
        low, high = (np.ravel(each) for each in self.envelope)
        return BinnedSamples(bins, bins.count(flat), low, high).histogram(shape)

    # -- covariance -------------------------------------------------------------------------------------------------

    @property
    def covariance(self) -> Array:
        """Covariance of the components along the last axis of the result, (..., c, c); of a single number, ()."""
        return self._squeezed(self._products.covariance)

    @property
    def correlation(self) -> Array:
        """Correlation of the components along the last axis of the result, (..., c, c); of a single number, ()."""
        found = self._products.covariance
        deviation = np.sqrt(np.diagonal(found, axis1=-2, axis2=-1))
        with np.errstate(invalid="ignore", divide="ignore"):
            return self._squeezed(found / (deviation[..., :, None] * deviation[..., None, :]))

    @cached_property
    def _products(self) -> Comoments:
        if self._comoments is not None:
            return self._comoments
        if self.kept is None:
            raise FrameError(
                "the samples were not kept: call propagate with keep_samples=True, or with also=('covariance',), which "
                "takes memory that does not grow with n"
            )
        out: Comoments | None = None
        for block in self._blocks(self.kept):
            part = Comoments.of(np.atleast_2d(block.T).T, self.nan_policy)
            out = part if out is None else out.merge(part)
        assert out is not None
        return out

    @staticmethod
    def _blocks(samples: Array) -> Iterator[Array]:
        return (samples[start : start + BLOCK] for start in range(0, len(samples), BLOCK))

    def _squeezed(self, found: Array) -> Array:
        return found if np.ndim(self.mean) else found[0, 0]

    # -- to look at -------------------------------------------------------------------------------------------------

    @styled
    def plot(
        self,
        what: str = "histogram",
        ax: Axes | None = None,
        *,
        entry: int | tuple[int, ...] | None = None,
        of: str | float = "mean",
        label: str = "result",
        unit: str = "",
    ) -> Axes:
        """Draw the samples of one entry of the result as a histogram, or how an estimate settles with their number.

        Parameters
        ----------
        what
            ``histogram``, see `plot_histogram`; or ``convergence``: the estimate from the first samples, ever more of
            them, with a band of one standard error, that of independent random samples.
        ax
            Axes of matplotlib to draw on; new ones where None.
        entry
            Indices of the entry; not needed where the result has one.
        of
            What is estimated: ``"mean"``, ``"std"``, or the probability of a quantile.
        label, unit
            What the result is, and its unit.

        Returns
        -------
        matplotlib.axes.Axes
            What was drawn on.

        Raises
        ------
        FrameError
            If there is nothing of that name, no such entry, or the samples were not kept.

        Examples
        --------
        >>> import matplotlib; matplotlib.use("Agg")
        >>> from scipy import stats
        >>> from linkframe.models import propagate
        >>> result = propagate(lambda x: x**2, {"x": stats.norm(3.0, 0.1)}, n=1024, rng=0)
        >>> result.plot("convergence", label="area", unit="m²").get_ylabel()
        'mean of area [m²]'
        """
        if what not in FIGURES:
            raise FrameError(f"plot was given what={what!r}: choose one of {', '.join(FIGURES)}")
        shape = np.shape(self.mean)
        at = (0,) * len(shape) if entry is None and np.size(self.mean) == 1 else entry
        if at is None:
            raise FrameError(f"the result has shape {shape}: choose an entry of it to plot, entry=...")
        chosen: tuple[Any, ...] = (slice(None), *one_entry(shape, at, "the figure of the result"))
        drawn = self.samples[chosen]
        there = drawn[np.isfinite(drawn)]
        if what == "histogram":
            return plot_histogram(there, ax, label=label, unit=unit)
        remarks = [f"{len(drawn) - len(there)} samples failed and are left out"] if len(there) < len(drawn) else []
        if self._task.sampler != "random":
            remarks.append("standard error of random samples; those of a sequence do better")
        found = new_axes(4.8, 3.4) if ax is None else ax
        draw_convergence(found, there, of, label, unit, "; ".join(remarks))
        return found

    # -- how sure ---------------------------------------------------------------------------------------------------

    def confidence_interval(self, level: float = 0.95, of: str | float = "mean") -> ConfidenceInterval:
        """Confidence interval of a number: between the replicates, or as of independent samples where there is one.

        Parameters
        ----------
        level
            Probability that the interval holds the true value.
        of
            ``"mean"``, by Student's distribution; ``"std"``, by its standard error; ``"covariance"``, by its scatter
            from part to part of the samples; or the probability of a quantile, by the ordered samples, whatever the
            distribution. Between replicates all but the covariance, and quantiles where samples were not kept, are by
            Student's distribution.

        Returns
        -------
        ConfidenceInterval
            Bounds, (...), of the covariance (..., c, c); infinite where the samples are too few for one.

        Raises
        ------
        FrameError
            If `level` or `of` cannot be meant, or asks for what was not kept.

        Examples
        --------
        >>> from scipy import stats
        >>> from linkframe.models import propagate
        >>> result = propagate(lambda x: x, {"x": stats.norm(3.0, 1.0)}, n=10_000, rng=0)
        >>> low, high = result.confidence_interval(0.999, of=0.9)
        >>> bool(low < 3.0 + 1.2816 < high)
        True
        """
        if of == "covariance":
            products = self._products
            found = by_error(products.covariance, products.standard_error, level, products.freedom)
            return ConfidenceInterval(self._squeezed(found.low), self._squeezed(found.high))
        freedom = self.replicates - 1
        if freedom and of == "mean":
            return by_error(self.mean, self.standard_error, level, freedom)
        if freedom and of == "std":
            return by_error(self.std, self.std_standard_error, level, freedom, least=0.0)
        return super().confidence_interval(level, of)

    def _quantile_interval(self, p: float, level: float) -> ConfidenceInterval:
        if self.kept is not None and self.replicates > 1:
            below = np.where(np.isnan(self.kept), np.nan, self.kept <= self.quantile(checked_probability(p)))
            each = np.stack(
                [Moments.of(below[k :: self.replicates], self.nan_policy).mean for k in range(self.replicates)]
            )
            share = by_error(p, self._between(each), level, self.replicates - 1)
            return interval_between(self.kept, share.low, share.high, self.nan_policy)
        if self.kept is not None:
            return quantile_interval(self.kept, p, level, self.nan_policy)
        binned, shape, there = self._bins(), np.shape(self.mean), self._there()
        n = binned.n
        low, high = quantile_ranks(n, checked_probability(p), level)
        last = np.maximum(n - 1, 0)
        below, above = binned.bounds(np.clip(low, 0, last), np.clip(high, 0, last))
        return ConfidenceInterval(
            np.where(there, np.where(low < 0, -np.inf, below).reshape(shape), np.nan),
            np.where(there, np.where(high >= n, np.inf, above).reshape(shape), np.nan),
        )

    # -- what else --------------------------------------------------------------------------------------------------

    @cached_property
    def sobol(self) -> SobolIndices:
        """First-order and total Sobol indices, from n (k + 2) further calls for k inputs; see `sobol_indices`.

        They are NaN where one of those calls is, whatever the `nan_policy`.
        """
        self._task.inputs.require_independent("Sobol indices")
        return self._indices(n=self.replicates * 2 ** int(np.log2(self.n / self.replicates)))

    def reweighted(
        self,
        distributions: Mapping[str, Uncertain],
        correlation: GaussianCopula | Pairs | ArrayLike | None = None,
    ) -> Reweighted:
        """Take other distributions of the same inputs, with the same results: nothing is solved again.

        Parameters
        ----------
        distributions
            The new ones by name; inputs that are not named keep theirs. Each needs a density, and no room where the
            old one has none.
        correlation
            That of the inputs from now on, as for `propagate`; left out, they are independent.

        Returns
        -------
        Reweighted
            Statistics with weights, and how many independent samples they are worth.

        Raises
        ------
        FrameError
            If samples were not kept, a name is no input, or a distribution has no density or reaches too far.

        Examples
        --------
        >>> from scipy import stats
        >>> from linkframe.models import propagate
        >>> result = propagate(lambda x: x**2, {"x": stats.norm(0.0, 1.0)}, n=4096, rng=0, sampler="sobol")
        >>> narrower = result.reweighted({"x": stats.norm(0.0, 0.8)})
        >>> bool(abs(narrower.mean - 0.64) < 0.01), bool(narrower.effective_sample_size > 3000)
        (True, True)
        """
        before = self._task.inputs
        for name in distributions:
            if name not in before.laws:
                raise FrameError(f"{name!r} is no input of this result: choose of {', '.join(self.inputs)}")
        after = JointInputs.of({**before.laws, **distributions}, correlation)
        return reweighted(self.samples, self.input_samples, before, after, self.nan_policy)

    def __repr__(self) -> str:
        kind = self._task.sampler if isinstance(self._task.sampler, str) else type(self._task.sampler).__name__
        several = f", {self.replicates} replicates" if self.replicates > 1 else ""
        lines = [f"Propagation of {', '.join(self.inputs)}: {self.n} samples ({kind}{several})"]
        heading = ("", "mean", "± s.e.", "std", "± s.e.", "least", "greatest")
        lines.append("".join(f"{each:>12}" for each in heading))
        shape = np.shape(self.mean)
        columns = (self.mean, self.standard_error, self.std, self.std_standard_error, *self.envelope)
        for index in list(np.ndindex(shape))[:MOST_SHOWN]:
            cells = [f"{np.asarray(column)[index]:>12.5g}" for column in columns]
            lines.append("".join([f"{str(list(index)) if shape else '':>12}", *cells]))
        if np.size(self.mean) > MOST_SHOWN:
            lines.append(f"{'...':>12}  {np.size(self.mean) - MOST_SHOWN} more of shape {shape}")
        if self.failures.count:
            lines.append(repr(self.failures))
        return "\n".join(lines)
