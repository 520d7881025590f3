"""Interpolation of closed poses: cubic Hermite between two nodes, and polynomials through several."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array

# Interpolation points on both sides of the one in the middle, which is left out, in units of their spacing.
SIDES = np.array([-4.0, -3.0, -2.0, -1.0, 1.0, 2.0, 3.0, 4.0])

Number = TypeVar("Number", float, Array)


def shares(t: Number, width: Any) -> tuple[Number, Number, Number, Number]:
    """Weights of state and rate of the first node, then of the second, in the cubic Hermite interpolant.

    Parameters
    ----------
    t
        Position from 0 at the first node to 1 at the second; beyond 1 it extrapolates.
    width
        Distance of the nodes.
    """
    tt, back = t * t, (1.0 - t) * (1.0 - t)
    return (1.0 + 2.0 * t) * back, t * back * width, tt * (3.0 - 2.0 * t), tt * (t - 1.0) * width


def cubic(a: Array, u: Array, b: Array, v: Array, t: Array, width: Array) -> Array:
    """States at ``t * width`` from a on the cubic through a and b with the rates u and v."""
    p, q, r, w = shares(t, width)
    out: Array = p * a + q * u
    out += r * b + w * v
    return out


def weights(knots: ArrayLike, s: ArrayLike) -> Array:
    """Lagrange basis polynomials of the knots at s (M,), (knots, M); a single s gives (knots,)."""
    places, at = np.asarray(knots, dtype=np.float64), np.asarray(s, dtype=np.float64)
    out = np.ones((len(places), *at.shape))
    for j, knot in enumerate(places):
        for k, other in enumerate(places):
            if k != j:
                out[j] *= (at - other) / (knot - other)
    return out


def at_zero(values: Sequence[float], arguments: Sequence[float]) -> float:
    """Value at argument 0 of the polynomial through the points; not finite where two arguments are equal."""
    with np.errstate(all="ignore"):
        return float(weights(arguments, 0.0) @ np.asarray(values))
