"""The program of a short batch as machine code: a loop over its entries, in doubles and 80-bit extended precision."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import count
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..program import machine_code
from ..structure.parts import Extended, Value
from .entry_machine import constant_lines, kinds_of, load_lines, step_line, store_line
from .entry_steps import Step

_WIDE, _DOUBLE = "x86_fp80", "double"


class BatchMachineCode:
    """Both parts of the program of a short batch, compiled as one function.

    Numbers are identified by their place in the order: given numbers, constants, results of the shared steps, loads,
    results of the loaded steps.

    Parameters
    ----------
    given
        By their column in the table of numbers: whether each given number is converted to extended precision.
    constants
        Constants of the program.
    shared, loaded
        Steps that do not depend on the loads, and those that do.
    loads
        Columns of the given loads in the table of loads.
    widths
        Columns of both tables.
    nodes, others
        Places of the results in double precision, and of those in extended precision.
    """

    def __init__(
        self,
        given: Mapping[int, bool],
        constants: Sequence[Value],
        shared: Sequence[Step],
        loads: Sequence[int],
        loaded: Sequence[Step],
        widths: tuple[int, int],
        nodes: Sequence[int],
        others: Sequence[int],
    ) -> None:
        begin = len(given) + len(constants)
        first = begin + len(shared)
        known = [*given.values(), *(isinstance(value, np.longdouble) for value in constants)]
        made = [*kinds_of(known, shared), *(False for _ in loads)]
        wide = [*kinds_of(made, loaded)]
        self._nodes, self._others = len(nodes), len(others)
        steps = {**dict(enumerate(shared, begin)), **dict(enumerate(loaded, first + len(loads)))}
        columns = dict(enumerate(given))
        entry = _Entry(steps, wide, {k: column for k, column in columns.items() if wide[k]})
        lines = [
            "define void @run(ptr %table, ptr %loads, ptr %first, ptr %second, i64 %count) {",
            "entry:",
            *constant_lines(len(given), constants),
            "  br label %entries",
            "entries:",
            "  %i = phi i64 [0, %entry], [%next, %entries]",
            _row("a", "table", 8 * widths[0]),
            _row("b", "loads", 8 * widths[1]),
            _row("c", "first", 8 * len(nodes)),
            _row("d", "second", 16 * len(others)),
            *load_lines("a", _DOUBLE, {k: column for k, column in columns.items() if not wide[k]}),
            *load_lines("b", _DOUBLE, {first + k: column for k, column in enumerate(loads)}),
            *entry.lines("d", others, _WIDE),
            *entry.lines("c", nodes, _DOUBLE),
            "  %next = add i64 %i, 1",
            "  %more = icmp slt i64 %next, %count",
            "  br i1 %more, label %entries, label %done",
            "done:",
            "  ret void",
            "}",
            f"declare {_DOUBLE} @llvm.sqrt.f64({_DOUBLE})",
        ]
        address = ctypes.c_void_p
        kind = ctypes.CFUNCTYPE(None, address, address, address, address, ctypes.c_int64)
        self._function: Any = machine_code.compiled("\n".join(lines), kind)

    def run(self, given: Array, loads: Array) -> tuple[Array, NDArray[Any]]:
        """Results in double precision and in extended precision, (entries, n) each, of tables (entries, m)."""
        size = len(given)
        nodes, others = np.empty((size, self._nodes)), np.empty((size, self._others), dtype=Extended)
        self._function(*[array.ctypes.data for array in (given, loads, nodes, others)], size)
        return nodes, others


def _row(name: str, array: str, size: int) -> str:
    """LLVM code for the address of the row of an entry."""
    return f"  %o{name} = mul i64 %i, {size}\n  %{name} = getelementptr i8, ptr %{array}, i64 %o{name}"


class _Entry:
    """LLVM code of the steps for an entry, each right before its result is first needed.

    The processor has eight places for numbers in extended precision, and what does not find one is written to memory
    and read again, which takes five times as long as an operation: in this order a third fewer are written. Given
    numbers are read as doubles wherever they are needed; as volatile ones, or LLVM would read each once and write it.

    Parameters
    ----------
    steps
        The steps by the place of their results.
    wide
        For each place, whether its number is in extended precision.
    widened
        Columns of the given numbers that are converted to extended precision, by their place.
    """

    def __init__(self, steps: Mapping[int, Step], wide: Sequence[bool], widened: Mapping[int, int]) -> None:
        self._steps, self._wide, self._widened = steps, wide, widened
        self._made: set[int] = set()
        self._fresh = count(len(wide))

    def lines(self, pointer: str, places: Iterable[int], kind: str) -> Iterator[str]:
        """LLVM code that computes the numbers at some places and stores them consecutively in one precision."""
        for n, place in enumerate(places):
            for k in self._missing(place):
                operation, a, b = self._steps[k]
                before, (first, second) = self._read(a, b)
                yield from before
                yield from step_line(_kind(self._wide[k]), (operation, first, second), k)
            before, (last,) = self._read(place)
            yield from before
            yield from store_line(pointer, n, last, _kind(self._wide[place]), kind)

    def _missing(self, place: int) -> Iterator[int]:
        """Places of the steps that have to be carried out before a number is there, in order."""
        waiting = [place]
        while waiting:
            k = waiting[-1]
            if k in self._made or k not in self._steps:
                waiting.pop()
                continue
            _, a, b = self._steps[k]
            before = [each for each in (b, a) if each in self._steps and each not in self._made]
            waiting += before
            if not before:
                self._made.add(k)
                yield k

    def _read(self, *places: int) -> tuple[list[str], list[int]]:
        """LLVM code that reads those of some numbers that are given, and the places at which all are then."""
        lines, found = [], []
        for k in places:
            found.append(next(self._fresh) if k in self._widened else k)
            if k in self._widened:
                lines.append(f"  %p{found[-1]} = getelementptr double, ptr %a, i64 {self._widened[k]}")
                lines.append(f"  %x{found[-1]} = load volatile {_DOUBLE}, ptr %p{found[-1]}, align 8")
                lines.append(f"  %v{found[-1]} = fpext {_DOUBLE} %x{found[-1]} to {_WIDE}")
        return lines, found


def _kind(wide: bool) -> str:
    return _WIDE if wide else _DOUBLE
