"""Moments and extremes of blocks of samples as machine code: each sample is read from memory once.

NumPy reads the samples once for each of seven statistics. Here a block is summed, and powers of its deviations from the
mean are summed while it lies in the first-level cache. Sums are taken pairwise in the order of `numpy.add.reduce`, so
that the bits are the same. Needs the extra ``fast``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import cache, reduce

import numpy as np
from numpy.typing import NDArray

from ...framework.program.loop_text import VECTOR as _V
from ...framework.program.loop_text import LoopText
from ...framework.program.machine_code import available, compiled_kernel
from ...framework.program.machine_text import WIDTH
from ..sampling import BLOCK

Array = NDArray[np.float64]

# Number of statistics: least, greatest, number, mean, and sums of the second, third and fourth powers of the
# deviations.
NUMBERS = 7
# Samples that NumPy adds to eight partial sums before it adds these pairwise (N. J. Higham, SIAM J. Sci. Comput. 14,
# 1993, doi:10.1137/0914050); a block has as many such leaves as a register has lanes.
LEAF = 16 * WIDTH
# Number of samples from which on it pays to load llvmlite, if it is not loaded yet.
WORTH = 1 << 20

_ZERO = "zeroinitializer"


def serves(numbers: int) -> bool:
    """Whether machine code is available and pays for so many samples."""
    return (numbers >= WORTH or "llvmlite.binding" in sys.modules) and available() and LEAF * WIDTH == BLOCK


def numbers_of_blocks(rows: Array) -> Array:
    """Extremes and moments of samples.

    Parameters
    ----------
    rows
        Samples (e, b, `BLOCK`), each block contiguous in memory.

    Returns
    -------
    array
        Least, greatest, number of samples, mean, and sums of (x − mean)², (x − mean)³, (x − mean)⁴, (7, e, b); those
        that `Moments.of_rows` finds where the mean is not NaN.
    """
    assert rows.shape[-1] == BLOCK
    assert rows.strides[1:] == (BLOCK * rows.itemsize, rows.itemsize)
    entries, blocks, _ = rows.shape
    found = np.empty((entries, blocks, NUMBERS))
    first = [array.ctypes.data + array.strides[0] * np.arange(entries) for array in (rows, found)]
    table = np.ascontiguousarray(np.stack(first, axis=1))
    _function()(table.ctypes.data, entries, blocks, 0, 0)
    return found.transpose(2, 0, 1)


@cache
def _function() -> Callable[..., None]:
    return compiled_kernel(_BlockText().whole())


class _BlockText(LoopText):
    """The function as LLVM's text: for each row and each of its blocks, two loops over the leaves."""

    def whole(self) -> str:
        """The whole text."""
        self._lines = ["define void @run(ptr %table, i64 %rows, i64 %blocks, i64 %0, i64 %1) {", "entry:"]
        self._loop("0", "%rows", self._row)
        return "\n".join([*self._lines, "  ret void", "}"])

    def _row(self, row: str) -> None:
        pair = self._int("mul", row, "2")
        samples, numbers = self._pointer(pair), self._pointer(self._int("add", pair, "1"))
        self._loop("0", "%blocks", lambda k: self._of_block(self._at(samples, k, BLOCK), self._at(numbers, k, NUMBERS)))

    def _of_block(self, samples: str, numbers: str) -> None:
        first = self._load(samples, "0")
        sums, least, greatest = self._leaves(samples, [_ZERO, first, first], self._summed_leaf)
        mean = self._value("x", f"fdiv double {self._paired(sums)}, {float(BLOCK)!r}")
        one = self._vector(f"insertelement {_V} {_ZERO}, double {mean}, i64 0")
        means = self._vector(f"shufflevector {_V} {one}, {_V} poison, <{WIDTH} x i32> zeroinitializer")
        powers = self._leaves(samples, [_ZERO] * 3, lambda *leaf: self._powers(means, *leaf))
        extremes = self._extreme(least, "olt"), self._extreme(greatest, "ogt")
        for k, number in enumerate((*extremes, f"{float(BLOCK)!r}", mean, *map(self._paired, powers))):
            self._lines.append(f"  store double {number}, ptr {self._at(numbers, str(k))}")

    def _leaves(
        self, samples: str, first: list[str], body: Callable[[Iterator[str], str, list[str]], list[str]]
    ) -> list[str]:
        """Vectors that a loop over the leaves of a block carries from one leaf to the next."""

        def leaf(number: str, before: list[str]) -> list[str]:
            return body(self._samples(self._at(samples, number, LEAF)), number, before)

        return self._carried("0", str(WIDTH), first, leaf)

    def _summed_leaf(self, samples: Iterator[str], leaf: str, before: list[str]) -> list[str]:
        sums, least, greatest = before
        eight = ""
        for x in samples:
            eight = self._two("fadd", eight, x) if eight else x
            least, greatest = self._closer(_V, "olt", least, x), self._closer(_V, "ogt", greatest, x)
        return [self._with(sums, eight, leaf), least, greatest]

    def _powers(self, means: str, samples: Iterator[str], leaf: str, before: list[str]) -> list[str]:
        eights: list[str] = []
        for x in samples:
            off = self._two("fsub", x, means)
            square = self._two("fmul", off, off)
            powers = [square, self._two("fmul", off, square), self._two("fmul", square, square)]
            eights = [self._two("fadd", a, b) for a, b in zip(eights, powers, strict=True)] if eights else powers
        return [self._with(sums, eight, leaf) for sums, eight in zip(before, eights, strict=True)]

    def _samples(self, leaf: str) -> Iterator[str]:
        """The samples of a leaf, a vector at a time."""
        return (self._load(leaf, str(k)) for k in range(LEAF // WIDTH))

    def _with(self, sums: str, eight: str, leaf: str) -> str:
        """The vector of the leaves' sums with that of one leaf inserted."""
        return self._vector(f"insertelement {_V} {sums}, double {self._paired(eight)}, i64 {leaf}")

    def _paired(self, vector: str) -> str:
        """Pairwise sum of the numbers of a vector."""
        size = WIDTH
        while size > 1:
            size //= 2
            even, odd = (
                self._vector(
                    f"shufflevector <{2 * size} x double> {vector}, <{2 * size} x double> poison, <{size} x i32> "
                    f"<{', '.join(f'i32 {k}' for k in range(start, 2 * size, 2))}>"
                )
                for start in (0, 1)
            )
            vector = self._vector(f"fadd <{size} x double> {even}, {odd}")
        return self._value("x", f"extractelement <1 x double> {vector}, i64 0")

    def _extreme(self, vector: str, less: str) -> str:
        lanes = [self._value("x", f"extractelement {_V} {vector}, i64 {k}") for k in range(WIDTH)]
        return reduce(lambda a, b: self._closer("double", less, a, b), lanes)

    def _closer(self, kind: str, less: str, a: str, b: str) -> str:
        """The lesser of two numbers, or the greater, by the comparison `less`."""
        chosen = self._value("b", f"fcmp {less} {kind} {b}, {a}")
        bits = f"<{WIDTH} x i1>" if kind == _V else "i1"
        return self._vector(f"select {bits} {chosen}, {kind} {b}, {kind} {a}")

    def _at(self, base: str, number: str, size: int = 1) -> str:
        """Address of part `number` of an array with parts of `size` numbers."""
        return self._value("p", f"getelementptr [{size} x double], ptr {base}, i64 {number}")
