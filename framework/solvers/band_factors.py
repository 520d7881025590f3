"""Banded Cholesky factors of the entries of a batch: one after the other by LAPACK, or several at a time by machine
code.

With either, the result for an entry does not depend on the other entries; the two differ in rounding.
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

# Largest width of a band at which the overhead of LAPACK's calls outweighs its arithmetic. From _MANY columns of all
# entries on, machine code takes at most three quarters of LAPACK's time, and soon a quarter; loading it takes some 30
# ms, once in a process. From _MORE on it also saves time where lanes are left unused, or for residuals by themselves.
_NARROW, _MANY, _MORE = 80, 2**9, 2**13
# NumPy factorises all matrices at once where a band has up to _SMALL numbers and there are at least _LONG entries; then
# at least TOGETHER at a time, which makes the overhead of its calls small.
_SMALL, _LONG, TOGETHER = 2**12, 400, 2**10
# Time that machine code takes for an entry, over that of LAPACK.
_ABREAST = 0.45


class Room:
    """One piece of memory for the arrays of a batch that are kept, so that other memory can be reused.

    Parameters
    ----------
    numbers
        Size in numbers; further arrays are allocated separately.
    """

    def __init__(self, numbers: int) -> None:
        self._left = np.zeros(numbers)

    def zeros(self, shape: tuple[int, ...]) -> Array:
        """An array of zeros of a shape."""
        size = math.prod(shape)
        if size > len(self._left):
            return np.zeros(shape)
        taken, self._left = self._left[:size], self._left[size + -size % WIDTH :]
        return taken.reshape(shape)


# A function that makes an array of zeros of a shape.
Zeros = Callable[[tuple[int, ...]], Array]


class BandFactors(Protocol):
    """Factors of m matrices of n columns."""

    @property
    def least(self) -> Array:
        """Least diagonal entry of L, at most one, (m,); NaN or not above zero if a matrix is not positive definite."""
        ...

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        ...


def side_by_side(entries: int, size: int, width: int) -> bool:
    """Whether to factorise matrices several at a time, given their number, size and band width.

    Unused lanes of the last group take as long as the others.
    """
    pays = _ABREAST * in_lanes(entries) <= entries
    enough = _MANY if entries >= WIDTH else _MORE
    return width <= _NARROW and entries * size >= enough and pays and available()


def in_one_pass(entries: int) -> bool:
    """Whether what is side by side can also be refined in one pass, where deformations do not vary."""
    return entries >= WIDTH and fused()


def in_pairs(entries: int, size: int) -> bool:
    """Whether to compute residuals in double-double arithmetic (pairs of doubles) instead of extended precision.

    `entries` is the number of solutions, `size` that of their unknowns.
    """
    return entries >= WIDTH and entries * size >= _MORE and available() and fused()


def in_lanes(entries: int) -> int:
    """Number of entries rounded up to whole groups of lanes."""
    return WIDTH * -(-entries // WIDTH)


def _least(lanes: Array) -> Array:
    """Minimum over the middle axis of (groups, n, WIDTH), at most one, (groups, WIDTH); NaN where a number is NaN.

    Halves are compared with each other, which NumPy does faster than a reduction along that axis.
    """
    while (count := lanes.shape[1]) > WIDTH:
        half = (count + 1) // 2  # of an odd number the middle one is compared with itself
        lanes = np.minimum(lanes[:, :half], lanes[:, count - half :])
    found: Array = lanes.min(axis=1, initial=1.0)
    return found


class OneByOne:
    """Factors of m matrices by LAPACK.

    Parameters
    ----------
    values
        Nonzero entries on and below the diagonal, (entries of a matrix, m).
    position
        Position of each entry in the band, which is stored column by column.
    size, width
        Number of columns, and of diagonals on and below the main one.
    zeros
        Function that allocates the array of the factors.
    """

    def __init__(self, values: Array, position: Index, size: int, width: int, zeros: Zeros = np.zeros) -> None:
        self._shape = size, width
        self._bands = zeros((values.shape[1], size * width))
        self._bands[:, position] = values.T
        # a view of each, made once: for a small band that takes as long as the factorisation
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


class AllAtOnce:
    """Factors by operations of NumPy on all matrices, column by column, see `OneByOne`: the bits of machine code."""

    def __init__(self, values: Array, position: Index, size: int, width: int, zeros: Zeros = np.zeros) -> None:
        self._size = size
        self._bands = zeros((size + width, width, values.shape[1]))
        self._bands.reshape(-1, values.shape[1])[position] = values
        self._heights = _heights(position, size, width)
        with np.errstate(all="ignore"):
            self._factorise()

    def _factorise(self) -> None:
        """Overwrite the matrices with their factors; NaN from the first negative pivot on."""
        room = np.empty(self._bands.shape[1:])
        for j, height in enumerate(self._heights):
            column = self._bands[j, : height + 1]
            np.sqrt(column[0], out=column[0])
            column[1:] /= column[0]
            for i in range(1, height + 1):
                rest = self._bands[j + i, : height + 1 - i]
                rest -= np.multiply(column[i:], column[i], out=room[: len(rest)])

    @property
    def least(self) -> Array:
        """Least number on the diagonal of L, or one, (m,); not above zero, or NaN, where there is no such factor."""
        found: Array = _least(self._bands[None, : self._size, 0])[0]
        return found

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        every = np.array_equal(entries, np.arange(self._bands.shape[2]))
        bands = self._bands if every else self._bands[:, :, entries]
        for k in range(loads.shape[2]):
            rows = np.zeros((self._size + self._bands.shape[1], len(entries)))
            rows[: self._size] = loads[:, :, k]
            with np.errstate(all="ignore"):
                self._substitute(bands, rows)
            loads[:, :, k] = rows[: self._size]

    def _substitute(self, bands: Array, rows: Array) -> None:
        """Overwrite loads (columns, entries) with solutions."""
        room = np.empty(bands.shape[1:])
        for j, height in enumerate(self._heights):
            rows[j] /= bands[j, 0]
            rows[j + 1 : j + 1 + height] -= np.multiply(bands[j, 1 : height + 1], rows[j], out=room[:height])
        for j in reversed(range(self._size)):
            for i in range(1, self._heights[j] + 1):
                rows[j] -= np.multiply(bands[j, i], rows[j + i], out=room[0])
            rows[j] /= bands[j, 0]


def _heights(position: Index, size: int, width: int) -> list[int]:
    """How many entries below the diagonal each column of a factor has, fill included."""
    column, below = np.divmod(position, width)
    height = np.zeros(size, dtype=np.int64)
    np.maximum.at(height, column, below)
    at = np.arange(size)
    reach: list[int] = (np.maximum.accumulate(at + height) - at).tolist()
    return reach


class SideBySide:
    """Factors by machine code, see `OneByOne`."""

    def __init__(self, values: Array, position: Index, size: int, width: int, zeros: Zeros = np.zeros) -> None:
        self._size, self._width, self._count = size, width, values.shape[1]
        groups = -(-self._count // WIDTH)
        self._bands = zeros((groups, size + width, width, WIDTH))
        for group, whole in enumerate(self._bands.reshape(groups, -1, WIDTH)):
            some = values[:, group * WIDTH : (group + 1) * WIDTH]
            whole[position, : some.shape[1]] = some
            whole[position, some.shape[1] :] = some[:, :1]  # unused lanes repeat the first one
        band_code.factorise(self._bands)

    @property
    def least(self) -> Array:
        """Least number on the diagonal of L, or one, (m,); not above zero, or NaN, where there is no such factor."""
        return _least(self._bands[:, : self._size, 0]).reshape(-1)[: self._count]

    def solve(self, entries: Index, loads: Array) -> None:
        """Replace the loads (n, entries, k) on some entries by solutions."""
        if not loads.size:
            return
        lane: slice | Index
        # as most often, all in order: a slice is copied as it lies in memory
        if np.array_equal(entries, np.arange(self._count)):
            groups, lane = np.arange(len(self._bands)), slice(self._count)
        else:
            groups, at = np.unique(entries // WIDTH, return_inverse=True)
            lane = WIDTH * at + entries % WIDTH
        rows = np.empty((self._size + self._width, loads.shape[2], len(groups), WIDTH))
        rows[self._size :] = 0.0
        lanes = rows[: self._size].reshape(self._size, loads.shape[2], -1)
        if len(entries) < lanes.shape[2]:
            lanes[...] = 0.0
        lanes[:, :, lane] = loads.swapaxes(1, 2)
        band_code.solve(self._bands, groups, rows)
        loads[...] = lanes[:, :, lane].swapaxes(1, 2)


def kind_of(entries: int, size: int, width: int) -> type[OneByOne | AllAtOnce | SideBySide]:
    """Class of the factors of a batch, given the number of its matrices, their size and band width."""
    if side_by_side(entries, size, width):
        return SideBySide
    return AllAtOnce if size * width <= _SMALL and entries >= _LONG else OneByOne
