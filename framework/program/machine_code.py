"""A program as machine code: straight-line arithmetic on a few batch entries at a time, all of it in registers.

The list is written as a loop body for LLVM, which llvmlite brings (extra ``fast``), and compiled in some 35 µs a
step. LLVM is given no leave to change the arithmetic: each step is rounded as NumPy rounds it, and gives the same
bits. Sums of products alone use fused operations where the processor has them; NumPy's matrix product does so too, but
may add in another order. Of n terms they differ by no more than 2 n roundings of the sum of their magnitudes.
"""

from __future__ import annotations

import ctypes
import os
import platform
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from importlib.util import find_spec
from itertools import pairwise
from threading import Lock
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..cache import KERNELS
from . import kept_code
from .machine_text import SINES, WIDTH, Text
from .program import Program

_lock = Lock()

Addresses = NDArray[np.int64]


@cache
def available() -> bool:
    """Whether llvmlite is installed."""
    return find_spec("llvmlite") is not None


def able(program: Program) -> bool:
    """Whether this processor has what a program takes: fused operations where there are sines."""
    return not any(step.operation in SINES for step in program.steps) or fused()


@cache
def fused() -> bool:
    """Whether this processor has fused operations."""
    import llvmlite.binding as llvm

    return bool(llvm.get_host_cpu_features().get("fma")) or platform.machine().lower() in ("aarch64", "arm64")


class Kernel:
    """The steps of a program that vary over all its axes, compiled.

    It takes a table of addresses, (rows, 1 + values): where in memory, for each row of the batch along its last axis,
    the numbers that are the `same` all along it lie beside each other, and where each of `values` begins.

    Parameters
    ----------
    program
        The program.
    axis
        The last axis over which it varies.

    Attributes
    ----------
    same
        Numbers of the values that are read and do not vary along that axis.
    values
        Numbers of the others that are read, tables among them, and after these of those that are written.
    read
        How many of these are read.
    """

    def __init__(self, program: Program, axis: int) -> None:
        steps = program.made(program.widest)
        made = {program.first + k for k in steps}
        needed = {k for at in steps for k in program.steps[at].operands}
        if program.rounds is not None:
            needed |= {program.rounds.again, *(after for _, after in program.rounds.carried)}
        read = sorted(needed - made)
        constants = range(program.given, program.first)
        written = [k for k in dict.fromkeys(program.outputs) if k in made]
        varies = {k: bool(program.masks[k] >> axis & 1) for k in read if k not in constants}
        self.same = [k for k in varies if not varies[k] and k not in program.tables]
        others = [k for k in varies if varies[k] or k in program.tables]
        self.values, self.read = [*others, *written], len(others)
        self._function = compiled_kernel("\n".join(Text(program, self.same, others, written).lines()))

    @staticmethod
    def of(program: Program, axis: int) -> Kernel:
        """The kernel of a program; frames of the same structure have it in common."""
        kernel: Kernel = KERNELS.found(("kernel", program, axis), lambda: Kernel(program, axis), len(program.steps))
        return kernel

    def run(self, addresses: Addresses, length: int, workers: int = 1, held: object = None) -> None:
        """Work through the rows of a batch of this `length` along its last axis, which is at least `WIDTH`.

        Other threads hold what is `held` until they are done: whoever asks may have been interrupted by then.
        """
        rows, table = len(addresses), addresses.ctypes.data
        pieces = min(workers, max(rows, length // (4 * WIDTH)))
        if pieces <= 1:
            self._function(table, 0, rows, 0, length)
            return
        cut = np.linspace(0, rows if rows >= pieces else length, pieces + 1).astype(int).tolist()
        parts = [(a, b, 0, length) if rows >= pieces else (0, rows, a, b) for a, b in pairwise(cut)]

        def work(part: tuple[int, int, int, int], *_: object) -> None:
            self._function(table, *part)

        others = [_threads(pieces - 1, os.getpid()).submit(work, part, addresses, held) for part in parts[1:]]
        work(parts[0])
        for other in others:
            other.result()


@cache
def _threads(count: int, process: int) -> ThreadPoolExecutor:
    """So many threads beside the one that asks; a process that was forked off has its own."""
    return ThreadPoolExecutor(count, "linkframe")


# -- LLVM ------------------------------------------------------------------------------------------------------------


def _machine(cpu: str, features: str) -> Any:
    """This processor, as LLVM knows it; one for each engine, to which it belongs from then on."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=2)


def compiled_kernel(text: str) -> Callable[..., None]:
    """The function ``run`` of a text that takes a pointer to pointers and four whole numbers."""
    whole = ctypes.c_int64
    found: Callable[..., None] = compiled(text, ctypes.CFUNCTYPE(None, ctypes.c_void_p, whole, whole, whole, whole))
    return found


def compiled(text: str, kind: Any) -> Any:
    """The function ``run`` of a text, from disk where it has been compiled before.

    Parameters
    ----------
    text
        What LLVM is to read.
    kind
        Type of the function, by ctypes.

    Returns
    -------
    callable
        The function.
    """
    import llvmlite.binding as llvm

    with _lock:
        cpu, features = llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten()
        version = ".".join(map(str, llvm.llvm_version_info))
        name = kept_code.key([text, llvmlite_version(), version, llvm.get_process_triple(), cpu, features])
        machine, content = _machine(cpu, features), kept_code.read(name)
        engine = llvm.create_mcjit_compiler(llvm.parse_assembly(text if content is None else ""), machine)
        if content is None:
            engine.set_object_cache(notify_func=lambda _, made: kept_code.write(name, made))
        else:
            engine.add_object_file(llvm.ObjectFileRef.from_data(content))
        engine.finalize_object()
        found: Any = kind(engine.get_function_address("run"))
    found.engine = engine  # lives as long as the function
    return found


@cache
def llvmlite_version() -> str:
    """Version of llvmlite."""
    import llvmlite

    return str(llvmlite.__version__)
