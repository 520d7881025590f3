"""A program as machine code: straight-line arithmetic on a few batch entries at a time, in registers.

The steps become a loop body in LLVM code, which llvmlite (extra ``fast``) compiles in some 35 µs a step. LLVM is not
permitted to change the arithmetic: each step is rounded as by NumPy, and gives the same bits. Only linear combinations
use fused operations where the processor has them; NumPy's matrix product does so too, but may add in another order. For
n terms the two differ by at most 2 n roundings of the sum of the terms' magnitudes.
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
    """Whether this processor can run a program: sines need fused operations."""
    return not any(step.operation in SINES for step in program.steps) or fused()


@cache
def fused() -> bool:
    """Whether this processor has fused multiply-add operations."""
    import llvmlite.binding as llvm

    return bool(llvm.get_host_cpu_features().get("fma")) or platform.machine().lower() in ("aarch64", "arm64")


class Kernel:
    """The compiled steps of a program that vary over all its axes.

    It is called with a table of memory addresses, (rows, 1 + values): for each row of the batch along its last axis,
    that of a contiguous array of the values that are the `same` along the row, and that of each of `values`.

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
        Numbers of the other values that are read, tables included, followed by those of the values that are written.
    read
        How many of `values` are read.
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
        """The kernel of a program, cached for all frames of the same structure."""
        kernel: Kernel = KERNELS.found(("kernel", program, axis), lambda: Kernel(program, axis), len(program.steps))
        return kernel

    def run(self, addresses: Addresses, length: int, workers: int = 1, held: object = None) -> None:
        """Run the kernel for all rows of a batch with this `length` along its last axis, at least `WIDTH`.

        Worker threads keep a reference to `held`, the arrays, until they are done, in case the caller is interrupted.
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
    """A pool of `count` threads, one for each process, as a forked process does not inherit threads."""
    return ThreadPoolExecutor(count, "linkframe")


# -- LLVM ------------------------------------------------------------------------------------------------------------


def _machine(cpu: str, features: str) -> Any:
    """LLVM's target machine for this processor; each engine needs one of its own, which it takes over."""
    import llvmlite.binding as llvm

    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    return llvm.Target.from_default_triple().create_target_machine(cpu=cpu, features=features, opt=2)


def compiled_kernel(text: str) -> Callable[..., None]:
    """The compiled function ``run`` of some LLVM code, with a pointer to pointers and four integers as arguments."""
    whole = ctypes.c_int64
    found: Callable[..., None] = compiled(text, ctypes.CFUNCTYPE(None, ctypes.c_void_p, whole, whole, whole, whole))
    return found


def compiled(text: str, kind: Any) -> Any:
    """The compiled function ``run`` of some LLVM code, from the cache on disk if it was compiled before.

    Parameters
    ----------
    text
        The LLVM code.
    kind
        The ctypes type of the function.

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
