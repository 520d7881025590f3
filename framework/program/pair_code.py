"""Unbalanced loads of many batch entries in pairs of double numbers, some entries abreast, as machine code.

A pair, a double-double, is a sum of which the second number is below the rounding of the first, so that it carries
twice the digits. Products and sums without loss are Dekker's and Knuth's (Ogita, Rump & Oishi, Accurate Sum and Dot
Product, SIAM J. Sci. Comput. 26(6), 2005, Algorithms 3.1, 3.5 and 5.3), with fused operations. They take a tenth of the
time that extended precision does, which no vector unit has. Needs the extra ``fast``.
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


class DoubleDouble(NamedTuple):
    """Numbers as sums of two each."""

    large: Array
    small: Array

    @classmethod
    def of(cls, numbers: NDArray[Any]) -> DoubleDouble:
        """Numbers in extended precision, none of whose digits is lost."""
        large = numbers.astype(np.float64)
        return cls(large, (numbers - large).astype(np.float64))

    @property
    def rounded(self) -> Array:
        """In double precision."""
        return self.large + self.small


class Rows(NamedTuple):
    """A sparse matrix row by row.

    Attributes
    ----------
    start, column
        Where each row starts, and at last where they end; and the columns.
    numbers
        What there is.
    """

    start: NDArray[np.int64]
    column: NDArray[np.int64]
    numbers: DoubleDouble

    @classmethod
    def of(cls, matrix: scipy.sparse.csr_matrix) -> Rows:
        """Those of a matrix in extended precision."""
        return cls(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), DoubleDouble.of(matrix.data))


def unbalanced(
    rows: Rows, given: DoubleDouble | None, stiffness: Array, forces: Array, values: DoubleDouble, root: Array
) -> Array:
    """What forces leave of ``A^T k (A u + g)``, scaled: A u in pairs, and all else in double precision.

    Parameters
    ----------
    rows
        Deformations A of the springs by the unknowns.
    given
        Deformations g that there are in any case, (springs, m); None for none.
    stiffness
        That of the springs, (springs, m).
    forces
        (unknowns, m).
    values
        The unknowns u, (unknowns, m).
    root
        By what the loads that are left are multiplied, (unknowns, m).

    Returns
    -------
    ndarray
        (unknowns, m).
    """
    size, count = forces.shape
    known = (np.zeros((1, count)),) * 2 if given is None else given
    arrays = [_wide(each) for each in (stiffness, forces, *values, *known, root)]
    out = np.empty(arrays[1].shape)
    _run(_residual(), [*rows[:2], *rows.numbers, *arrays, out], len(stiffness), size, int(given is not None))
    return out[:, :count]


def added(values: DoubleDouble, change: Array, root: Array, *, overwrite: bool = False) -> tuple[DoubleDouble, Array]:
    """Values (unknowns, m) with scaled changes (unknowns, m) times their scale, (unknowns, m), added.

    Where told to, the sums may `overwrite` the values.

    Returns
    -------
    tuple
        The sums; and the greatest size of the scaled changes to each column, (m,), NaN where one is.
    """
    size, count = change.shape
    arrays = [_wide(each) for each in (*values, change, root)]
    large, small, greatest = *arrays[:2], np.empty((1, max(count, WIDTH)))
    if not overwrite or count % WIDTH:
        large, small = np.empty_like(large), np.empty_like(small)
    _run(_addition(), [*arrays, large, small, greatest], 0, size, 0)
    return DoubleDouble(large[:, :count], small[:, :count]), greatest[0, :count]


def _wide(array: Array) -> Array:
    """Row by row in memory, as wide as a vector at least."""
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


class _EntryLoops(LoopText, ABC):
    """A function of arrays in a table as the text that LLVM reads: some entries, and then others."""

    arrays: tuple[str, ...] = ()

    def whole(self) -> str:
        """All of it."""
        self._lines = [
            f"declare {_V} @llvm.fma.v{WIDTH}f64({_V}, {_V}, {_V})",
            f"declare {_V} @llvm.fabs.v{WIDTH}f64({_V})",
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
        """Entries of a block; those of the last one overlap the ones before, which gives the same once more."""
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
        """A sum, and what rounding takes of it."""
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
        """One number in all lanes."""
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


class _Residual(_EntryLoops):
    """Unbalanced loads."""

    arrays = ("start", "column", "large", "small", "stiffness", "forces", "u", "v", "g", "h", "root", "out")

    def _entries(self, first: str) -> None:
        def leave(row: str) -> None:
            at = self._row(row, first)
            left = self._two("fsub", self._lane("forces", at), self._lane("out", at))
            self._store_lane("out", at, self._two("fmul", left, self._lane("root", at)))

        self._loop("0", "%size", lambda row: self._store_lane("out", self._row(row, first), "zeroinitializer"))
        self._loop("0", "%springs", lambda spring: self._spring(spring, lambda row: self._row(row, first)))
        self._loop("0", "%size", leave)

    def _spring(self, spring: str, place: Callable[[str], str]) -> None:
        """What one spring takes of the forces."""
        start, stop = self._whole("start", spring), self._whole("start", self._int("add", spring, "1"))
        # where nothing is given the first numbers are read, which are zero
        at = self._int("mul", place(spring), "%given")
        begin = [self._lane("g", at), self._lane("h", at)]

        def add(k: str, sums: list[str]) -> list[str]:
            at = place(self._whole("column", k))
            share, rest = self._every("large", k), self._every("small", k)
            large, small = self._lane("u", at), self._lane("v", at)
            product = self._two("fmul", share, large)
            left = self._fused(share, large, self._vector(f"fneg {_V} {product}"))
            left = self._fused(rest, large, self._fused(share, small, left))
            whole, lost = self._sum(sums[0], product)
            return [whole, self._two("fadd", sums[1], self._two("fadd", lost, left))]

        large, small = self._carried(start, stop, begin, add)
        tension = self._two("fmul", self._two("fadd", large, small), self._lane("stiffness", place(spring)))

        def back(k: str) -> None:
            at = place(self._whole("column", k))
            taken = self._two("fmul", self._every("large", k), tension)
            self._store_lane("out", at, self._two("fadd", self._lane("out", at), taken))

        self._loop(start, stop, back)


class _Addition(_EntryLoops):
    """Values to which changes are added."""

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
