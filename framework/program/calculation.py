"""A program with its input values: the choice between NumPy and machine code, and running it."""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple, cast

import numpy as np

from ..batch import Array, Shape
from ..cache import KERNELS
from ..structure.parts import Value
from . import machine_code
from .combination import Combination
from .machine_text import WIDTH
from .numpy_backend import Memory, Schedule, combinations
from .program import Program
from .recording import Recording, Term
from .selection import selected

# Seconds, by order of magnitude: NumPy's operation on one number in the cache, one in machine code, compiling a step.
NUMPY, COMPILED, COMPILING = 0.5e-9, 0.05e-9, 35e-6
# Length of a program at which each step takes twice as long to compile.
TWICE = 2**14
# Compiled code is likely to be run again: this many runs may be needed to make up for compiling it. Programs for which
# more than MORE runs would be needed are not counted.
TIMES, MORE = 2, 16
# Largest number of steps that are compiled, and least number of entries along the last axis.
MOST, LEAST = 2**15, 2 * WIDTH
# Seconds of machine code above which a second thread is worth starting.
THREADS = 1e-3


@dataclass(frozen=True)
class Choice:
    """Whether to compile a program to machine code, and why, in words."""

    compiled: bool
    reason: str


class Spent:
    """Seconds that NumPy is expected to have taken for a program so far."""

    def __init__(self) -> None:
        self.seconds = 0.0


class Calculation:
    """A program with its input values, for a batch.

    Parameters
    ----------
    program
        The program.
    given
        Input values, arrays with all batch axes where they vary; None for values that are passed to `run`.
    shape
        Shape of the batch.
    later
        For each value that is passed to `run`: its index among the inputs, and its index among those passed.
    compiled
        Whether to run it as machine code (True) or by NumPy (False); None chooses by expected time.
    """

    def __init__(
        self,
        program: Program,
        given: Sequence[Value | None],
        shape: Shape,
        *,
        later: Sequence[tuple[int, int]] = (),
        compiled: bool | None = None,
    ) -> None:
        self.program, self.shape = program, shape
        self._given = [_double(value) for value in given]
        self._later = later
        self.choice = (
            choose(self.program, shape)
            if compiled is None
            else Choice(compiled, f"{'as machine code' if compiled else 'by NumPy'}, as asked for")
        )
        self._memory: dict[Shape, Memory] = {}

    @classmethod
    def recorded(
        cls, recording: Recording, outputs: Sequence[Term], shape: Shape, *, compiled: bool | None = None
    ) -> Calculation:
        """The calculation of some terms of a recording.

        Parameters
        ----------
        recording
            The recording.
        outputs
            The terms to compute.
        shape, compiled
            As for `Calculation`.
        """
        program, places = recording.program(outputs)
        turns = {k: turn for turn, k in enumerate(k for k, value in enumerate(recording.given) if value is None)}
        later = [(at, turns[k]) for at, k in enumerate(places) if k in turns]
        return cls(program, [recording.given[k] for k in places], shape, later=later, compiled=compiled)

    @property
    def needed(self) -> list[int]:
        """Indices of those of the inputs passed to `run` that are needed, ascending."""
        return sorted(turn for _, turn in self._later)

    def of(self, mask: int, shape: Shape | None = None) -> Shape:
        """Shape of a number that varies over the axes of a mask, for the batch or a part of it of another `shape`."""
        return tuple(n if mask >> axis & 1 else 1 for axis, n in enumerate(self.shape if shape is None else shape))

    def results(self) -> list[Any]:
        """All outputs, each of the shape over which it varies; constants as floats."""
        program = self.program
        held = self.places()
        self.run(0, slice(None), held)
        fixed = dict(enumerate(program.constants, program.given))
        return [fixed.get(k, out) for k, out in zip(program.outputs, held, strict=True)]

    def places(self) -> list[Array]:
        """Arrays for all outputs over the whole batch."""
        return [self._place(k, self.shape) for k in self.program.outputs]

    def _place(self, number: int, shape: Shape) -> Array:
        """An array for a value, for the batch or a part of it of some shape."""
        program = self.program
        return np.empty(self.of(program.masks[number], shape), np.bool_ if program.holds(number) else None)

    def run(self, axis: int, indices: slice, outputs: Sequence[Array], later: Sequence[Value] = ()) -> None:
        """Run the steps for some indices of a batch axis.

        Parameters
        ----------
        axis, indices
            The part of the batch.
        outputs
            Arrays to fill with the outputs, each of the shape over which it varies in that part.
        later
            Values of the inputs that were left open, for that part.
        """
        tables = self.program.tables
        given = [
            value if k in tables else _cut(value, axis, indices, self.shape) for k, value in enumerate(self._given)
        ]
        for at, turn in self._later:
            given[at] = later[turn]
        length = len(range(self.shape[axis])[indices])
        shape = (*self.shape[:axis], length, *self.shape[axis + 1 :])
        asked = list(zip(self.program.outputs, outputs, strict=True))
        first = dict(reversed(asked))
        self._backend(axis, indices, shape, cast(list[Value], given), first)
        for k, out in asked:
            if k < self.program.first:
                out[...] = cast(Value, [*given, *self.program.constants][k])
            elif first[k] is not out:
                out[...] = first[k]

    @property
    def stores(self) -> bool:
        """Whether numbers are stored between steps, so that parts of a batch are to stay in the cache."""
        return not self.choice.compiled or any(before.program.steps for before, _, _ in self._before)

    def release(self) -> None:
        """Drop the memory of intermediate results, which is kept for the next run."""
        self._memory.clear()

    def _backend(self, axis: int, indices: slice, shape: Shape, given: list[Value], outputs: dict[int, Array]) -> None:
        outputs = {k: out for k, out in outputs.items() if k >= self.program.first}
        if not self.choice.compiled:
            memory = self._memory.pop(shape, None) or Memory(self._schedule, shape)
            memory.run(given, outputs, [each.cut(axis, indices) for each in self._combinations])
            self._memory[shape] = memory
            return
        made = outputs
        for before, inputs, kept in self._before:
            found = {k: outputs[k] if k in outputs else self._place(k, shape) for k in kept}
            places = dict(zip(before.program.outputs, found.values(), strict=True))
            before._backend(axis, indices, shape, [given[k] for k in inputs], places)
            made = made | found
        self._run_compiled(shape, given, made)

    def _run_compiled(self, shape: Shape, given: list[Value], made: dict[int, Array]) -> None:
        program, kernel = self.program, self._kernel
        if not kernel.values:
            return
        axis = program.widest.bit_length() - 1
        lead, length = self.of(program.widest, shape)[:axis], shape[axis]
        same = np.empty((*lead, len(kernel.same)))
        for place, k in enumerate(kernel.same):
            same[..., place] = _along(made[k] if k in made else given[k], len(lead))
        arrays: list[Array] = [same]
        outputs: list[tuple[Array, int]] = []
        for place, k in enumerate(kernel.values, -kernel.read):
            array = np.asarray(made[k] if k in made else given[k])
            array = array.astype(np.float64, copy=False) if place < 0 else array  # what is true or false as 1 or 0
            array = array.reshape((1,) * (len(shape) - array.ndim) + array.shape)
            along = k not in program.tables
            if k < program.first and along and length > 1:
                array = array if array.shape[axis] > 1 else np.broadcast_to(array, self.of(1 << axis, shape))
                array = array if array.strides[axis] == array.itemsize else np.ascontiguousarray(array)
            if along and length < WIDTH:
                outputs += [(array, len(arrays))] if k >= program.first else []
                array = np.take(array, np.minimum(np.arange(WIDTH), length - 1), axis)
            arrays.append(array)
        seconds = math.prod(lead) * length * program.weight * COMPILED
        threads = workers() if seconds > THREADS else 1
        kernel.run(_addresses(arrays, lead), max(length, WIDTH), threads, held=arrays)
        for out, place in outputs:
            out[...] = np.take(arrays[place], np.arange(length), axis)

    @cached_property
    def _before(self) -> list[tuple[Calculation, list[int], list[int]]]:
        """What varies over fewer axes than machine code runs over, as calculations of their own, see `_fewer_axes`."""
        bare = self.program.bare
        found: list[_Part] = KERNELS.found(("fewer axes", bare), partial(_fewer_axes, bare), len(bare.steps))
        return [
            (Calculation(part.program, [None for _ in part.inputs], self.shape), part.inputs, part.kept)
            for part in found
        ]

    @cached_property
    def _kernel(self) -> machine_code.Kernel:
        return machine_code.Kernel.of(self.program.bare, self.program.widest.bit_length() - 1)

    @cached_property
    def _schedule(self) -> Schedule:
        return Schedule(self.program) if self.program.products else Schedule.whole(self.program)

    @cached_property
    def _combinations(self) -> list[Combination]:
        return combinations(self.program, cast(list[Value], self._given), self.shape)


class _Part(NamedTuple):
    """Steps of a program that another one needs: their program, the indices of its inputs, and what it computes."""

    program: Program
    inputs: list[int]
    kept: list[int]


def _fewer_axes(program: Program) -> list[_Part]:
    """The steps that do not vary over all axes, as a program for each set of axes that contains no other.

    A step that two of them need is done in both, which costs little: it varies over still fewer axes.
    """
    first, widest = program.first, program.widest
    read = {k for at in program.made(widest) for k in program.steps[at].operands}.union(program.outputs)
    left = sorted(k for k in read if k >= first and program.masks[k] != widest)
    sets = {program.masks[k] for k in left}
    made = [*range(program.given), *program.constants, *program.steps]
    out = []
    for mask in sorted(sets):
        if any(mask != other and mask & other == mask for other in sets):
            continue
        kept = [k for k in left if program.masks[k] & mask == program.masks[k]]
        left = [k for k in left if k not in kept]
        out.append(_Part(*selected(kept, made, program.masks, (), None), kept))
    return out


def choose(program: Program, shape: Shape) -> Choice:
    """The choice that is expected to take less time, in view of how often the program has been run before."""
    size, steps = _size(program, shape), program.weight
    numpy, compiling = seconds(program, shape)
    text = f"{steps} steps on {size} entries by NumPy, about {_milliseconds(numpy)}"
    if not machine_code.available():
        return Choice(False, f"{text}; llvmlite (extra 'fast'), which would compile them, is not installed")
    if not program.widest or shape[program.widest.bit_length() - 1] < LEAST:
        return Choice(False, f"{text}; machine code takes {LEAST} entries or more along the last axis")
    if steps > MOST:
        return Choice(False, f"{text}; more than {MOST} steps take too long to compile")
    if TIMES * numpy < compiling and not _paid(program, numpy, compiling):
        return Choice(False, f"{text}; compiling them would take about {_milliseconds(compiling)}")
    # asking for the processor's features loads the compiler, which may take longer than a short batch
    if not machine_code.able(program):
        return Choice(False, f"{text}; machine code takes a processor with fused operations for sines")
    return Choice(
        True,
        f"{steps} steps on {size} entries as machine code, about {_milliseconds(COMPILED * size * steps)} and once "
        f"{_milliseconds(compiling)} to compile; NumPy would take about {_milliseconds(numpy)}",
    )


def _paid(program: Program, numpy: float, compiling: float) -> bool:
    """Whether what NumPy has taken for the program so far, and will take now, makes up for compiling it.

    False where that might change results, so that these do not depend on what was solved before.
    """
    if MORE * numpy < compiling or not program.exact:
        return False
    spent: Spent = KERNELS.found(("spent", program.bare), Spent)
    if spent.seconds + TIMES * numpy >= compiling:
        return True
    spent.seconds += numpy
    return False


def seconds(program: Program, shape: Shape) -> tuple[float, float]:
    """Expected seconds of NumPy for a batch, and of compiling."""
    steps = program.weight
    return NUMPY * _size(program, shape) * steps, COMPILING * steps * (1.0 + steps / TWICE)


def _size(program: Program, shape: Shape) -> int:
    return math.prod(n for axis, n in enumerate(shape) if program.widest >> axis & 1)


def worth_compiling(size: int) -> bool:
    """Whether a short program may be worth compiling for so many batch entries, where that is possible."""
    return machine_code.available() and MORE * NUMPY * size >= COMPILING


def _milliseconds(seconds: float) -> str:
    return f"{1e3 * seconds:.2g} ms"


def empty(shapes: Sequence[Shape], given: Sequence[Array | None]) -> list[Array]:
    """Arrays of given shapes: the `given` ones where these fit, the others in one piece of memory, which is faster."""
    suits = [place is not None and place.shape == shape for shape, place in zip(shapes, given, strict=True)]
    sizes = [0 if suit else math.prod(shape) for suit, shape in zip(suits, shapes, strict=True)]
    pieces = np.split(np.empty(sum(sizes)), np.cumsum(sizes)[:-1]) if sizes else []
    return [
        cast(Array, place) if suit else piece.reshape(shape)
        for suit, place, piece, shape in zip(suits, given, pieces, shapes, strict=True)
    ]


def workers() -> int:
    """Number of threads for machine code: OMP_NUM_THREADS, or the number of processors."""
    asked = os.environ.get("OMP_NUM_THREADS", "")
    if asked.isdigit():
        return max(1, int(asked))
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _addresses(arrays: Sequence[Array], lead: Shape) -> machine_code.Addresses:
    """Memory address of each array at each index of the leading axes `lead`, (rows, arrays)."""
    table = np.empty((*lead, len(arrays)), dtype=np.int64)
    table[...] = [array.__array_interface__["data"][0] for array in arrays]
    for axis, length in enumerate(lead):
        steps = [array.strides[axis] if array.shape[axis] > 1 else 0 for array in arrays]
        table += np.multiply.outer(np.arange(length), steps).reshape(length, *(1,) * (len(lead) - axis - 1), -1)
    return table.reshape(-1, len(arrays))


def _along(value: Value, depth: int) -> Value:
    """A number with only the first `depth` batch axes, as it does not vary over the others."""
    return value.reshape(value.shape[:depth]) if isinstance(value, np.ndarray) and value.ndim > depth else value


def _double(value: Value | None) -> Value | None:
    if value is None:
        return None
    return value.astype(np.float64, copy=False) if isinstance(value, np.ndarray) else float(value)


def _cut(value: Value | None, axis: int, indices: slice, shape: Shape) -> Value | None:
    """The values of a number in a chunk."""
    if not isinstance(value, np.ndarray) or value.shape[axis] != shape[axis]:
        return value
    return value[(slice(None),) * axis + (indices,)]
