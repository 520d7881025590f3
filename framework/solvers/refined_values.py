"""Values that are refined, with more digits than those of double precision."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol

import numpy as np

from ..batch import Array
from ..error_bounds.kinematic_edge import Real, extended
from ..program.pair_code import DoubleDouble, added

# Columns below which they are looked at one by one.
_NARROW = 16


class Refined(Protocol):
    """Values (size, m) with more digits than those of double precision."""

    def left(self) -> Array:
        """Scaled loads (size, m) that they leave of their equations."""
        ...

    def add(self, change: Array) -> Array:
        """Add scaled changes (size, m); the greatest size of these in each column, NaN where one is, (m,)."""
        ...

    @property
    def rounded(self) -> Array:
        """In double precision."""
        ...


class InLong:
    """Values in extended precision.

    Parameters
    ----------
    left
        Unbalanced loads (size, m) of values (size, m).
    values
        The values, (size, m).
    root
        Their scale, (size, m); None for one.
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
    """The same in pairs of double numbers, by machine code; loads that they leave come with their scale."""

    def __init__(self, left: Callable[[DoubleDouble, Array], Array], values: Array, root: Array | None = None) -> None:
        self._left, self._values = left, DoubleDouble(values, np.zeros(values.shape))
        self._root = np.ones(values.shape) if root is None else root
        self._own = False  # what was given stays

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
    """Greatest size of each column of numbers (size, m), (m,)."""
    found: Array
    if values.shape[1] < _NARROW:
        found = np.abs(values.T, order="C").max(axis=1, initial=0.0)
    else:
        found = np.maximum(values.max(axis=0, initial=0.0), -values.min(axis=0, initial=0.0))
    return found
