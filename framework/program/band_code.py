"""Cholesky factors of several banded matrices at a time, one matrix in each lane of the vector registers.

LAPACK factorises one matrix after the other, and for a narrow band its overhead for each column exceeds the arithmetic.
Here the same operations are done in the same order in all lanes, which do not affect each other (Golub & Van Loan,
*Matrix Computations*, 4th ed., 2013, sec. 4.3.5). It needs the extra ``fast``.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache

import numpy as np
from numpy.typing import NDArray

from .loop_text import VECTOR as _V
from .loop_text import LoopText
from .machine_code import compiled_kernel
from .machine_text import WIDTH

Array = NDArray[np.float64]
Index = NDArray[np.int64]


def factorise(bands: Array) -> None:
    """Overwrite matrices with their factors L of ``L L^T``; NaN from the first negative pivot on.

    Parameters
    ----------
    bands
        Entries on and below the diagonal, column by column, (groups, columns, width, `WIDTH`); the columns of the
        matrix are followed by `width` columns of zeros.
    """
    starts = _starts(bands, np.arange(len(bands)))
    _run(bands, np.stack([starts, starts], axis=1), 0)


def solve(bands: Array, numbers: Index, loads: Array) -> None:
    """Overwrite loads with solutions.

    Parameters
    ----------
    bands
        Factors, see `factorise`.
    numbers
        Numbers of the groups to solve for, (n,).
    loads
        Loads (columns, right-hand sides, n, `WIDTH`), zero in the columns that follow those of the matrix.
    """
    _, cases, count, _ = loads.shape
    of_bands, of_loads = _starts(bands, np.tile(numbers, cases)), _starts(loads[0, 0], np.arange(cases * count))
    _run(bands, np.stack([of_bands, of_loads], axis=1), cases * count)


def _starts(array: Array, numbers: Index) -> Index:
    """Memory addresses of items of an array along its first axis."""
    assert array.flags.c_contiguous
    return array.ctypes.data + array.strides[0] * numbers


def _run(bands: Array, starts: Index, row: int) -> None:
    """Factorise if `row` is 0, else solve; `row` is the number of vectors in a row of loads."""
    _, columns, width, _ = bands.shape
    table = np.ascontiguousarray(starts)
    _function()(table.ctypes.data, row, columns - width, width, len(starts))


@cache
def _function() -> Callable[..., None]:
    return compiled_kernel(_Text().whole())


class _Text(LoopText):
    """LLVM code of the function, which factorises if there are no right-hand sides and solves otherwise."""

    def whole(self) -> str:
        """All of it."""
        self._lines = [
            f"declare {_V} @llvm.sqrt.v{WIDTH}f64({_V})",
            "define void @run(ptr %table, i64 %row, i64 %size, i64 %width, i64 %groups) {",
            "entry:",
            "  %factorise = icmp eq i64 %row, 0",
            "  br i1 %factorise, label %factors, label %solutions",
        ]
        for name, body in (("factors", self._factor), ("solutions", self._solve)):
            self._lines.append(f"{name}:")
            self._block = name
            self._loop("0", "%groups", body)
            self._lines.append("  ret void")
        return "\n".join([*self._lines, "}"])

    # -- the algorithms -----------------------------------------------------------------------------------------------

    def _factor(self, group: str) -> None:
        band = self._pointer(self._int("mul", group, "2"))

        def column(j: str) -> None:
            first = self._int("mul", j, "%width")
            diagonal = self._vector(f"call {_V} @llvm.sqrt.v{WIDTH}f64({_V} {self._load(band, first)})")
            self._store(band, first, diagonal)
            self._loop("1", "%width", lambda i: self._divide(band, self._int("add", first, i), diagonal))
            self._loop("1", "%width", lambda i: self._subtract(band, first, i))

        self._loop("0", "%size", column)

    def _divide(self, base: str, at: str, by: str) -> None:
        self._store(base, at, self._two("fdiv", self._load(base, at), by))

    def _subtract(self, band: str, first: str, i: str) -> None:
        """Subtract the contribution of column `first` from the i-th column after it."""
        factor = self._load(band, self._int("add", first, i))
        other = self._int("sub", self._int("add", first, self._int("mul", i, "%width")), i)

        def row(k: str) -> None:
            taken = self._two("fmul", self._load(band, self._int("add", first, k)), factor)
            at = self._int("add", other, k)
            self._store(band, at, self._two("fsub", self._load(band, at), taken))

        self._loop(i, "%width", row)

    def _solve(self, group: str) -> None:
        pair = self._int("mul", group, "2")
        band, loads = self._pointer(pair), self._pointer(self._int("add", pair, "1"))

        def at(j: str) -> str:
            return self._int("mul", j, "%row")

        def forward(j: str) -> None:
            first = self._int("mul", j, "%width")
            self._divide(loads, at(j), self._load(band, first))
            found = self._load(loads, at(j))

            def row(i: str) -> None:
                taken = self._two("fmul", self._load(band, self._int("add", first, i)), found)
                below = at(self._int("add", j, i))
                self._store(loads, below, self._two("fsub", self._load(loads, below), taken))

            self._loop("1", "%width", row)

        def backward(k: str) -> None:
            j = self._int("sub", self._int("sub", "%size", "1"), k)
            first = self._int("mul", j, "%width")

            def row(i: str, left: list[str]) -> list[str]:
                known, share = self._load(loads, at(self._int("add", j, i))), self._int("add", first, i)
                taken = self._two("fmul", self._load(band, share), known)
                return [self._two("fsub", left[0], taken)]

            self._store(loads, at(j), self._carried("1", "%width", [self._load(loads, at(j))], row)[0])
            self._divide(loads, at(j), self._load(band, first))

        self._loop("0", "%size", forward)
        self._loop("0", "%size", backward)
