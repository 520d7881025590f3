"""Running the steps of a program with single numbers: one by one, or as compiled Python functions."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from ..program.program import Operation
from ..structure.parts import Extended

# An operation and the places of its two operands.
Step = tuple[Callable[[Any, Any], Any], int, int]
# One in extended precision. Multiplying a double by it converts the double in a tenth of the time of the constructor.
ONE = Extended(1.0)


def carried_out(steps: Sequence[Step], given: list[Any]) -> list[Any]:
    """All numbers by place: the given ones, then the result of each step."""
    values = list(given)
    put = values.append
    for operation, a, b in steps:
        put(operation(values[a], values[b]))
    return values


def kept_places(
    ratios: Sequence[int], loaded: Sequence[Step], known: Sequence[int], nodes: Sequence[int], first: int
) -> list[int]:
    """Places before `first` of the numbers that the second part needs: the pivot ratios, then the others in order."""
    used = {k for _, a, b in loaded for k in (a, b)}.union(known, nodes)
    return [*ratios, *sorted(k for k in used if k < first)]


class EntryCode:
    """Both parts of an `EntryProgram` as Python functions; compiling them takes some ten milliseconds.

    Parameters
    ----------
    size
        Number of given numbers and constants.
    shared, loaded
        Steps of the first part, which is independent of the loads, and of the second part.
    loads
        Number of loads.
    ratios, known, nodes
        Places of the pivot ratios (computed by the first part), of the unknowns, and of the nodal displacements.
    """

    def __init__(
        self,
        size: int,
        shared: Sequence[Step],
        loads: int,
        loaded: Sequence[Step],
        ratios: Sequence[int],
        known: Sequence[int],
        nodes: Sequence[int],
    ) -> None:
        first = size + len(shared)
        kept = kept_places(ratios, loaded, known, nodes, first)
        source = [
            *_written("shared", [range(size)], shared, size, [kept]),
            *_written("loaded", [kept, range(first, first + loads)], loaded, first + loads, [nodes, known]),
        ]
        made: dict[str, Any] = {"one": ONE, "inf": np.inf}
        exec(compile("\n".join(source), "<frame>", "exec"), made)
        self._count = len(ratios)
        self._shared: Callable[[list[Any]], list[Any]] = made["shared"]
        self.loaded: Callable[[list[Any], list[Any]], tuple[list[Any], list[Any]]] = made["loaded"]

    def shared(self, given: list[Any]) -> tuple[list[Any], list[Any]]:
        """Run the first part: the pivot ratios, and the state for the second part."""
        state = self._shared(given)
        return state[: self._count], state


def _written(
    name: str, given: Sequence[Sequence[int]], steps: Sequence[Step], first: int, made: Sequence[Sequence[int]]
) -> list[str]:
    """Source lines of a function that runs the steps; `first` is the place of the first step's result.

    A variable is reused once it has been read for the last time: fewer variables, and the freed memory of their
    numbers, make the function a tenth faster.
    """
    last = {k: place for place, (_, a, b) in enumerate(steps) for k in (a, b)}
    last |= {k: len(steps) for each in made for k in each}
    names: dict[int, str] = {}
    free: list[str] = []

    def listed(numbers: Sequence[int]) -> str:
        return "[" + ", ".join(names[k] for k in numbers) + "]"

    lines = []
    for place, numbers in enumerate(given):
        names |= {k: f"v{k}" for k in numbers}
        lines.append(f" {listed(numbers)} = given[{place}]")
    for place, (do, a, b) in enumerate(steps):
        text = _TEXTS[do].format(a=names[a], b=names[b])
        free += [names[k] for k in {a, b} if last[k] == place]
        names[first + place] = free.pop() if free else f"v{first + place}"
        lines.append(f" {names[first + place]} = {text}")
    return [f"def {name}(*given):", *lines, f" return {', '.join(map(listed, made))}"]


def widen(a: Any, _: Any) -> Any:
    return ONE * a


def divided(a: Any, b: Any) -> Any:
    """a / b; inf where b is exactly zero, as in `reciprocal`."""
    return a / b if b else np.inf


def negative(a: Any, _: Any) -> Any:
    return -a


def square_root(a: Any, _: Any) -> Any:
    return np.sqrt(a)


def least(a: Any, b: Any) -> Any:
    """The smaller of two numbers; NaN if b is NaN, as in `numpy.minimum`."""
    return b if b < a or b != b else a


def most(a: Any, b: Any) -> Any:
    return b if b > a or b != b else a


OPERATIONS: dict[Operation, Callable[[Any, Any], Any]] = {
    Operation.ADD: operator.add,
    Operation.SUBTRACT: operator.sub,
    Operation.MULTIPLY: operator.mul,
    Operation.DIVIDE: divided,
    Operation.NEGATE: negative,
    Operation.MINIMUM: least,
    Operation.MAXIMUM: most,
    Operation.SQUARE_ROOT: square_root,
}
# The operations of single batch entries as Python source.
_TEXTS: dict[Callable[[Any, Any], Any], str] = {
    operator.add: "{a} + {b}",
    operator.sub: "{a} - {b}",
    operator.mul: "{a} * {b}",
    widen: "one * {a}",
    divided: "{a} / {b} if {b} else inf",
    negative: "-{a}",
    least: "{b} if {b} < {a} or {b} != {b} else {a}",
    most: "{b} if {b} > {a} or {b} != {b} else {a}",
}
