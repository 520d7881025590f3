"""The result of propagation: statistics of a function's result, each with its error, and the samples that failed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ...framework.batch import one_entry
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
from ..moments import Moments
from ..sensitivity import SobolIndices
from .correlation import GaussianCopula, Pairs
from .inputs import JointInputs
from .reweighting import Reweighted, reweighted
from .sampled_result import SampledResult

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Number of entries of a result that its table shows.
MOST_SHOWN = 6
FIGURES = ("histogram", "convergence")


@dataclass(frozen=True, eq=False, repr=False)
class Propagation(SampledResult):
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
            if name not in before.distributions:
                raise FrameError(f"{name!r} is no input of this result: choose of {', '.join(self.inputs)}")
        after = JointInputs.of({**before.distributions, **distributions}, correlation)
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
        if self.failures.count or self.failures.empty:
            lines.append(repr(self.failures))
        return "\n".join(lines)
