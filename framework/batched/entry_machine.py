"""The program of a frame with a single batch entry as machine code, in doubles and 80-bit extended precision.

Python takes some fifty nanoseconds for a step, nearly all of it for creating the resulting number. LLVM (extra
``fast``) runs the same steps in the same order and in the same two precisions, without permission to reorder them, so
that results are the same to the last bit.
"""

from __future__ import annotations

import ctypes
import operator
import platform
import struct
from array import array
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import cache, partial
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..program import machine_code
from ..structure.parts import Extended, Value
from .entry_steps import Step, divided, kept_places, least, most, negative, square_root, widen

_WIDE, _DOUBLE = "x86_fp80", "double"
_INF = {_WIDE: "0xK7FFF8000000000000000", _DOUBLE: "0x7FF0000000000000"}
_ZERO = {_WIDE: "0xK00000000000000000000", _DOUBLE: "0x0000000000000000"}
_PLAIN = {operator.add: "fadd", operator.sub: "fsub", operator.mul: "fmul"}
_BELOW: dict[Callable[[Any, Any], Any], str] = {least: "olt", most: "ogt"}
# Bytes of a number of each precision in an array.
_SIZES = {_WIDE: 16, _DOUBLE: 8}


def available() -> bool:
    """Whether llvmlite is installed and NumPy's extended precision is the 80-bit format of x86 processors."""
    return machine_code.available() and _known()


@cache
def _known() -> bool:
    wide = np.finfo(Extended)
    return platform.machine().lower() in ("x86_64", "amd64") and wide.nmant == 63 and np.dtype(Extended).itemsize == 16


class EntryMachineCode:
    """Both parts of the program of a frame with a single batch entry, compiled; see `EntryProgram`.

    Numbers are identified by their place in the order: given numbers, constants, results of the shared steps, loads,
    results of the loaded steps.

    Parameters
    ----------
    given
        For each given number, whether it is in extended precision.
    constants
        Constants of the program.
    shared, loaded
        Steps of the first part, which is independent of the loads, and of the second part.
    loads
        Number of loads, which are doubles.
    ratios, known, nodes
        Places of the pivot ratios (computed by the first part), of the unknowns, and of the nodal displacements.
    """

    def __init__(
        self,
        given: Sequence[bool],
        constants: Sequence[Value],
        shared: Sequence[Step],
        loads: int,
        loaded: Sequence[Step],
        ratios: Sequence[int],
        known: Sequence[int],
        nodes: Sequence[int],
    ) -> None:
        wide = [*given, *(isinstance(value, np.longdouble) for value in constants)]
        size = len(wide)
        made, first = [*kinds_of(wide, shared)], size + len(shared)
        kept = kept_places(ratios, loaded, known, nodes, first)
        self._kept, self._ratios = len(kept), [made[k] for k in ratios]
        places: dict[bool, list[int]] = {True: [], False: []}
        for k, kind in enumerate(given):
            places[kind].append(k)
        begin = [
            *load_lines("a", _DOUBLE, _counted(places[False])),
            *load_lines("b", _WIDE, _counted(places[True])),
            *constant_lines(len(given), constants),
        ]
        self._shared = _function([*begin, *step_lines(made, shared, size), *store_lines("c", made, kept, _WIDE)])
        whole = [*made, *(False for _ in range(loads))]
        after = [*kinds_of(whole, loaded)]
        kinds = [made[k] for k in kept]
        begin = [*_take(kept, kinds), *load_lines("b", _DOUBLE, _counted(range(first, first + loads)))]
        end = [
            *store_lines("c", after, nodes, _DOUBLE),
            *store_lines("c", after, known, _WIDE, _SIZES[_DOUBLE] * len(nodes)),
        ]
        self._loaded = _function([*begin, *step_lines(after, loaded, first + loads), *end])
        self._nodes, self._known = len(nodes), [after[k] for k in known]

    def shared(self, narrow: Sequence[float], wide: NDArray[Any]) -> tuple[list[Value], NDArray[Any]]:
        """Run the first part: the pivot ratios, and the state for the second part.

        The given numbers are those in double precision, `narrow`, and those in extended precision, `wide`.
        """
        # an array of Python's tells its address in a tenth of the time
        given, state = array("d", narrow), np.empty(self._kept, dtype=Extended)
        self._shared(given.buffer_info()[0], wide.ctypes.data, state.ctypes.data)
        return _numbers(state[: len(self._ratios)], self._ratios), state

    def loaded(
        self, state: NDArray[Any], loads: Sequence[float]
    ) -> tuple[NDArray[np.float64], Callable[[], list[Value]]]:
        """Run the second part: displacements of all nodes, (nodes, 6), and a function that returns the unknowns."""
        given = array("d", loads)
        # one array for both results: numbers in extended precision must be aligned to sixteen bytes
        size = self._nodes
        out = np.empty((size + 1) // 2 + len(self._known), dtype=Extended)
        self._loaded(state.ctypes.data, given.buffer_info()[0], out.ctypes.data)
        return out[: size // 2].view(np.float64).reshape(-1, 6), partial(_numbers, out[size // 2 :], self._known)


def _numbers(given: NDArray[Any], kinds: Sequence[bool]) -> list[Value]:
    """The numbers of an array, as Python floats where they are doubles."""
    return [value if wide else float(value) for value, wide in zip(given, kinds, strict=True)]


def _function(lines: Iterable[str]) -> Callable[..., None]:
    text = ["define void @run(ptr %a, ptr %b, ptr %c) {", *lines, "  ret void", "}"]
    address = ctypes.c_void_p
    found: Callable[..., None] = machine_code.compiled(
        "\n".join(text), ctypes.CFUNCTYPE(None, address, address, address)
    )
    return found


def kinds_of(wide: Sequence[bool], steps: Sequence[Step]) -> Iterator[bool]:
    """For each number, given or computed by a step, whether it is in extended precision."""
    known = list(wide)
    for operation, a, _ in steps:
        known.append(operation is widen or known[a])
    return iter(known)


def _at(pointer: str, name: str, offset: int) -> str:
    return f"  %{name} = getelementptr i8, ptr %{pointer}, i64 {offset}"


def load_lines(pointer: str, kind: str, places: Mapping[int, int]) -> Iterator[str]:
    """LLVM code that loads numbers of one precision: for each place, the one at this index."""
    for place, k in places.items():
        yield _at(pointer, f"p{place}", k * _SIZES[kind])
        yield f"  %v{place} = load {kind}, ptr %p{place}, align 8"


def _counted(places: Iterable[int]) -> dict[int, int]:
    return {place: k for k, place in enumerate(places)}


def _take(kept: Sequence[int], kinds: Sequence[bool]) -> Iterator[str]:
    """LLVM code that loads the state of the first part, all in extended precision, in which doubles are exact."""
    for k, place in {place: k for k, place in enumerate(kept)}.items():
        wide = kinds[place]
        yield _at("a", f"p{k}", _SIZES[_WIDE] * place)
        yield f"  %{'v' if wide else 'x'}{k} = load {_WIDE}, ptr %p{k}, align 16"
        if not wide:
            yield f"  %v{k} = fptrunc {_WIDE} %x{k} to {_DOUBLE}"


def constant_lines(first: int, constants: Sequence[Value]) -> Iterator[str]:
    """LLVM code of constants, the first of them with this place."""
    for k, value in enumerate(constants, first):
        (bits,) = struct.unpack(">Q", struct.pack(">d", float(value)))
        if isinstance(value, np.longdouble):
            yield f"  %v{k} = fpext {_DOUBLE} 0x{bits:016X} to {_WIDE}"
        else:
            # adding zero would lose its sign; minus zero changes nothing
            yield f"  %v{k} = fadd {_DOUBLE} 0x{bits:016X}, 0x8000000000000000"


def store_lines(pointer: str, wide: Sequence[bool], places: Iterable[int], kind: str, offset: int = 0) -> Iterator[str]:
    """LLVM code that stores numbers consecutively, converted to one precision."""
    for n, k in enumerate(places):
        yield from store_line(pointer, n, k, _kind(wide[k]), kind, offset)


def store_line(pointer: str, n: int, place: int, own: str, kind: str, offset: int = 0) -> Iterator[str]:
    """LLVM code that stores the number at a place, which has a precision of its own, as the n-th of another."""
    name, value = f"{kind[0]}{n}", f"%v{place}"
    if own != kind:
        value = f"%s{name}"
        yield f"  {value} = {'fpext' if kind == _WIDE else 'fptrunc'} {own} %v{place} to {kind}"
    yield _at(pointer, f"o{name}", offset + n * _SIZES[kind])
    yield f"  store {kind} {value}, ptr %o{name}, align {_SIZES[kind]}"


def _kind(wide: bool) -> str:
    return _WIDE if wide else _DOUBLE


def step_lines(wide: Sequence[bool], steps: Sequence[Step], first: int) -> Iterator[str]:
    """LLVM code of steps, the result of the first of them having this place."""
    for k, step in enumerate(steps, first):
        yield from step_line(_kind(wide[k]), step, k)


def step_line(kind: str, step: Step, k: int) -> Iterator[str]:
    """LLVM code of a step whose result has this precision and the place k."""
    operation, i, j = step
    a, b = f"%v{i}", f"%v{j}"
    if operation in _PLAIN:
        yield f"  %v{k} = {_PLAIN[operation]} {kind} {a}, {b}"
    elif operation is widen:
        yield f"  %v{k} = fpext {_DOUBLE} {a} to {_WIDE}"
    elif operation is square_root:
        yield f"  %v{k} = call {_DOUBLE} @llvm.sqrt.f64({_DOUBLE} {a})"
    elif operation is negative:
        yield f"  %v{k} = fneg {kind} {a}"
    elif operation is divided:
        yield f"  %q{k} = fdiv {kind} {a}, {b}\n  %z{k} = fcmp oeq {kind} {b}, {_ZERO[kind]}"
        yield f"  %v{k} = select i1 %z{k}, {kind} {_INF[kind]}, {kind} %q{k}"
    else:
        yield f"  %l{k} = fcmp {_BELOW[operation]} {kind} {b}, {a}\n  %n{k} = fcmp uno {kind} {b}, {b}"
        yield f"  %u{k} = or i1 %l{k}, %n{k}\n  %v{k} = select i1 %u{k}, {kind} {b}, {kind} {a}"
