"""What rounding leaves of an eigenvalue that is zero."""

from __future__ import annotations

import math

import numpy as np

# Roundings, for the square root of its size, below which an eigenvalue of a matrix with unit diagonal is zero.
_ROUNDINGS = 8.0
_EPS = float(np.finfo(np.float64).eps)


def zero_eigenvalue(size: int) -> float:
    """What counts as zero among the eigenvalues of a matrix with unit diagonal."""
    return _ROUNDINGS * math.sqrt(size) * _EPS
