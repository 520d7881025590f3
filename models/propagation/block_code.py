"""Moments and extremes of blocks of samples as machine code: each sample is read from memory once.

NumPy goes through the samples once for each of seven numbers. Here a block is summed, and its deviations from the mean
are raised and summed while it lies in the processor's first cache. Sums are taken pair by pair in the order in which
`numpy.add.reduce` takes them, so that the bits are the same. Needs the extra ``fast``.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import cache, reduce
from itertools import count

import numpy as np
from numpy.typing import NDArray

from ...framework.program.machine_code import available, compiled_kernel
from ...framework.program.machine_text import WIDTH
from ..sampling import BLOCK

Array = NDArray[np.float64]

# Least, greatest, number, mean, and sums of the second, third and fourth powers of the deviations.
NUMBERS = 7
# Samples that NumPy adds to eight sums before it adds these in pairs (N. J. Higham, SIAM J. Sci. Comput. 14, 1993,
# doi:10.1137/0914050); a block has as many such leaves as a register has lanes.
LEAF = 16 * WIDTH
# Numbers from which on it pays to load llvmlite, where nothing has loaded it before.
WORTH = 1 << 20

_V, _ZERO = f"<{WIDTH} x double>", "zeroinitializer"


def serves(numbers: int) -> bool:
    """Whether machine code pays for so many numbers, and can be had."""
    return (numbers >= WORTH or "llvmlite.binding" in sys.modules) and available() and LEAF * WIDTH == BLOCK


def numbers_of_blocks(rows: Array) -> Array:
    """Extremes and moments of samples.

    Parameters
    ----------
    rows
        Samples (e, b, `BLOCK`), those of a block side by side in memory.

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


class _BlockText:
    """The function as the text that LLVM reads: for each row, for each of its blocks, two loops over the leaves."""

    def __init__(self) -> None:
        self._lines: list[str] = []
        self._names = count()

    def whole(self) -> str:
        """All of it."""
        self._write(
            "define void @run(ptr %table, i64 %rows, i64 %blocks, i64 %0, i64 %1) {",
            "entry:",
            "  br label %row",
            "row:",
            "  %r = phi i64 [0, %entry], [%r.next, %block.end]",
            "  %place = getelementptr [2 x ptr], ptr %table, i64 %r",
            "  %in = load ptr, ptr %place",
            "  %place.out = getelementptr ptr, ptr %place, i64 1",
            "  %out = load ptr, ptr %place.out",
            "  br label %block",
            "block:",
            "  %b = phi i64 [0, %row], [%b.next, %powers.end]",
            f"  %samples = getelementptr [{BLOCK} x double], ptr %in, i64 %b",
            f"  %numbers = getelementptr [{NUMBERS} x double], ptr %out, i64 %b",
            f"  %first = load {_V}, ptr %samples, align 8",
        )
        sums, least, greatest = self._leaves("sums", "block", (_ZERO, "%first", "%first"), self._summed_leaf)
        mean = self._value(f"fdiv double {self._paired(sums)}, {float(BLOCK)!r}")
        one = self._value(f"insertelement {_V} {_ZERO}, double {mean}, i64 0")
        self._write(f"  %mean = shufflevector {_V} {one}, {_V} poison, <{WIDTH} x i32> zeroinitializer")
        powers = self._leaves("powers", "sums.end", (_ZERO,) * 3, self._leaf_of_powers)
        extremes = self._extreme(least, "olt"), self._extreme(greatest, "ogt")
        for k, number in enumerate((*extremes, f"{float(BLOCK)!r}", mean, *map(self._paired, powers))):
            self._write(f"  store double {number}, ptr {self._value(f'getelementptr double, ptr %numbers, i64 {k}')}")
        self._end("b", "block", "%blocks")
        self._end("r", "row", "%rows")
        self._write("  ret void", "}")
        return "\n".join(self._lines)

    # -- what is done -------------------------------------------------------------------------------------------------

    def _summed_leaf(self, leaf: str, before: list[str]) -> list[str]:
        sums, least, greatest = before
        eight = ""
        for x in self._samples(leaf):
            eight = self._vector("fadd", eight, x) if eight else x
            least, greatest = self._closer(_V, "olt", least, x), self._closer(_V, "ogt", greatest, x)
        return [self._with(sums, eight, leaf), least, greatest]

    def _leaf_of_powers(self, leaf: str, before: list[str]) -> list[str]:
        eights: list[str] = []
        for x in self._samples(leaf):
            off = self._vector("fsub", x, "%mean")
            square = self._vector("fmul", off, off)
            powers = [square, self._vector("fmul", off, square), self._vector("fmul", square, square)]
            eights = [self._vector("fadd", a, b) for a, b in zip(eights, powers, strict=True)] if eights else powers
        return [self._with(sums, eight, leaf) for sums, eight in zip(before, eights, strict=True)]

    def _samples(self, leaf: str) -> Iterator[str]:
        """The samples of a leaf, some at a time."""
        start = self._value(f"getelementptr [{LEAF} x double], ptr %samples, i64 {leaf}")
        for k in range(LEAF // WIDTH):
            yield self._value(f"load {_V}, ptr {self._value(f'getelementptr {_V}, ptr {start}, i64 {k}')}, align 8")

    def _with(self, sums: str, eight: str, leaf: str) -> str:
        """The sums of the leaves with that of one more."""
        return self._value(f"insertelement {_V} {sums}, double {self._paired(eight)}, i64 {leaf}")

    def _paired(self, vector: str) -> str:
        """Sum of the numbers of a vector: neighbours first."""
        size = WIDTH
        while size > 1:
            size //= 2
            even, odd = (
                self._value(
                    f"shufflevector <{2 * size} x double> {vector}, <{2 * size} x double> poison, <{size} x i32> "
                    f"<{', '.join(f'i32 {k}' for k in range(start, 2 * size, 2))}>"
                )
                for start in (0, 1)
            )
            vector = self._value(f"fadd <{size} x double> {even}, {odd}")
        return self._value(f"extractelement <1 x double> {vector}, i64 0")

    def _extreme(self, vector: str, less: str) -> str:
        lanes = [self._value(f"extractelement {_V} {vector}, i64 {k}") for k in range(WIDTH)]
        return reduce(lambda a, b: self._closer("double", less, a, b), lanes)

    def _closer(self, kind: str, less: str, a: str, b: str) -> str:
        """The one of two numbers that is less, or greater."""
        chosen = self._value(f"fcmp {less} {kind} {b}, {a}")
        bits = f"<{WIDTH} x i1>" if kind == _V else "i1"
        return self._value(f"select {bits} {chosen}, {kind} {b}, {kind} {a}")

    # -- how it is written --------------------------------------------------------------------------------------------

    def _write(self, *lines: str) -> None:
        self._lines += lines

    def _value(self, line: str) -> str:
        name = f"%v{next(self._names)}"
        self._write(f"  {name} = {line}")
        return name

    def _vector(self, operation: str, a: str, b: str) -> str:
        return self._value(f"{operation} {_V} {a}, {b}")

    def _leaves(
        self, name: str, before: str, first: tuple[str, ...], body: Callable[[str, list[str]], list[str]]
    ) -> list[str]:
        """A loop over the leaves of a block that carries vectors from one to the next."""
        carried = [f"%{name}.{k}" for k in range(len(first))]
        number = f"  %{name}.k = phi i64 [0, %{before}], [%{name}.k.next, %{name}]"
        self._write(f"  br label %{name}", f"{name}:", number)
        at = len(self._lines)
        found = body(f"%{name}.k", carried)
        self._lines[at:at] = [
            f"  {old} = phi {_V} [{start}, %{before}], [{new}, %{name}]"
            for old, new, start in zip(carried, found, first, strict=True)
        ]
        self._end(f"{name}.k", name, str(WIDTH))
        return found

    def _end(self, number: str, label: str, stop: str) -> None:
        """The end of a loop."""
        self._write(
            f"  %{number}.next = add i64 %{number}, 1",
            f"  %{number}.more = icmp slt i64 %{number}.next, {stop}",
            f"  br i1 %{number}.more, label %{label}, label %{label}.end",
            f"{label}.end:",
        )
