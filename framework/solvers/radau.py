"""What steps of preconditioned conjugate gradients tell of the inverse of a matrix, beside the solution.

With K the matrix, C its preconditioner and a load f, they are Lanczos' method on C K. The eigenvalues of their
tridiagonal matrix (Ritz values) lie among those of C K, and the least comes down to the least of these. With a number
below that, Gauss-Radau's rule with a node there bounds ``f . K^-1 f`` from above after any number of steps; without a
step it says ``f . C f`` over that number. (Golub & Meurant, *Matrices, Moments and Quadrature with Applications*, 2010,
ch. 6 and 12; the recurrence is that of Meurant & Tichy, Numer. Algorithms 62, 2013, 163-191.)
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import scipy

from ..batch import Array

Operator = Callable[[Array], Array]


def least_ritz(lengths: Sequence[float], growths: Sequence[float]) -> float:
    """Least Ritz value.

    Parameters
    ----------
    lengths
        Of the steps along their directions, (k,).
    growths
        What of each direction but the last the next one took along, (k - 1,).
    """
    inverse, share = 1.0 / np.array(lengths), np.array(growths)
    diagonal = inverse.copy()
    diagonal[1:] += share * inverse[:-1]
    beside = np.sqrt(share) * inverse[:-1]
    found = scipy.linalg.eigvalsh_tridiagonal(diagonal, beside, select="i", select_range=(0, 0))
    return float(found[0])


def stored(load: Array, acting: Any, precondition: Operator, least: float, steps: int) -> float:
    """What ``load . K^-1 load`` is not above.

    Parameters
    ----------
    load
        The load f (n,).
    acting
        The matrix K (n, n).
    precondition
        Multiplies by C.
    least
        What no eigenvalue of C K is below.
    steps
        Steps of conjugate gradients at most; the bound comes down with each.

    Returns
    -------
    float
        The bound; inf where `least` is not above zero, or the steps show that it, or the preconditioner, is not what it
        should be.
    """
    if not least > 0.0:
        return np.inf
    residual, total, beyond = load, 0.0, 1.0 / least
    way = z = precondition(residual)
    power = float(residual @ z)
    for _ in range(steps):
        if not power > 0.0:
            break
        ahead = acting @ way
        length = power / float(way @ ahead)
        if not 0.0 < length < beyond:
            return np.inf
        total += length * power
        residual = residual - length * ahead
        z = precondition(residual)
        before, power = power, float(residual @ z)
        growth = power / before
        beyond = (beyond - length) / (least * (beyond - length) + growth)
        way = z + growth * way
    return total + beyond * power if power >= 0.0 else np.inf
