"""Vector algebra on scalars that are numbers or recorded terms; operations with exact 0 and 1 are left out."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ....framework.program.recording import Term

Value = float | NDArray[np.float64]
Scalar = float | Term
Vector = Sequence[Scalar]


def product(x: Scalar, y: Scalar) -> Scalar:
    """x y; nothing is recorded for a factor of exactly 0 or 1, as most components of axes are."""
    if type(x) is float:
        x, y = y, x
    if type(x) is Term and type(y) is float:
        if y == 0.0:
            return 0.0
        if y == 1.0:
            return x
    return x * y


def total(x: Scalar, y: Scalar) -> Scalar:
    """x + y; nothing is recorded for a zero."""
    if type(x) is float:
        x, y = y, x
    return x if type(x) is Term and type(y) is float and y == 0.0 else x + y


def difference(x: Scalar, y: Scalar) -> Scalar:
    """x - y; nothing is recorded for a zero."""
    return x if type(x) is Term and type(y) is float and y == 0.0 else x - y


def plus(a: Vector, b: Vector) -> list[Scalar]:
    """a + b."""
    return [total(x, y) for x, y in zip(a, b, strict=True)]


def minus(a: Vector, b: Vector) -> list[Scalar]:
    """a - b."""
    return [difference(x, y) for x, y in zip(a, b, strict=True)]


def times(factor: Scalar, a: Vector) -> list[Scalar]:
    """A vector times a number."""
    return [product(factor, x) for x in a]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    out: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        out = total(out, product(x, y))
    return out


def cross(a: Vector, b: Vector) -> list[Scalar]:
    """Vector product."""
    return [difference(product(a[i], b[j]), product(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]


def combine(axes: Sequence[Vector], a: Vector) -> list[Scalar]:
    """The vector with the components `a` along the three `axes`."""
    out: list[Scalar] = [0.0, 0.0, 0.0]
    for axis, x in zip(axes, a, strict=True):
        out = plus(out, times(x, axis))
    return out
