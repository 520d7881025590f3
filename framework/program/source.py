"""A program as Python functions of straight-line code, for single numbers and for arrays."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import repeat
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..batch import Shape
from ..cache import KERNELS
from ..structure.parts import Value, mask_of
from .calculation import Calculation, worth_compiling
from .program import Operation, Program

Function = Callable[..., Any]
# For each input the index of the argument, a sequence, in which it is passed, and its index there.
Places = tuple[tuple[int, int], ...]
_TEXTS = {
    Operation.ADD: "{} + {}",
    Operation.SUBTRACT: "{} - {}",
    Operation.MULTIPLY: "{} * {}",
    Operation.DIVIDE: "{} / {}",
    Operation.NEGATE: "-{}",
    Operation.SINE: "sin({})",
    Operation.COSINE: "cos({})",
    Operation.SQUARE_ROOT: "sqrt({})",
    Operation.ABSOLUTE: "abs({})",
}
_FLOATS = {"sin": math.sin, "cos": math.cos, "sqrt": math.sqrt}
_ARRAYS = {"sin": np.sin, "cos": np.cos, "sqrt": np.sqrt}


class Functions(tuple[Function, Function]):
    """A program as two functions of groups of numbers: one for floats, one for arrays that broadcast.

    It is pickled as the program and compiled again by the other process.

    Attributes
    ----------
    program
        The program.
    places
        For each input the index of its group, and its index there.
    """

    program: Program
    places: Places

    def __new__(cls, program: Program, places: Places) -> Functions:
        """Compile the functions of a program."""
        code = compile("\n".join(_lines(program, places)), "<program>", "exec")
        floats, arrays = dict[str, Any](_FLOATS), dict[str, Any](_ARRAYS)
        exec(code, floats)
        exec(code, arrays)
        few = _FEW if len(program.steps) >= _MANY else 1
        made = super().__new__(cls, (floats["program"], of_one(floats["program"], arrays["program"], few)))
        made.program, made.places = program, places
        return made

    @staticmethod
    def of(program: Program, places: Places) -> Functions:
        """The functions of a program, cached for equal programs."""
        key = "functions", program, places
        found: Functions = KERNELS.found(key, lambda: Functions(program, places), len(program.steps))
        return found

    def __reduce__(self) -> tuple[Callable[..., Functions], tuple[Program, Places]]:
        return Functions.of, (self.program, self.places)

    def calculation(self, inputs: Sequence[Sequence[Value]], shape: Shape) -> Calculation | None:
        """The calculation by machine code for a long batch; None if that does not pay.

        Parameters
        ----------
        inputs
            The groups of numbers.
        shape
            Shape of the batch to which they broadcast.
        """
        return calculation(self.program, [inputs[group][place] for group, place in self.places], shape)


def calculation(program: Program, given: Sequence[Value], shape: Shape) -> Calculation | None:
    """The calculation of a program by machine code for a long batch; None if that does not pay.

    Parameters
    ----------
    program
        The program.
    given
        Input values, which broadcast.
    shape
        Shape of the batch to which they broadcast.
    """
    if not worth_compiling(math.prod(shape)):
        return None
    tables, depth = program.tables, len(shape)
    values = [x if k in tables else _deep(x, depth) for k, x in enumerate(given)]
    masks = tuple(0 if k in tables else mask_of(x) for k, x in enumerate(values))
    own: Program = KERNELS.found(("over", program, masks), lambda: program.over(masks), len(program.steps))
    made = Calculation(own, values, shape)
    return made if made.choice.compiled else None


def _deep(value: Value, depth: int) -> Value:
    """An array with as many axes as the batch; single numbers as they are."""
    if not isinstance(value, np.ndarray):
        return value
    return value.item() if value.size == 1 else value.reshape((1,) * (depth - value.ndim) + value.shape)


def _lines(program: Program, places: Places) -> Iterator[str]:
    """Source lines of the function.

    A variable is reused once its value is no longer needed, so that few arrays exist at a time and stay in the cache.
    """
    yield "def program(a0, a1=(), a2=(), a3=()):"
    names = [f"g{k}" for k in range(program.given)] + [repr(value) for value in program.constants]
    yield from (f" g{k} = a{group}[{place}]" for k, (group, place) in enumerate(places))
    last = {k: turn for turn, step in enumerate(program.steps) for k in step.operands}
    last |= dict.fromkeys(program.outputs, len(program.steps))
    free: list[str] = []
    for turn, step in enumerate(program.steps):
        text = _TEXTS[step.operation].format(*(names[k] for k in step.operands))
        done = [k for k in dict.fromkeys(step.operands) if last[k] == turn and k >= program.first]
        free += [names[k] for k in done]
        names.append(free.pop() if free else f"t{turn}")
        yield f" {names[-1]} = {text}"
    yield f" return ({''.join(f'{names[k]}, ' for k in program.outputs)})"


# Types of single numbers, and of these and arrays.
_PLAIN = {float, int, np.float64}
_NUMBERS = _PLAIN | {np.ndarray}
# A program of _MANY steps or more is run for each of up to _FEW entries: NumPy's calls for arrays would take longer.
_FEW, _MANY = 10, 50


def of_one(floats: Function, arrays: Function, few: int = 1) -> Function:
    """A function that calls `floats`, in a tenth of the time, for each of up to `few` entries, and else `arrays`."""

    def program(*inputs: Sequence[Value]) -> Sequence[Value]:
        kinds = set[type]()
        for entries in inputs:
            kinds.update(map(type, entries))
        if kinds <= _NUMBERS:
            given, most = [x for entries in inputs for x in entries if type(x) is np.ndarray], few
        else:
            given, most = [x for entries in inputs for x in entries if isinstance(x, np.ndarray)], 1
        shape = _shape_of_few(given, most)
        if shape is None:
            return arrays(*inputs)  # type: ignore[no-any-return]
        try:
            if not given:
                return floats(*inputs)  # type: ignore[no-any-return]
            if math.prod(shape) == 1:
                found = floats(*([x.item() if isinstance(x, np.ndarray) else x for x in entries] for entries in inputs))
            else:
                found = list(zip(*(floats(*each) for each in zip(*map(_columns, inputs), strict=False)), strict=True))
        except (ArithmeticError, ValueError):
            return arrays(*inputs)  # type: ignore[no-any-return]
        whole = np.array(found).reshape(-1, *shape)
        return [whole[k, ...] for k in range(len(whole))]

    return program


def _shape_of_few(given: Sequence[NDArray[Any]], few: int) -> Shape | None:
    """The shape of arrays of one entry, or of all of the same entries, of which there are `few`; None for others."""
    whole, depth = (), 0  # type: Shape, int
    for x in given:
        if x.size == 1:
            depth = max(depth, x.ndim)
        elif x.shape != whole:
            if whole or not 0 < x.size <= few or x.dtype != np.float64:
                return None
            whole = x.shape
    if not whole:
        return (1,) * depth
    return whole if depth <= len(whole) else None


def _columns(entries: Sequence[Value]) -> Iterator[Sequence[Value]]:
    """The numbers of a group for one entry after the other, without end where it has no array of several."""
    varying = [x for x in entries if isinstance(x, np.ndarray) and x.size > 1]
    single = [x.item() if isinstance(x, np.ndarray) and x.size == 1 else x for x in entries]
    if not varying:
        return repeat(single)
    return zip(*(x.ravel().tolist() if isinstance(x, np.ndarray) else repeat(x) for x in single), strict=False)
