"""Cholesky factors of the entries of a batch within bands: LAPACK takes one after the other, machine code some abreast.

Both round each step of an entry as if that were alone; from one to the other, roundings differ.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

import numpy as np
import scipy

from ..batch import Array
from ..program import band_code
from ..program.machine_code import available, fused
from ..program.machine_text import WIDTH
from ..structure.topology import Index

# Width of a band up to which LAPACK's calls outweigh its arithmetic, and columns of all entries from which on machine
# code saves more than it takes to load it.
_NARROW, _MANY = 80, 2**13
# Share of LAPACK's time that machine code takes for an entry.
_ABREAST = 0.45


class Room:
    """Memory for what is kept of a batch: it lies together, so that the memory of all else serves again.

    Parameters
    ----------
    numbers
        How many there is room for; arrays beyond these lie anywhere.
    """

    def __init__(self, numbers: int) -> None:
        self._left = np.zeros(numbers)

    def zeros(self, shape: tuple[int, ...]) -> Array:
        """The next array, of zeros."""
        size = math.prod(shape)
        if size > len(self._left):
            return np.zeros(shape)
        taken, self._left = self._left[:size], self._left[size + -size % WIDTH :]
        return taken.reshape(shape)


# Makes an array of zeros of a shape.
Zeros = Callable[[tuple[int, ...]], Array]


class BandFactors(Protocol):
    """Factors of m matrices of n columns."""

    @property
    def least(self) -> Array:
        """Least number on the diagonal of L, or one, (m,); not above zero, or NaN, where there is no such factor."""
        ...

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        ...


def side_by_side(entries: int, size: int, width: int) -> bool:
    """Whether so many matrices, each of so many columns, are taken some at a time.

    Lanes that are left over take as long as the others.
    """
    pays = _ABREAST * in_lanes(entries) <= entries
    return width <= _NARROW and entries * size >= _MANY and pays and available()


def in_pairs(entries: int, size: int) -> bool:
    """Whether residuals of so many solutions of so many unknowns are computed in pairs of double numbers.

    They are in extended precision else.
    """
    return entries >= WIDTH and entries * size >= _MANY and available() and fused()


def in_lanes(entries: int) -> int:
    """How many entries there are with the lanes that are left over."""
    return WIDTH * -(-entries // WIDTH)


def _least(lanes: Array) -> Array:
    """Least numbers (groups, WIDTH) of some (groups, n, WIDTH), or one; NaN where one is.

    Halves are held against each other, as NumPy otherwise takes every few lanes by themselves.
    """
    while (count := lanes.shape[1]) > WIDTH:
        half = (count + 1) // 2  # of an odd number the middle one is held against itself
        lanes = np.minimum(lanes[:, :half], lanes[:, count - half :])
    found: Array = lanes.min(axis=1, initial=1.0)
    return found


class OneByOne:
    """Factors by LAPACK.

    Parameters
    ----------
    values
        What is not zero on and below the diagonal, (entries of a matrix, m).
    position
        Where this lies in a band, column by column.
    size, width
        Columns, and diagonals on and below the main one.
    zeros
        Makes the array that the factors lie in.
    """

    def __init__(self, values: Array, position: Index, size: int, width: int, zeros: Zeros = np.zeros) -> None:
        self._shape = size, width
        self._bands = zeros((values.shape[1], size * width))
        self._bands[:, position] = values.T
        # a view of each, made once: LAPACK takes no longer for a short band than to make one
        self._each: list[Array] = list(self._bands.reshape(-1, size, width).transpose(0, 2, 1))
        factorise = scipy.linalg.lapack.dpbtrf
        self.failed = np.array([factorise(band, lower=1, overwrite_ab=1)[1] != 0 for band in self._each], dtype=bool)

    @property
    def least(self) -> Array:
        """Least number on the diagonal of L, or one, (m,); NaN where there is no such factor."""
        found: Array = self._bands.reshape(-1, *self._shape)[..., 0].min(axis=1, initial=1.0)
        found[self.failed] = np.nan
        return found

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        each = np.ascontiguousarray(loads.transpose(1, 2, 0))
        substitute = scipy.linalg.lapack.dpbtrs
        for entry, load in zip(entries.tolist(), each.transpose(0, 2, 1), strict=True):
            substitute(self._each[entry], load, lower=1, overwrite_b=1)
        loads[...] = each.transpose(2, 0, 1)


class SideBySide:
    """Factors by machine code, see `OneByOne`."""

    def __init__(self, values: Array, position: Index, size: int, width: int, zeros: Zeros = np.zeros) -> None:
        self._size, self._width, self._count = size, width, values.shape[1]
        groups = -(-self._count // WIDTH)
        self._bands = zeros((groups, size + width, width, WIDTH))
        for group, whole in enumerate(self._bands.reshape(groups, -1, WIDTH)):
            some = values[:, group * WIDTH : (group + 1) * WIDTH]
            whole[position, : some.shape[1]] = some
            whole[position, some.shape[1] :] = some[:, :1]  # lanes that are left over do what another one does
        band_code.factorise(self._bands)

    @property
    def least(self) -> Array:
        """Least number on the diagonal of L, or one, (m,); not above zero, or NaN, where there is no such factor."""
        return _least(self._bands[:, : self._size, 0]).reshape(-1)[: self._count]

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        if not loads.size:
            return
        groups, at = np.unique(entries // WIDTH, return_inverse=True)
        where = WIDTH * at + entries % WIDTH
        rows = np.empty((self._size + self._width, loads.shape[2], len(groups), WIDTH))
        rows[self._size :] = 0.0
        lanes = rows[: self._size].reshape(self._size, loads.shape[2], -1)
        if len(where) < lanes.shape[2]:
            lanes[...] = 0.0
        # a slice is copied as it lies in memory
        lane = slice(len(where)) if np.array_equal(where, np.arange(len(where))) else where
        lanes[:, :, lane] = loads.swapaxes(1, 2)
        band_code.solve(self._bands, groups, rows)
        loads[...] = lanes[:, :, lane].swapaxes(1, 2)
