"""The program of a short batch as machine code: a loop over its entries, in doubles and 80-bit extended precision."""

from __future__ import annotations

import ctypes
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..program import machine_code
from ..structure.parts import Extended, Value
from .entry_machine import constant_lines, kinds_of, load_lines, step_lines, store_lines
from .entry_steps import Step

_WIDE, _DOUBLE = "x86_fp80", "double"


class BatchMachineCode:
    """Both parts of the program of a short batch, compiled as one function.

    Numbers are identified by their place in the order: given numbers, constants, results of the shared steps, loads,
    results of the loaded steps.

    Parameters
    ----------
    given
        For each given number, whether it is converted to extended precision.
    constants
        Constants of the program.
    shared, loaded
        Steps that do not depend on the loads, and those that do.
    loads
        Number of loads.
    nodes, others
        Places of the results in double precision, and of those in extended precision.
    """

    def __init__(
        self,
        given: Sequence[bool],
        constants: Sequence[Value],
        shared: Sequence[Step],
        loads: int,
        loaded: Sequence[Step],
        nodes: Sequence[int],
        others: Sequence[int],
    ) -> None:
        begin = len(given) + len(constants)
        first = begin + len(shared)
        known = [*given, *(isinstance(value, np.longdouble) for value in constants)]
        made = [*kinds_of(known, shared), *(False for _ in range(loads))]
        wide = [*kinds_of(made, loaded)]
        self._nodes, self._others = len(nodes), len(others)
        self._wide = [wide[k] for k in others]
        narrow = [k for k, each in enumerate(given) if not each]
        lines = [
            "define void @run(ptr %table, ptr %loads, ptr %first, ptr %second, i64 %count) {",
            "entry:",
            *constant_lines(len(given), constants),
            "  br label %entries",
            "entries:",
            "  %i = phi i64 [0, %entry], [%next, %entries]",
            _row("a", "table", 8 * len(given)),
            _row("b", "loads", 8 * loads),
            _row("c", "first", 8 * len(nodes)),
            _row("d", "second", 16 * len(others)),
            *load_lines("a", _DOUBLE, {k: k for k in narrow}),
            *_widened("a", [k for k, each in enumerate(given) if each]),
            *load_lines("b", _DOUBLE, {first + k: k for k in range(loads)}),
            *step_lines(made, shared, begin),
            *step_lines(wide, loaded, first + loads),
            *store_lines("c", wide, nodes, _DOUBLE),
            *store_lines("d", wide, others, _WIDE),
            "  %next = add i64 %i, 1",
            "  %more = icmp slt i64 %next, %count",
            "  br i1 %more, label %entries, label %done",
            "done:",
            "  ret void",
            "}",
        ]
        address = ctypes.c_void_p
        kind = ctypes.CFUNCTYPE(None, address, address, address, address, ctypes.c_int64)
        self._function: Any = machine_code.compiled("\n".join(lines), kind)

    def run(self, given: Array, loads: Array) -> tuple[Array, NDArray[Any]]:
        """Results in double precision and in extended precision, (entries, n) each, of tables (entries, m)."""
        count = len(given)
        nodes, others = np.empty((count, self._nodes)), np.empty((count, self._others), dtype=Extended)
        self._function(*(array.ctypes.data for array in (given, loads, nodes, others)), count)
        return nodes, others


def _row(name: str, array: str, size: int) -> str:
    """LLVM code for the address of the row of an entry."""
    return f"  %o{name} = mul i64 %i, {size}\n  %{name} = getelementptr i8, ptr %{array}, i64 %o{name}"


def _widened(pointer: str, places: Iterable[int]) -> Iterator[str]:
    """LLVM code that loads doubles and converts them to extended precision."""
    for k in places:
        yield f"  %p{k} = getelementptr double, ptr %{pointer}, i64 {k}\n  %x{k} = load double, ptr %p{k}, align 8"
        yield f"  %v{k} = fpext {_DOUBLE} %x{k} to {_WIDE}"
