"""Thresholds below which an eigenvalue or a pivot is zero but for rounding."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

# An eigenvalue of a matrix of n rows with unit diagonal is zero below this many eps times the square root of n.
_ROUNDINGS = 8.0
_EPS = float(np.finfo(np.float64).eps)
# If inverse iteration makes a random vector grow by this share of the growth for a zero eigenvalue, the matrix may be
# singular: the vector may have that small a part in the eigenvector.
SUSPECT = 1e-6


def zero_eigenvalue(size: int) -> float:
    """Threshold below which an eigenvalue of a matrix with unit diagonal counts as zero."""
    return _ROUNDINGS * math.sqrt(size) * _EPS


def surely_positive(least: NDArray[np.float64], size: int) -> NDArray[np.bool_]:
    """Whether the `least` pivots of matrices with unit diagonal are so large that no eigenvalue can be zero.

    A free motion of length one leaves a pivot of at most rounding over the square of its last component; for a rotating
    link of n nodes that square is 1 / n^3.
    """
    sure: NDArray[np.bool_] = least > zero_eigenvalue(size) * max(1.0 / SUSPECT, (size / 6.0) ** 3)
    return sure
