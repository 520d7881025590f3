"""The machine code that a solution runs, beside the same steps as a loop in C on the same arrays.

A C compiler is free to order the steps of a loop's body, and to keep in registers what it likes, so that its loop tells
what the processor makes of this arithmetic and this traffic to memory, on whatever machine both are run.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache, cached_property, partial
from pathlib import Path
from tempfile import TemporaryDirectory
from unittest.mock import patch

from linkframe.framework.cache import PROGRAMS
from linkframe.framework.program import calculation
from linkframe.framework.program.machine_code import Addresses, Kernel
from linkframe.framework.program.program import Operation, Program

from .harness import least_each

COMPILER = "cc"
FLAGS = ("-O3", "-march=native", "-fno-math-errno", "-ffp-contract=fast", "-shared", "-fPIC")
# Entries in a vector of the loop's body.
WIDTH = 8
FORMS = {
    Operation.ADD: "{0} + {1}",
    Operation.SUBTRACT: "{0} - {1}",
    Operation.MULTIPLY: "{0} * {1}",
    Operation.DIVIDE: "{0} / {1}",
    Operation.NEGATE: "-{0}",
    Operation.MINIMUM: "chosen({0} < {1}, {0}, {1})",
    Operation.MAXIMUM: "chosen({0} > {1}, {0}, {1})",
    Operation.MULTIPLY_ADD: "{0} * {1} + {2}",
    Operation.MULTIPLY_SUBTRACT: "{0} * {1} - {2}",
    Operation.SUBTRACT_PRODUCT: "{2} - {0} * {1}",
    Operation.SQUARE_ROOT: "root({0})",
}
HEAD = f"""
typedef double vector __attribute__((vector_size({8 * WIDTH}), aligned(8)));
typedef long mask __attribute__((vector_size({8 * WIDTH}), aligned(8)));
static inline vector chosen(mask which, vector a, vector b) {{
return (vector)(((mask)a & which) | ((mask)b & ~which));
}}
static inline vector root(vector a) {{
for (int k = 0; k < {WIDTH}; k++) a[k] = __builtin_sqrt(a[k]);
return a;
}}
void run(void **table, long rows, long length) {{
"""


@dataclass(frozen=True, eq=False)
class Run:
    """A run of machine code: its program and kernel, the table of addresses, and the arrays to which these lead."""

    program: Program
    kernel: Kernel
    addresses: Addresses
    length: int
    held: object

    def again(self) -> None:
        """Run the machine code once more."""
        self.kernel.run(self.addresses, self.length)

    @cached_property
    def in_c(self) -> Callable[[], None]:
        """The loop in C on the same arrays."""
        run = compiled("\n".join(_lines(self.program, self.kernel)))
        return partial(run, self.addresses.ctypes.data, len(self.addresses), self.length)


def available() -> bool:
    """Whether there is a C compiler."""
    return shutil.which(COMPILER) is not None


def runs(solve: Callable[[], object]) -> list[Run]:
    """The runs of machine code in a call, in order."""
    found: list[Run] = []
    run, kernel_of, programs = Kernel.run, calculation.machine_code.Kernel.of, {}

    def of(program: Program, axis: int) -> Kernel:
        kernel = kernel_of(program, axis)
        programs[id(kernel)] = program
        return kernel

    def kept(kernel: Kernel, addresses: Addresses, length: int, workers: int = 1, held: object = None) -> None:
        found.append(Run(programs[id(kernel)], kernel, addresses, length, held))
        run(kernel, addresses, length, workers, held)

    PROGRAMS.clear()  # of which some would have their kernels already
    with patch.object(Kernel, "of", staticmethod(of)), patch.object(Kernel, "run", kept):
        solve()
    return found


def seconds(solve: Callable[[], object], repeats: int) -> tuple[float, float]:
    """Seconds that the machine code of a call takes alone, and that the same steps take in C."""
    found = runs(solve)
    loops = [run.in_c for run in found]
    taken = least_each(
        {"own": lambda: [run.again() for run in found], "C": lambda: [loop() for loop in loops]}, repeats
    )
    return taken["own"], taken["C"]


@cache
def compiled(text: str) -> Callable[[int, int, int], None]:
    """The function ``run`` of some C code, which takes table of addresses, rows, and length of a row."""
    with TemporaryDirectory() as folder:
        source, library = Path(folder, "run.c"), Path(folder, "run.so")
        source.write_text(text, encoding="ascii")
        subprocess.run([COMPILER, *FLAGS, "-o", library, source], check=True)
        found = ctypes.CDLL(str(library)).run
    found.argtypes, found.restype = [ctypes.c_void_p, ctypes.c_int64, ctypes.c_int64], None
    return found


def _lines(program: Program, kernel: Kernel) -> Iterator[str]:
    values = kernel.values
    read, written = values[: kernel.read], values[kernel.read :]
    yield HEAD
    yield f"for (long r = 0; r < rows; r++, table += {1 + len(values)}) {{"
    yield "const double *restrict same = table[0];"
    for place, k in enumerate(values, 1):
        yield f"double *restrict p{k} = table[{place}];"
    yield f"for (long j = 0; j + {WIDTH} <= length; j += {WIDTH}) {{"
    # numbers are loaded where they are first needed, since registers are few
    loads = {k: f"same[{place}] - (vector){{}}" for place, k in enumerate(kernel.same)}
    loads |= {k: f"*(vector *)(p{k} + j)" for k in read}
    for at in program.made(program.widest):
        k, step = program.first + at, program.steps[at]
        for each in set(step.operands) & loads.keys():
            yield f"const vector v{each} = {loads.pop(each)};"
        operands = [_operand(program, each) for each in step.operands]
        yield f"const vector v{k} = {FORMS[step.operation].format(*operands)};"
        if k in written:
            yield f"*(vector *)(p{k} + j) = v{k};"
    yield "}}}"


def _operand(program: Program, k: int) -> str:
    constant = program.given <= k < program.first
    return f"({program.constants[k - program.given]!r} - (vector){{}})" if constant else f"v{k}"
