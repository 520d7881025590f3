"""How far samples of a vector spread, at every pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from .moments import Moments

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spread:
    """Statistics of samples over their last axis but one.

    Parameters
    ----------
    samples
        Samples, (..., n, 3); NaN where there are none.
    """

    samples: Array

    @cached_property
    def _moments(self) -> Moments:
        return Moments.of(np.moveaxis(self.samples, -2, 0))

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.samples.shape[-2])

    @property
    def mean(self) -> Array:
        """Mean, (..., 3)."""
        return self._moments.mean

    @property
    def std(self) -> Array:
        """Standard deviation with n − 1 in the denominator, (..., 3)."""
        return self._moments.std

    @property
    def standard_error(self) -> Array:
        """Standard error of the mean, (..., 3)."""
        return self._moments.standard_error

    @property
    def std_standard_error(self) -> Array:
        """Standard error of the standard deviation, (..., 3)."""
        return self._moments.std_standard_error

    def quantile(self, p: ArrayLike) -> Array:
        """Quantiles, interpolated linearly between samples.

        Parameters
        ----------
        p
            Probability or probabilities in [0, 1], (k...).

        Returns
        -------
        ndarray
            Quantiles, (k..., ..., 3).
        """
        return np.asarray(np.quantile(self.samples, np.asarray(p, dtype=np.float64), axis=-2))

    @cached_property
    def envelope(self) -> tuple[Array, Array]:
        """Least and greatest sample of each component, (..., 3) each."""
        return self.samples.min(axis=-2), self.samples.max(axis=-2)
