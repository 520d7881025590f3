"""Vector algebra on scalars that are numbers, arrays or recorded terms; operations with exact 0 and 1 are left out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from ....framework.program.recording import Term

Value = float | NDArray[np.float64]
Scalar = float | Term
Vector = Sequence[Scalar]
S = TypeVar("S", Scalar, Value)


def product(x: S, y: S) -> S:
    """x y; nothing is computed or recorded for a factor of exactly 0 or 1, as most components of axes are."""
    if type(x) is float:
        x, y = y, x
    if type(x) is not float and type(y) is float:
        if y == 0.0:
            return 0.0
        if y == 1.0:
            return x
    return x * y


def total(x: S, y: S) -> S:
    """x + y; nothing is computed or recorded for a zero."""
    if type(x) is float:
        x, y = y, x
    return x if type(x) is not float and type(y) is float and y == 0.0 else x + y


def difference(x: S, y: S) -> S:
    """x - y; nothing is computed or recorded for a zero."""
    return x if type(x) is not float and type(y) is float and y == 0.0 else x - y


def plus(a: Sequence[S], b: Sequence[S]) -> list[S]:
    """a + b."""
    return [total(x, y) for x, y in zip(a, b, strict=True)]


def minus(a: Sequence[S], b: Sequence[S]) -> list[S]:
    """a - b."""
    return [difference(x, y) for x, y in zip(a, b, strict=True)]


def times(factor: S, a: Sequence[S]) -> list[S]:
    """A vector times a number."""
    return [product(factor, x) for x in a]


def dot(a: Sequence[S], b: Sequence[S]) -> S:
    """Scalar product."""
    out: S = 0.0
    for x, y in zip(a, b, strict=True):
        out = total(out, product(x, y))
    return out


def cross(a: Sequence[S], b: Sequence[S]) -> list[S]:
    """Vector product."""
    return [difference(product(a[i], b[j]), product(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1))]


def combine(axes: Sequence[Sequence[S]], a: Sequence[S]) -> list[S]:
    """The vector with the components `a` along the three `axes`."""
    out: list[S] = [0.0, 0.0, 0.0]
    for axis, x in zip(axes, a, strict=True):
        if type(x) is float and x == 0.0:
            continue
        for k, component in enumerate(axis):
            if type(component) is not float or component != 0.0:
                out[k] = total(out[k], product(x, component))
    return out
