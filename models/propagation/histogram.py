"""Counts of a stream of samples in bins laid out by its first block, and bounds on quantiles from them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Counts = NDArray[np.int64]

BINS = 4096
# Bins are equal in t, with x = center + scale sinh t for t in (-FAR, FAR): near the middle 0.007 standard deviations
# wide, at 5 of them 0.035, and out to half a million.
FAR = 14.0
_EDGES = np.linspace(-FAR, FAR, BINS + 1)
# Distance of the quartiles of a normal distribution, in standard deviations.
QUARTILES = 1.3489795003921634


@dataclass(frozen=True, eq=False)
class Bins:
    """Position of the bins, for each of the e entries of a result.

    Parameters
    ----------
    center, scale
        Centre, and scale of the widths, (e,).
    """

    center: Array
    scale: Array

    @classmethod
    def of(cls, block: Array) -> Bins:
        """Bins for samples like those of a block, (m, e)."""
        if not block.shape[1]:  # NumPy takes no quantiles of an empty result
            return cls(np.zeros(0), np.zeros(0))
        there = np.isfinite(block)
        filled = np.where(there, block, np.nan)
        some = there.any(axis=0)
        filled[:, ~some] = 0.0
        low, center, high = np.nanquantile(filled, [0.25, 0.5, 0.75], axis=0)
        scale = (high - low) / QUARTILES
        scale = np.where(scale > 0.0, scale, np.nanstd(filled, axis=0))
        least = 2.0**-40 * np.abs(center)
        scale = np.maximum(scale, np.where(least > 0.0, least, np.where(scale > 0.0, 0.0, 1.0)))
        return cls(center, scale)

    def count(self, samples: Array) -> Counts:
        """Number of samples (m, e) in each bin, (e, BINS); NaN is in none."""
        with np.errstate(invalid="ignore", over="ignore"):
            at = np.arcsinh((samples - self.center) / self.scale)
            at = np.clip((at + FAR) * (BINS / (2.0 * FAR)), 0.0, BINS - 0.5)
        entries = samples.shape[1]
        lost = np.isnan(at)
        number = np.where(lost, 0.0, at).astype(np.int64) + BINS * np.arange(entries)
        found = np.bincount(number[~lost], minlength=entries * BINS)
        return found.reshape(entries, BINS).astype(np.int64)

    def place(self, t: Array) -> Array:
        """Value at a bin coordinate t, (..., e)."""
        return np.asarray(self.center + self.scale * np.sinh(t))


@dataclass(frozen=True, eq=False)
class Histogram:
    """Counts of the samples of a result.

    Attributes
    ----------
    edges
        Edges of the bins, (..., bins + 1). They are laid out by the first 1024 samples and finest in the middle.
    counts
        Number of samples in each bin, (..., bins); the outermost bins include all beyond them.
    """

    edges: Array
    counts: Counts

    @property
    def density(self) -> Array:
        """Estimated probability density, (..., bins), in the inverse unit of the result."""
        total = self.counts.sum(axis=-1, keepdims=True)
        return np.asarray(self.counts / (np.maximum(total, 1) * np.diff(self.edges, axis=-1)))


@dataclass(frozen=True, eq=False)
class BinnedSamples:
    """Samples known by their counts in bins and their extremes only.

    Parameters
    ----------
    bins
        The bins.
    counts
        Number of samples in each bin, (e, BINS).
    least, greatest
        Extremes of the samples, (e,).
    """

    bins: Bins
    counts: Counts
    least: Array
    greatest: Array

    def histogram(self, shape: tuple[int, ...]) -> Histogram:
        """The counts in the shape of the result."""
        edges = self.bins.place(_EDGES[:, None]).T
        return Histogram(edges.reshape(*shape, BINS + 1), self.counts.reshape(*shape, BINS))

    @property
    def n(self) -> Counts:
        """Number of samples, (e,)."""
        return np.asarray(self.counts.sum(axis=-1))

    def at_rank(self, rank: Array) -> Array:
        """Value of the sample of a rank from 0 on, (e,), interpolated within its bin."""
        number, before, inside = self._bin(rank)
        share = np.clip((rank + 0.5 - before) / np.maximum(inside, 1), 0.0, 1.0)
        value = self.bins.place(_EDGES[number] + share * (_EDGES[1] - _EDGES[0]))
        # the outermost bins reach to the extremes, which may be infinite
        value = np.where((number == 0) & np.isinf(self.least), self.least, value)
        value = np.where((number == BINS - 1) & np.isinf(self.greatest), self.greatest, value)
        return self._within(value)

    def bounds(self, low: Array, high: Array) -> tuple[Array, Array]:
        """Bounds on the samples of two ranks, (e,) each: the lower one from below, the higher one from above."""
        first, last = self._bin(low)[0], self._bin(high)[0]
        # samples in the outermost bins are bounded by the extremes alone
        below = np.where(first == 0, self.least, self.bins.place(_EDGES[first]))
        above = np.where(last == BINS - 1, self.greatest, self.bins.place(_EDGES[last + 1]))
        return self._within(below), self._within(above)

    def _bin(self, rank: Array) -> tuple[Counts, Counts, Counts]:
        """Bin that holds a rank, number of samples before it, and number in it, (e,) each."""
        total = np.cumsum(self.counts, axis=-1)
        number = np.minimum(np.count_nonzero(total <= rank[:, None], axis=-1), BINS - 1)[:, None]
        inside = np.take_along_axis(self.counts, number, axis=-1)
        before = np.take_along_axis(total, number, axis=-1) - inside
        return number[:, 0], before[:, 0], inside[:, 0]

    def _within(self, value: Array) -> Array:
        return np.where(self.n > 0, np.clip(value, self.least, self.greatest), np.nan)
