"""What rounding leaves of an eigenvalue that is zero."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

# Roundings, for the square root of its size, below which an eigenvalue of a matrix with unit diagonal is zero.
_ROUNDINGS = 8.0
_EPS = float(np.finfo(np.float64).eps)
# A random vector that inverse iteration makes grow by this share of what it would for a zero eigenvalue is suspect:
# it may have missed the eigenvector by as much.
SUSPECT = 1e-6


def zero_eigenvalue(size: int) -> float:
    """What counts as zero among the eigenvalues of a matrix with unit diagonal."""
    return _ROUNDINGS * math.sqrt(size) * _EPS


def surely_positive(least: NDArray[np.float64], size: int) -> NDArray[np.bool_]:
    """Whether the least pivots of matrices with unit diagonal are so large that no eigenvalue can be zero.

    A motion of length one that costs no energy leaves a pivot of nothing but rounding over the square of what the last
    unknown that moves does so; where a link of n nodes turns, that is 1 / n^3.
    """
    sure: NDArray[np.bool_] = least > zero_eigenvalue(size) * max(1.0 / SUSPECT, (size / 6.0) ** 3)
    return sure
