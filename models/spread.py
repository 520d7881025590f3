"""How far samples of a vector spread, at every pose."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.batch import finite
from ..framework.errors import FrameError
from .moments import Moments, Statistics

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Spread(Statistics):
    """Statistics of samples over their last axis but one.

    Parameters
    ----------
    samples
        Samples, (..., n, 3); NaN where there are none.

    Examples
    --------
    >>> spread = Spread(np.array([[1.0, 0.0, 0.0], [3.0, 0.0, 0.0]]))
    >>> spread.mean.tolist(), spread.quantile(0.75).tolist()
    ([2.0, 0.0, 0.0], [2.5, 0.0, 0.0])
    """

    samples: Array

    @cached_property
    def moments(self) -> Moments:
        """Count, mean and sums of powers of the deviations, (..., 3)."""
        return Moments.of(np.moveaxis(self.samples, -2, 0))

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.samples.shape[-2])

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
        return quantiles(self.samples, p, axis=-2)

    @cached_property
    def envelope(self) -> tuple[Array, Array]:
        """Least and greatest sample of each component, (..., 3) each."""
        return self.samples.min(axis=-2), self.samples.max(axis=-2)


def quantiles(samples: Array, p: ArrayLike, axis: int) -> Array:
    """Quantiles at probabilities `p` (k...) of samples along an axis, (k..., ...)."""
    asked = finite(p, "probability p of a quantile")
    if np.any((asked < 0.0) | (asked > 1.0)):
        raise FrameError(f"probability p of a quantile is {asked.tolist()}: give numbers from 0 to 1")
    return np.asarray(np.quantile(samples, asked, axis=axis))
