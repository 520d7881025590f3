"""Values of unknowns with more digits than double precision, as iterative refinement updates them."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ..batch import Array
from ..error_bounds.kinematic_edge import Real, extended
from ..program.pair_code import DoubleDouble, added

# With fewer columns than this, maxima are computed by row of the transpose, which is faster.
_NARROW = 16


class Refined(Protocol):
    """Values (size, m) with more digits than double precision, and their residual."""

    def left(self) -> Array:
        """Scaled residuals: loads (size, m) that the values leave unbalanced."""
        ...

    def add(self, change: Array) -> Array:
        """Add scaled changes (size, m); the greatest magnitude of these in each column, (m,), NaN where one is NaN."""
        ...

    @property
    def rounded(self) -> Array:
        """The values in double precision, (size, m)."""
        ...


class InLong:
    """Values in extended precision.

    Parameters
    ----------
    left
        Function that returns the residuals (size, m) of values (size, m).
    values
        The initial values, (size, m).
    root
        Scale of the unknowns, (size, m); None for one.
    """

    def __init__(self, left: Callable[[Real], Array], values: Array, root: Array | None = None) -> None:
        self._left, self._values, self._root = left, extended(values), root

    def left(self) -> Array:
        """Scaled loads (size, m) that they leave."""
        left = self._left(self._values)
        return left if self._root is None else left * self._root

    def add(self, change: Array) -> Array:
        """Add scaled changes (size, m); the greatest size of these in each column, NaN where one is, (m,)."""
        self._values += change if self._root is None else change * self._root
        return greatest(change)

    @property
    def rounded(self) -> Array:
        """In double precision."""
        return self._values.astype(np.float64)


class InPairs:
    """Values in double-double precision (pairs of doubles), by machine code; `left` returns scaled residuals."""

    def __init__(self, left: Callable[[DoubleDouble, Array], Array], values: Array, root: Array | None = None) -> None:
        self._left, self._values = left, DoubleDouble(values, np.zeros(values.shape))
        self._root = np.ones(values.shape) if root is None else root
        self._own = False  # the given array must not be overwritten

    def left(self) -> Array:
        """Scaled loads (size, m) that they leave."""
        return self._left(self._values, self._root)

    def add(self, change: Array) -> Array:
        """Add scaled changes (size, m); the greatest size of these in each column, NaN where one is, (m,)."""
        self._values, moved = added(self._values, change, self._root, overwrite=self._own)
        self._own = True
        return moved

    @property
    def rounded(self) -> Array:
        """In double precision."""
        return self._values.rounded


def greatest(values: Array) -> Array:
    """Greatest magnitude in each column of numbers (size, m), (m,)."""
    found: Array
    if values.shape[1] < _NARROW:
        found = np.abs(values.T, order="C").max(axis=1, initial=0.0)
    else:
        found = np.maximum(values.max(axis=0, initial=0.0), -values.min(axis=0, initial=0.0))
    return found
