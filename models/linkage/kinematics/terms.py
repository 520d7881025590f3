"""Vectors of numbers that are written down, and of numbers."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.program.recording import Term

Value = float | NDArray[np.float64]
Scalar = float | Term
Vector = Sequence[Scalar]


def plus(a: Vector, b: Vector) -> list[Scalar]:
    """a + b."""
    return [x + y for x, y in zip(a, b, strict=True)]


def minus(a: Vector, b: Vector) -> list[Scalar]:
    """a - b."""
    return [x - y for x, y in zip(a, b, strict=True)]


def times(factor: Scalar, a: Vector) -> list[Scalar]:
    """A vector times a number."""
    return [factor * x for x in a]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> list[Scalar]:
    """Vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def combine(axes: Sequence[Vector], a: Vector) -> list[Scalar]:
    """Sum of the three `axes` times the components of `a`: the vector that has them along these axes."""
    total: list[Scalar] = [0.0, 0.0, 0.0]
    for axis, x in zip(axes, a, strict=True):
        total = plus(total, times(x, axis))
    return total
