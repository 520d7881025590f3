"""Unbalanced loads of many batch entries in pairs of double numbers, some entries abreast, as machine code.

A pair is a sum of which the second number is below the rounding of the first, so that it carries twice the digits.
Products and sums without loss are Dekker's and Knuth's (Ogita, Rump & Oishi, Accurate Sum and Dot Product, SIAM J. Sci.
Comput. 26(6), 2005, Algorithms 3.1, 3.5 and 5.3), with fused operations. They take a tenth of the time that extended
precision does, which no vector unit has. Needs the extra ``fast``.
"""

from __future__ import annotations

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


class Pair(NamedTuple):
    """Numbers as sums of two."""

    large: Array
    small: Array

    @classmethod
    def of(cls, numbers: NDArray[Any]) -> Pair:
        """Numbers in extended precision, none of whose digits is lost."""
        large = numbers.astype(np.float64)
        return cls(large, (numbers - large).astype(np.float64))

    @property
    def rounded(self) -> Array:
        """In double precision."""
        return self.large + self.small

    def plus(self, change: Array) -> Pair:
        """The sum with other numbers."""
        whole = self.large + change
        taken = whole - self.large
        left = (self.large - (whole - taken)) + (change - taken)
        left += self.small
        return Pair(whole, left)


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
    numbers: Pair

    @classmethod
    def of(cls, matrix: scipy.sparse.csr_matrix) -> Rows:
        """Those of a matrix in extended precision."""
        return cls(matrix.indptr.astype(np.int64), matrix.indices.astype(np.int64), Pair.of(matrix.data))


def unbalanced(rows: Rows, given: Pair | None, stiffness: Array, forces: Array, values: Pair) -> Array:
    """What forces leave of ``A^T k (A u + g)``: A u in pairs, and all else in double precision.

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

    Returns
    -------
    ndarray
        (unknowns, m).
    """
    count = forces.shape[1]
    others = max(0, WIDTH - count)
    known = (np.zeros((1, max(count, WIDTH))),) * 2 if given is None else given
    arrays = [np.ascontiguousarray(np.pad(each, ((0, 0), (0, others))) if others else each)
              for each in (stiffness, forces, *values, *known)]  # fmt: skip
    out = np.empty(arrays[1].shape)
    table = np.array([each.ctypes.data for each in (*rows[:2], *rows.numbers, *arrays, out)])
    _function()(table.ctypes.data, len(stiffness), len(forces), count + others, int(given is not None))
    return out[:, :count] if others else out


@cache
def _function() -> Callable[..., None]:
    return compiled_kernel(_Text().whole())


class _Text(LoopText):
    """The function as the text that LLVM reads."""

    def whole(self) -> str:
        """All of it."""
        self._lines = [
            f"declare {_V} @llvm.fma.v{WIDTH}f64({_V}, {_V}, {_V})",
            "define void @run(ptr %table, i64 %springs, i64 %size, i64 %count, i64 %given) {",
            "entry:",
            f"  %vectors = add i64 %count, {WIDTH - 1}",
            f"  %blocks = sdiv i64 %vectors, {WIDTH}",
            f"  %most = sub i64 %count, {WIDTH}",
        ]
        names = ("start", "column", "large", "small", "stiffness", "forces", "u", "v", "g", "h", "out")
        self._at = {name: self._pointer(str(k)) for k, name in enumerate(names)}
        self._loop("0", "%blocks", self._entries)
        return "\n".join([*self._lines, "  ret void", "}"])

    def _entries(self, block: str) -> None:
        """Some entries; the last ones overlap those before."""
        first = self._int("mul", block, str(WIDTH))
        last = self._value("b", f"icmp slt i64 %most, {first}")
        first = self._value("n", f"select i1 {last}, i64 %most, i64 {first}")
        zero = "zeroinitializer"

        def place(row: str) -> str:
            return self._int("add", self._int("mul", row, "%count"), first)

        def leave(row: str) -> None:
            at = place(row)
            left = f"fsub {_V} {self._lane('forces', at)}, {self._lane('out', at)}"
            self._store_lane("out", at, self._vector(left))

        self._loop("0", "%size", lambda row: self._store_lane("out", place(row), zero))
        self._loop("0", "%springs", lambda spring: self._spring(spring, place))
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
            whole = self._two("fadd", sums[0], product)
            taken = self._two("fsub", whole, sums[0])
            lost = self._two("fsub", sums[0], self._two("fsub", whole, taken))
            lost = self._two("fadd", lost, self._two("fsub", product, taken))
            return [whole, self._two("fadd", sums[1], self._two("fadd", lost, left))]

        large, small = self._carried(start, stop, begin, add)
        tension = self._two("fmul", self._two("fadd", large, small), self._lane("stiffness", place(spring)))

        def back(k: str) -> None:
            at = place(self._whole("column", k))
            taken = self._two("fmul", self._every("large", k), tension)
            self._store_lane("out", at, self._two("fadd", self._lane("out", at), taken))

        self._loop(start, stop, back)

    # -- how it is written --------------------------------------------------------------------------------------------

    def _two(self, operation: str, a: str, b: str) -> str:
        return self._vector(f"{operation} {_V} {a}, {b}")

    def _fused(self, a: str, b: str, c: str) -> str:
        return self._vector(f"call {_V} @llvm.fma.v{WIDTH}f64({_V} {a}, {_V} {b}, {_V} {c})")

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
