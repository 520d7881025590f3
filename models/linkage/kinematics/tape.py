"""Arithmetic written down once and replayed: on floats, on arrays, without the zeros.

A calculation that is carried out on `TapeTerm`s leaves its steps on a `Tape`. Zeros and ones that hold for all time
drop out, equal steps are taken once, and what no result needs is left away; a planar linkage described in space thus
costs planar arithmetic. The tape becomes a Python function of straight-line code.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Sequence
from functools import lru_cache
from types import CodeType
from typing import Any

import numpy as np
from numpy.typing import NDArray

Value = float | NDArray[np.float64]
Program = Callable[..., Any]
# The name of what a step makes.
_STEP = re.compile(r"\bt\d+\b")


class TapeTerm:
    """A number known when the tape is replayed."""

    __slots__ = ("name", "tape")

    def __init__(self, tape: Tape, name: str) -> None:
        self.tape, self.name = tape, name

    def __add__(self, other: Scalar) -> Scalar:
        if isinstance(other, float) and other == 0.0:
            return self
        return self.tape.step("+", *sorted((self.name, _name(other))))

    __radd__ = __add__

    def __sub__(self, other: Scalar) -> Scalar:
        if isinstance(other, float) and other == 0.0:
            return self
        return 0.0 if _name(other) == self.name else self.tape.step("-", self.name, _name(other))

    def __rsub__(self, other: Scalar) -> Scalar:
        return -self if other == 0.0 else self.tape.step("-", _name(other), self.name)

    def __mul__(self, other: Scalar) -> Scalar:
        if isinstance(other, float) and abs(other) in (0.0, 1.0):
            return 0.0 if other == 0.0 else self if other == 1.0 else -self
        return self.tape.step("*", *sorted((self.name, _name(other))))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> Scalar:
        return self * (1.0 / other) if isinstance(other, float) else self.tape.step("/", self.name, other.name)

    def __rtruediv__(self, other: float) -> Scalar:
        return 0.0 if other == 0.0 else self.tape.step("/", _name(other), self.name)

    def __neg__(self) -> Scalar:
        return self.tape.step("-", "", self.name)


Scalar = float | TapeTerm
Vector = Sequence[Scalar]


def _name(value: Scalar) -> str:
    return value.name if isinstance(value, TapeTerm) else repr(value)


class Tape:
    """Steps of a calculation, in order."""

    def __init__(self) -> None:
        self._steps: dict[str, tuple[str, tuple[str, ...]]] = {}
        self._known: dict[str, str] = {}

    def step(self, operator: str, first: str, second: str) -> TapeTerm:
        """Write down ``first operator second``."""
        return self._write(f"{first} {operator} {second}", (first, second))

    def call(self, function: str, argument: Scalar) -> Scalar:
        """Write down ``sin`` or ``cos`` of a number."""
        if isinstance(argument, float):
            return float(getattr(math, function)(argument))
        return self._write(f"{function}({argument.name})", (argument.name,))

    def _write(self, text: str, uses: tuple[str, ...]) -> TapeTerm:
        if text not in self._known:
            name = f"t{len(self._steps)}"
            self._known[text] = name
            self._steps[name] = text, uses
        return TapeTerm(self, self._known[text])

    def program(self, inputs: Sequence[Sequence[str]], outputs: Iterable[Scalar]) -> Programs:
        """The function of the tuples `inputs` that returns the tuple `outputs`: for floats, and for arrays."""
        results = [_name(output) for output in outputs]
        needed, open_names = set(), list(results)
        while open_names:
            name = open_names.pop()
            if name in self._steps and name not in needed:
                needed.add(name)
                open_names += self._steps[name][1]
        in_order = sorted(needed, key=lambda name: int(name[1:]))
        lines = [f"def program({', '.join(f'a{k}' for k in range(len(inputs)))}):"]
        lines += [f" {', '.join(names)}, = a{k}" for k, names in enumerate(inputs) if names]
        lines += [f" {name} = {self._steps[name][0]}" for name in in_order]
        lines.append(f" return ({''.join(f'{name}, ' for name in results)})")
        return Programs("\n".join(lines))


def _in_few_variables(source: str) -> str:
    """A program whose numbers leave their variable to the next where they are not used again.

    Few arrays are then there at a time, and stay in the cache.
    """
    lines = source.split("\n")
    last = {name: k for k, line in enumerate(lines) for name in _STEP.findall(line)}
    places, free = dict[str, str](), list[str]()

    def place(found: re.Match[str]) -> str:
        return places[found[0]]

    for k, line in enumerate(lines):
        if not line.startswith(" t"):
            lines[k] = _STEP.sub(place, line)
            continue
        name, text = line[1:].split(" = ")
        text = _STEP.sub(place, text)
        free += [places[use] for use in dict.fromkeys(_STEP.findall(line)) if use != name and last[use] == k]
        places[name] = free.pop() if free else name
        lines[k] = f" {places[name]} = {text}"
    return "\n".join(lines)


class Programs(tuple[Program, Program]):
    """A program for floats, and for arrays; it travels as its source, and is compiled again where it arrives."""

    source: str

    def __new__(cls, source: str) -> Programs:
        """The program of some source."""
        scalar: dict[str, Any] = {"sin": math.sin, "cos": math.cos}
        arrays: dict[str, Any] = {"sin": np.sin, "cos": np.cos}
        exec(_compiled(source), scalar)
        exec(_compiled(source), arrays)
        made = super().__new__(cls, (scalar["program"], of_one(scalar["program"], arrays["program"])))
        made.source = source
        return made

    def __reduce__(self) -> tuple[type[Programs], tuple[str]]:
        return Programs, (self.source,)


def of_one(floats: Program, arrays: Program) -> Program:
    """`arrays`, which leaves a batch of one entry to `floats`: an operation on numbers takes a tenth of the time."""

    def program(*inputs: Sequence[Value]) -> Sequence[Value]:
        depth = -1
        for entries in inputs:
            for x in entries:
                if isinstance(x, np.ndarray):
                    if x.size != 1:
                        return arrays(*inputs)  # type: ignore[no-any-return]
                    depth = max(depth, x.ndim)
        try:
            if depth < 0:
                return floats(*inputs)  # type: ignore[no-any-return]
            found = floats(*([x.item() if isinstance(x, np.ndarray) else x for x in entries] for entries in inputs))
        except (ArithmeticError, ValueError):
            return arrays(*inputs)  # type: ignore[no-any-return]
        return [np.full((1,) * depth, x) for x in found]

    return program


@lru_cache(maxsize=256)
def _compiled(source: str) -> CodeType:
    """Code of a program: linkages that differ in their dimensions only have it in common."""
    return compile(_in_few_variables(source), "<linkage>", "exec")


# -- three-vectors and their axes ------------------------------------------------------------------------------------


def plus(a: Vector, b: Vector) -> list[Scalar]:
    """a + b."""
    return [x + y for x, y in zip(a, b, strict=True)]


def minus(a: Vector, b: Vector) -> list[Scalar]:
    """a - b."""
    return [x - y for x, y in zip(a, b, strict=True)]


def times(factor: Scalar, a: Vector) -> list[Scalar]:
    """A vector times a number."""
    return [factor * x for x in a]


def dot(a: Vector, b: Vector) -> Scalar:
    """Scalar product."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def cross(a: Vector, b: Vector) -> list[Scalar]:
    """Vector product."""
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def combine(axes: Sequence[Vector], a: Vector) -> list[Scalar]:
    """Sum of the three `axes` times the components of `a`: the vector that has them along these axes."""
    total: list[Scalar] = [0.0, 0.0, 0.0]
    for axis, x in zip(axes, a, strict=True):
        total = plus(total, times(x, axis))
    return total
