"""A program as machine code: straight-line arithmetic on a few batch entries at a time, all of it in registers.

The list is written as a loop body for LLVM, which llvmlite brings (extra ``fast``), and compiled in some 35 µs a
step. LLVM is given no leave to change the arithmetic: each step is rounded as NumPy rounds it, and gives the same
bits. Sums of products alone use fused operations where the processor has them; NumPy's matrix product does so too, but
may add in another order. Of n terms they differ by no more than 2 n roundings of the sum of their magnitudes.
"""

from __future__ import annotations

import ctypes
import os
import struct
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cache import KERNELS
from .program import Operation, Program, ProgramStep

# Batch entries in a register; LLVM splits it where the processor's are shorter.
WIDTH = 8
_V = f"<{WIDTH} x double>"
_NAMES = {
    Operation.ADD: "fadd",
    Operation.SUBTRACT: "fsub",
    Operation.MULTIPLY: "fmul",
    Operation.DIVIDE: "fdiv",
}
_BELOW = {Operation.MINIMUM: "olt", Operation.MAXIMUM: "ogt"}
_lock = Lock()

Addresses = NDArray[np.int64]


@cache
def available() -> bool:
    """Whether llvmlite is installed."""
    return find_spec("llvmlite") is not None


class Kernel:
    """The steps of a program that vary over all its axes, compiled.

    It takes a table of addresses, (rows, values): where in memory, for each row of the batch along its last axis, each
    of `values` begins. What does not vary along that axis is one number a row.

    Parameters
    ----------
    program
        The program.
    axis
        The last axis over which it varies.

    Attributes
    ----------
    values
        Numbers of the values that are read, and after them of those that are written.
    """

    def __init__(self, program: Program, axis: int) -> None:
        steps = program.made(program.widest)
        made = {program.first + k for k in steps}
        read = sorted({k for at in steps for k in program.steps[at].operands} - made)
        constants = range(program.given, program.first)
        written = [k for k in dict.fromkeys(program.outputs) if k in made]
        self.read = [k for k in read if k not in constants]
        self.values = [*self.read, *written]
        self.along = [bool(program.masks[k] >> axis & 1) for k in self.read]
        self._function = _compiled("\n".join(_text(program, steps, self.read, self.along, written)))

    @staticmethod
    def of(program: Program, axis: int) -> Kernel:
        """The kernel of a program; frames of the same structure have it in common."""
        kernel: Kernel = KERNELS.found(("kernel", program, axis), lambda: Kernel(program, axis), len(program.steps))
        return kernel

    def run(self, addresses: Addresses, length: int, workers: int = 1) -> None:
        """Work through the rows of a batch of this `length` along its last axis, which is at least `WIDTH`."""
        rows, table = len(addresses), addresses.ctypes.data
        pieces = min(workers, max(rows, length // (4 * WIDTH)))
        if pieces <= 1:
            self._function(table, 0, rows, 0, length)
            return
        cut = np.linspace(0, rows if rows >= pieces else length, pieces + 1).astype(int).tolist()
        parts = [(a, b, 0, length) if rows >= pieces else (0, rows, a, b) for a, b in pairwise(cut)]
        others = [_threads(pieces - 1, os.getpid()).submit(self._function, table, *part) for part in parts[1:]]
        self._function(table, *parts[0])
        for other in others:
            other.result()


@cache
def _threads(count: int, process: int) -> ThreadPoolExecutor:
    """So many threads beside the one that asks; a process that was forked off has its own."""
    return ThreadPoolExecutor(count, "linkframe")


# -- the text that LLVM reads ------------------------------------------------------------------------------------------


def _text(
    program: Program, steps: Sequence[int], read: Sequence[int], along: Sequence[bool], written: Sequence[int]
) -> Iterator[str]:
    """A loop over rows, in it one over `WIDTH` entries at a time; the last go back so far that they are as many."""
    width = len(read) + len(written)
    yield f"declare {_V} @llvm.fmuladd.v{WIDTH}f64({_V}, {_V}, {_V})"
    yield "define void @run(ptr noalias %table, i64 %first, i64 %last, i64 %start, i64 %stop) {"
    yield "entry:\n  %most = sub i64 %stop, " + f"{WIDTH}\n  br label %row"
    yield "row:\n  %r = phi i64 [%first, %entry], [%r1, %done]"
    yield f"  %at = mul i64 %r, {width}\n  %line = getelementptr ptr, ptr %table, i64 %at"
    for place, k in enumerate([*read, *written]):
        yield f"  %l{place} = getelementptr ptr, ptr %line, i64 {place}\n  %p{k} = load ptr, ptr %l{place}"
    for k, varies in zip(read, along, strict=True):
        if not varies:
            yield f"  %s{k} = load double, ptr %p{k}"
            yield f"  %e{k} = insertelement {_V} poison, double %s{k}, i64 0"
            yield f"  %v{k} = shufflevector {_V} %e{k}, {_V} poison, <{WIDTH} x i32> zeroinitializer"
    yield "  br label %entries\nentries:\n  %j = phi i64 [%start, %row], [%j1, %entries]"
    for k, varies in zip(read, along, strict=True):
        if varies:
            yield f"  %a{k} = getelementptr double, ptr %p{k}, i64 %j\n  %v{k} = load {_V}, ptr %a{k}, align 8"
    for at in steps:
        yield from _step(program, program.first + at, program.steps[at])
    for k in written:
        yield f"  %w{k} = getelementptr double, ptr %p{k}, i64 %j\n  store {_V} %v{k}, ptr %w{k}, align 8"
    yield f"  %j0 = add i64 %j, {WIDTH}\n  %over = icmp sge i64 %j0, %stop\n  %beyond = icmp sgt i64 %j0, %most"
    yield "  %j1 = select i1 %beyond, i64 %most, i64 %j0\n  br i1 %over, label %done, label %entries"
    yield "done:\n  %r1 = add i64 %r, 1\n  %all = icmp sge i64 %r1, %last\n  br i1 %all, label %end, label %row"
    yield "end:\n  ret void\n}"


def _step(program: Program, k: int, step: ProgramStep) -> Iterator[str]:
    a, *others = (_operand(program, each) for each in step.operands)
    if step.operation in _NAMES:
        yield f"  %v{k} = {_NAMES[step.operation]} {_V} {a}, {others[0]}"
    elif step.operation == Operation.NEGATE:
        yield f"  %v{k} = fneg {_V} {a}"
    elif step.operation == Operation.MULTIPLY_ADD:
        b, c = others
        yield f"  %v{k} = call {_V} @llvm.fmuladd.v{WIDTH}f64({_V} {a}, {_V} {b}, {_V} {c})"
    else:
        # As NumPy's: NaN where one of them is.
        yield f"  %b{k} = fcmp {_BELOW[step.operation]} {_V} {a}, {others[0]}\n  %n{k} = fcmp uno {_V} {a}, {a}"
        yield f"  %c{k} = or <{WIDTH} x i1> %b{k}, %n{k}"
        yield f"  %v{k} = select <{WIDTH} x i1> %c{k}, {_V} {a}, {_V} {others[0]}"


def _operand(program: Program, k: int) -> str:
    if not program.given <= k < program.first:
        return f"%v{k}"
    (bits,) = struct.unpack(">Q", struct.pack(">d", program.constants[k - program.given]))
    return f"splat (double 0x{bits:016X})"


# -- LLVM ------------------------------------------------------------------------------------------------------------


def _machine() -> Any:
    """This processor, as LLVM knows it; one for each engine, to which it belongs from then on."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
    return llvm.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=2)


def _compiled(text: str) -> Callable[..., None]:
    """The function."""
    import llvmlite.binding as llvm

    with _lock:
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text), _machine())
        engine.finalize_object()
        whole = ctypes.c_int64
        kind = ctypes.CFUNCTYPE(None, ctypes.c_void_p, whole, whole, whole, whole)
        found: Any = kind(engine.get_function_address("run"))
    found.engine = engine  # lives as long as the function
    return found  # type: ignore[no-any-return]
