"""Covariance of the components of a result, from a stream of samples."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..moments import Moments

Array = NDArray[np.float64]

# Number of samples for one estimate of the covariance; the scatter of these estimates gives its standard error.
PART = 128


@dataclass(frozen=True, eq=False)
class Comoments:
    """Count, mean and sums of products of the deviations, and the scatter of the covariance from part to part.

    Parameters
    ----------
    n
        Number of samples without NaN in any component, (...).
    mean
        Mean, (..., c).
    second
        Sums over the samples of (x_i − mean_i) (x_j − mean_j), (..., c, c).
    scatter
        Moments of the covariances of the parts, (..., c, c).
    """

    n: NDArray[np.int64]
    mean: Array
    second: Array
    scatter: Moments

    @classmethod
    def of(cls, block: Array, nan_policy: str) -> Comoments:
        """Comoments of a block of samples (m, ..., c)."""
        parts = list(_parts(block, nan_policy))
        out = parts[0]
        for part in parts[1:]:
            out = out.merge(part)
        return out

    def merge(self, other: Comoments) -> Comoments:
        """Comoments of two sets of samples together, by the formula of Chan, Golub & LeVeque (1983) for products."""
        a, b = self.n, other.n
        n = a + b
        with np.errstate(invalid="ignore"):
            d = np.where(np.minimum(a, b)[..., None] > 0, other.mean - self.mean, 0.0)
        weight = a * b / np.maximum(n, 1)
        with np.errstate(invalid="ignore"):  # infinite samples have no covariance
            second = self.second + other.second + weight[..., None, None] * d[..., :, None] * d[..., None, :]
            mean = np.where(a[..., None] > 0, self.mean, other.mean) + d * (b / np.maximum(n, 1))[..., None]
        return Comoments(n, mean, second, self.scatter.merge(other.scatter))

    @property
    def covariance(self) -> Array:
        """Covariance with n − 1 in the denominator, (..., c, c)."""
        return np.asarray(self.second / np.where(self.n > 1, self.n - 1, np.nan)[..., None, None])

    @property
    def standard_error(self) -> Array:
        """Standard error of the covariance, (..., c, c), from its scatter over the parts."""
        return self.scatter.standard_error

    @property
    def freedom(self) -> NDArray[np.int64]:
        """Degrees of freedom of the standard error, (..., c, c)."""
        return np.broadcast_to(np.asarray(self.scatter.n) - 1, self.second.shape)


def _parts(block: Array, nan_policy: str) -> Iterator[Comoments]:
    count = max(1, len(block) // PART)
    for part in np.array_split(block, count):
        lost = np.isnan(part).any(axis=-1) & (nan_policy == "omit")
        there: NDArray[np.bool_] = np.asarray(~lost)
        n: NDArray[np.int64] = np.asarray(there.sum(axis=0, dtype=np.int64))
        kept = np.where(there[..., None], part, 0.0)
        with np.errstate(invalid="ignore"):
            mean = np.asarray(kept.sum(axis=0) / np.where(n > 0, n, 1)[..., None])
            off = np.where(there[..., None], part - mean, 0.0)
            second = np.einsum("m...i,m...j->...ij", off, off)
        few = n[..., None, None] > 1
        own = second / np.where(few, n[..., None, None] - 1, 1)
        nothing = np.zeros(second.shape)
        text = np.where(np.broadcast_to(few, second.shape), 1, 0)
        yield Comoments(
            np.asarray(n), mean, second, Moments(text, np.where(few, own, np.nan), nothing, nothing, nothing)
        )
