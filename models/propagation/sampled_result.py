"""Statistics of the samples of a result, each with its standard error: moments, quantiles, histogram, correlations."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ...framework.batch import finite
from ...framework.errors import FrameError
from ..intervals import (
    checked_probability,
)
from ..moments import Moments, Statistics
from ..sampling import BLOCK
from ..sensitivity import SobolIndices
from ..spread import between, quantiles
from .chunk import ChunkTask
from .comoments import Comoments
from .failures import MOST_NAMED, Failures
from .histogram import BinnedSamples, Bins, Histogram

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False, repr=False)
class SampledResult(Statistics):
    """A result under uncertain inputs by its samples; `Propagation` tells of the attributes."""

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
        """Standard error of the mean, (...); from the scatter of the replicates if there are several."""
        return super().standard_error if self._replicated is None else self._between(self._replicated.mean)

    @property
    def std_standard_error(self) -> Array:
        """Standard error of the standard deviation, (...); from the scatter of the replicates if there are several."""
        if self._replicated is None:
            return super().std_standard_error
        with np.errstate(divide="ignore", invalid="ignore"):
            error = self._between(self._replicated.std**2) / (2.0 * self.std)
        return np.where(self.std == 0.0, 0.0, error)

    def _between(self, values: Array) -> Array:
        """Standard error of a mean of values (r, ...) of independent replicates, (...)."""
        with np.errstate(invalid="ignore"):  # of infinite ones there is none
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
        """Numbers of the first failed samples: NaN in an entry where others are not."""
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
            # interpolated between two samples as NumPy does
            found.append([between(low, high, rank - below) for low, high in pair])
        there = self._there()
        return tuple(
            np.where(there, np.reshape(np.array(each), (*asked.shape, *shape)), np.nan)
            for each in zip(*found, strict=True)
        )

    def _there(self) -> NDArray[np.bool_]:
        """Whether an entry has statistics under the NaN policy, (...)."""
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
