"""Residuals of many batch entries in double-double arithmetic, several entries at a time, as machine code.

A double-double is the sum of two doubles, the second below the rounding of the first, so that it carries twice the
digits. Error-free products and sums are Dekker's and Knuth's (Ogita, Rump & Oishi, *Accurate Sum and Dot Product*, SIAM
J. Sci. Comput. 26(6), 2005, Algorithms 3.1, 3.5 and 5.3), with fused operations. They take a tenth of the time of
extended precision, which vector units do not have. It needs the extra ``fast``.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.typing import NDArray

from .loop_text import VECTOR as _V
from .loop_text import LoopText
from .machine_code import compiled_kernel
from .machine_text import WIDTH

Array = NDArray[np.float64]
# Where the row of an array lies, given the array's name and the number of the row.
Place = Callable[[str, str], str]


class DoubleDouble(NamedTuple):
    """Numbers in double-double precision: each is the sum ``large + small``."""

    large: Array
    small: Array

    @classmethod
    def of(cls, numbers: NDArray[Any]) -> DoubleDouble:
        """Numbers in extended precision as double-doubles, without loss."""
        large = numbers.astype(np.float64)
        return cls(large, (numbers - large).astype(np.float64))

    @property
    def rounded(self) -> Array:
        """The numbers in double precision."""
        return self.large + self.small


class Rows(NamedTuple):
    """A sparse matrix in compressed row format.

    Attributes
    ----------
    start, column
        Index at which each row starts, and at last where they end; and the column of each entry.
    numbers
        The entries.
    """

    start: NDArray[np.int64]
    column: NDArray[np.int64]
    numbers: DoubleDouble

    @classmethod
    def of(cls, matrix: scipy.sparse.csr_matrix) -> Rows:
        """The rows of a matrix in extended precision."""
        return cls(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), DoubleDouble.of(matrix.data))


def unbalanced(
    rows: Rows, given: DoubleDouble | None, stiffness: Array, forces: Array, values: DoubleDouble, root: Array
) -> Array:
    """Scaled residual ``root (f - A^T k (A u + g))``, with A u in double-double and the rest in double precision.

    Parameters
    ----------
    rows
        Deformations A of the springs per unknown.
    given
        Prescribed deformations g, (springs, m); None for none.
    stiffness
        Stiffness k of the springs, (springs, m).
    forces
        Forces f, (unknowns, m).
    values
        Values u of the unknowns, (unknowns, m).
    root
        Scale of the residual, (unknowns, m).

    Returns
    -------
    ndarray
        Scaled residual, (unknowns, m).
    """
    size, count = forces.shape
    known = (np.zeros((1, count)),) * 2 if given is None else given
    arrays = [_wide(each) for each in (stiffness, forces, *values, *known, root)]
    out = np.empty(arrays[1].shape)
    _run(_residual(), [*rows[:2], *rows.numbers, *arrays, out], len(stiffness), size, int(given is not None))
    return out[:, :count]


def added(values: DoubleDouble, change: Array, root: Array, *, overwrite: bool = False) -> tuple[DoubleDouble, Array]:
    """The sums ``values + root change``, all (unknowns, m).

    With `overwrite` the sums may overwrite the values.

    Returns
    -------
    tuple
        The sums; and the greatest magnitude of the changes in each column, (m,), NaN where one is NaN.
    """
    size, count = change.shape
    arrays = [_wide(each) for each in (*values, change, root)]
    large, small, greatest = *arrays[:2], np.empty((1, max(count, WIDTH)))
    if not overwrite or count % WIDTH:
        large, small = np.empty_like(large), np.empty_like(small)
    _run(_addition(), [*arrays, large, small, greatest], 0, size, 0)
    return DoubleDouble(large[:, :count], small[:, :count]), greatest[0, :count]


def _wide(array: Array) -> Array:
    """An array in row-major order, padded with zeros to at least the width of a vector."""
    others = WIDTH - array.shape[1]
    return np.ascontiguousarray(np.pad(array, ((0, 0), (0, others))) if others > 0 else array)


def _run(function: Callable[..., None], arrays: list[NDArray[Any]], springs: int, size: int, given: int) -> None:
    table = np.array([each.ctypes.data for each in arrays])
    function(table.ctypes.data, springs, size, arrays[-1].shape[1], given)


@cache
def _residual() -> Callable[..., None]:
    return compiled_kernel(_Residual().whole())


@cache
def _addition() -> Callable[..., None]:
    return compiled_kernel(_Addition().whole())


class EntryLoops(LoopText, ABC):
    """LLVM code of a function on arrays whose addresses are in a table, for a vector of entries at a time."""

    arrays: tuple[str, ...] = ()

    def whole(self) -> str:
        """All of it."""
        self._lines = [
            f"declare {_V} @llvm.fma.v{WIDTH}f64({_V}, {_V}, {_V})",
            *(f"declare {_V} @llvm.{name}.v{WIDTH}f64({_V})" for name in ("fabs", "sqrt")),
            "define void @run(ptr %table, i64 %springs, i64 %size, i64 %count, i64 %given) {",
            "entry:",
            f"  %vectors = add i64 %count, {WIDTH - 1}",
            f"  %blocks = sdiv i64 %vectors, {WIDTH}",
            f"  %most = sub i64 %count, {WIDTH}",
        ]
        self._at = {name: self._pointer(str(k)) for k, name in enumerate(self.arrays)}
        self._loop("0", "%blocks", self._vector_of_entries)
        return "\n".join([*self._lines, "  ret void", "}"])

    def _vector_of_entries(self, block: str) -> None:
        """The entries of a block; the last block overlaps the one before, and repeats some entries."""
        first = self._int("mul", block, str(WIDTH))
        beyond = self._value("b", f"icmp slt i64 %most, {first}")
        self._entries(self._value("n", f"select i1 {beyond}, i64 %most, i64 {first}"))

    @abstractmethod
    def _entries(self, first: str) -> None:
        """What is done for the entries from the `first` on that a vector holds."""

    # -- how it is written --------------------------------------------------------------------------------------------

    def _fused(self, a: str, b: str, c: str) -> str:
        return self._vector(f"call {_V} @llvm.fma.v{WIDTH}f64({_V} {a}, {_V} {b}, {_V} {c})")

    def _sum(self, a: str, b: str) -> tuple[str, str]:
        """A sum, and its rounding error."""
        whole = self._two("fadd", a, b)
        taken = self._two("fsub", whole, a)
        lost = self._two("fsub", a, self._two("fsub", whole, taken))
        return whole, self._two("fadd", lost, self._two("fsub", b, taken))

    def _number(self, kind: str, name: str, at: str) -> str:
        place = self._value("p", f"getelementptr {kind}, ptr {self._at[name]}, i64 {at}")
        return self._value("x", f"load {kind}, ptr {place}")

    def _whole(self, name: str, at: str) -> str:
        return self._number("i64", name, at)

    def _every(self, name: str, at: str) -> str:
        """A vector with one number in all lanes."""
        one = self._vector(f"insertelement {_V} poison, double {self._number('double', name, at)}, i64 0")
        return self._vector(f"shufflevector {_V} {one}, {_V} poison, <{WIDTH} x i32> zeroinitializer")

    def _lane(self, name: str, at: str) -> str:
        place = self._value("p", f"getelementptr double, ptr {self._at[name]}, i64 {at}")
        return self._vector(f"load {_V}, ptr {place}, align 8")

    def _store_lane(self, name: str, at: str, value: str) -> None:
        place = self._value("p", f"getelementptr double, ptr {self._at[name]}, i64 {at}")
        self._lines.append(f"  store {_V} {value}, ptr {place}, align 8")

    def _row(self, row: str, first: str) -> str:
        return self._int("add", self._int("mul", row, "%count"), first)


class SpringLoops(EntryLoops):
    """LLVM code of the forces of springs under displacements `u` and `v` in double-double precision.

    Deformations are in the arrays `start`, `column`, `large` and `small`, see `Rows`; forces are added to `out`.
    """

    def _spring(self, spring: str, place: Place) -> None:
        """Add the forces of one spring; `place` tells where the row of an array lies."""
        start, stop = self._whole("start", spring), self._whole("start", self._int("add", spring, "1"))

        def add(k: str, sums: list[str]) -> list[str]:
            at = place("u", self._whole("column", k))
            share, rest = self._every("large", k), self._every("small", k)
            large, small = self._lane("u", at), self._lane("v", at)
            product = self._two("fmul", share, large)
            left = self._fused(share, large, self._vector(f"fneg {_V} {product}"))
            left = self._fused(rest, large, self._fused(share, small, left))
            whole, lost = self._sum(sums[0], product)
            return [whole, self._two("fadd", sums[1], self._two("fadd", lost, left))]

        large, small = self._carried(start, stop, self._given(spring, place), add)
        tension = self._two(
            "fmul", self._two("fadd", large, small), self._lane("stiffness", place("stiffness", spring))
        )

        def back(k: str) -> None:
            at = place("out", self._whole("column", k))
            taken = self._two("fmul", self._every("large", k), tension)
            self._store_lane("out", at, self._two("fadd", self._lane("out", at), taken))

        self._loop(start, stop, back)

    def _given(self, spring: str, place: Place) -> list[str]:
        """Prescribed deformations of a spring, in double-double precision."""
        return ["zeroinitializer"] * 2


class _Residual(SpringLoops):
    """LLVM code of `unbalanced`."""

    arrays = ("start", "column", "large", "small", "stiffness", "forces", "u", "v", "g", "h", "root", "out")

    def _entries(self, first: str) -> None:
        def leave(row: str) -> None:
            at = self._row(row, first)
            left = self._two("fsub", self._lane("forces", at), self._lane("out", at))
            self._store_lane("out", at, self._two("fmul", left, self._lane("root", at)))

        self._loop("0", "%size", lambda row: self._store_lane("out", self._row(row, first), "zeroinitializer"))
        self._loop("0", "%springs", lambda spring: self._spring(spring, lambda name, row: self._row(row, first)))
        self._loop("0", "%size", leave)

    def _given(self, spring: str, place: Place) -> list[str]:
        # without prescribed deformations the first row is read, which is zero
        at = self._int("mul", place("g", spring), "%given")
        return [self._lane("g", at), self._lane("h", at)]


class _Addition(EntryLoops):
    """LLVM code of `added`."""

    arrays = ("large", "small", "change", "root", "whole", "rest", "greatest")

    def _entries(self, first: str) -> None:
        def one(row: str, found: list[str]) -> list[str]:
            at = self._row(row, first)
            scaled, large = self._lane("change", at), self._lane("large", at)
            change = self._two("fmul", scaled, self._lane("root", at))
            whole, lost = self._sum(large, change)
            self._store_lane("whole", at, whole)
            self._store_lane("rest", at, self._two("fadd", lost, self._lane("small", at)))
            size = self._vector(f"call {_V} @llvm.fabs.v{WIDTH}f64({_V} {scaled})")
            more = self._value("b", f"fcmp ogt {_V} {size}, {found[0]}")
            greatest = self._vector(f"select <{WIDTH} x i1> {more}, {_V} {size}, {_V} {found[0]}")
            unknown = self._value("b", f"fcmp uno {_V} {scaled}, {scaled}")
            return [greatest, self._vector(f"select <{WIDTH} x i1> {unknown}, {_V} {scaled}, {_V} {found[1]}")]

        found = self._carried("0", "%size", ["zeroinitializer"] * 2, one)
        self._store_lane("greatest", first, self._two("fadd", *found))
