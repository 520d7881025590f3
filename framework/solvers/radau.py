"""Bounds on the energy ``f . K^-1 f`` by conjugate gradients and the Gauss-Radau quadrature rule.

Preconditioned conjugate gradients, with the matrix K, preconditioner C and load f, are Lanczos' method on C K. The
eigenvalues of its tridiagonal matrix (Ritz values) lie within the range of those of C K, and the least converges to the
least of these. Given a lower bound on that, the Gauss-Radau rule with a node there bounds ``f . K^-1 f`` from above
after any number of steps; without a step the bound is ``f . C f`` over that number. (Golub & Meurant, *Matrices,
Moments and Quadrature with Applications*, 2010, ch. 6 and 12; the recurrence is that of Meurant & Tichy, Numer.
Algorithms 62, 2013, 163-191.)
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
        Step lengths alpha of conjugate gradients, (k,).
    growths
        Coefficients beta of their directions, (k - 1,).
    """
    inverse, share = 1.0 / np.array(lengths), np.array(growths)
    diagonal = inverse.copy()
    diagonal[1:] += share * inverse[:-1]
    beside = np.sqrt(share) * inverse[:-1]
    found = scipy.linalg.eigvalsh_tridiagonal(diagonal, beside, select="i", select_range=(0, 0))
    return float(found[0])


def stored(load: Array, acting: Any, precondition: Operator, least: float, steps: int) -> float:
    """Upper bound on ``load . K^-1 load``.

    Parameters
    ----------
    load
        The load f (n,).
    acting
        The matrix K (n, n).
    precondition
        Function that multiplies by the preconditioner C.
    least
        Lower bound on the eigenvalues of C K.
    steps
        Largest number of steps of conjugate gradients, each of which lowers the bound.

    Returns
    -------
    float
        The bound; inf if `least` is not positive, or the steps show that it is no lower bound, or that the
        preconditioner is not positive definite.
    """
    if not least > 0.0:
        return np.inf
    residual, total, beyond = load, 0.0, 1.0 / least
    way = z = precondition(residual)
    power = dot(residual, z)
    for _ in range(steps):
        if not power > 0.0:
            break
        ahead = acting @ way
        length = power / dot(way, ahead)
        if not 0.0 < length < beyond:
            return np.inf
        total += length * power
        residual = residual - length * ahead
        z = precondition(residual)
        before, power = power, dot(residual, z)
        growth = power / before
        beyond = (beyond - length) / (least * (beyond - length) + growth)
        way = z + growth * way
    return total + beyond * power if power >= 0.0 else np.inf


def dot(a: Array, b: Array) -> float:
    """Inner product without BLAS, whose threads would wait for each other at every step."""
    return float(np.einsum("i,i->", a, b))
