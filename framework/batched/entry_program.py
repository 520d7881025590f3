"""The solution of a frame of one entry as a list of operations, in two parts: what depends on its loads, and what does
not, which other loads take up.

The list is run with plain numbers, each in the precision that it has in the calculation itself: the same operations in
the same order, and so the same bits.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from ..batch import Array
from ..program.program import Operation
from ..solvers.method import Method
from ..structure.parts import Extended, Row, Value, combine, unknowns
from .one_entry import EntryLoads, EntryNumbers

# A pivot below this share of the stiffness whose rounding it carries raises suspicion.
SUSPECT = 1e-11

# What is done, and the places of the two numbers that it is done with.
Step = tuple[Callable[[Any, Any], Any], int, int]


@dataclass(frozen=True)
class EntrySolution:
    """All unknowns of a frame of one entry that loads reach, none of whose pivots is suspicious.

    Attributes
    ----------
    displacements
        Of all nodes in global axes, (nodes, 6).
    unknowns
        By number.
    component
        Of every unknown.
    excited
        Components that the loads reach.
    least
        By excited component: least ratio of a pivot to the stiffness whose rounding it carries.
    method
        How a plan would be solved, and why.
    again
        Whether what does not depend on the loads was taken up from other loads.
    """

    displacements: Array
    unknowns: dict[int, Value]
    component: dict[int, int]
    excited: frozenset[int]
    least: dict[int, Value]
    method: Method
    again: bool

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Value of each of `rows` over the unknowns and the right-hand-side parameter one."""
        return values_of(rows, self.component, self.excited, self.unknowns)


@dataclass(frozen=True)
class EntryProgram:
    """Operations on numbers in the order of their places: what is given, constants, and what each step makes.

    Attributes
    ----------
    edges, turns
        Places, among the numbers of a frame, of those that are given.
    members
        By stack of members: places of the entries that are given.
    constants
        Numbers that are part of the program.
    shared
        Steps that the loads have no part in.
    loads
        Places of those that are given, among the loads.
    loaded
        The other steps.
    nodes
        Places of the displacements of all nodes, six by six.
    unknowns, least
        Places of unknowns and of least pivot ratios.
    component, excited, method
        As of an `EntrySolution`.
    """

    edges: tuple[int, ...]
    turns: tuple[int, ...]
    members: tuple[Any, ...]
    constants: tuple[Value, ...]
    shared: tuple[Step, ...]
    loads: tuple[int, ...]
    loaded: tuple[Step, ...]
    nodes: tuple[int, ...]
    unknowns: dict[int, int]
    least: dict[int, int]
    component: dict[int, int]
    excited: frozenset[int]
    method: Method

    def run(self, numbers: EntryNumbers, loads: EntryLoads, *, compiled: bool) -> EntrySolution | None:
        """The solution of a frame, step by step or `compiled`; None where a pivot is suspicious."""
        former = numbers.former
        again = former is not None and former[0] is self and former[1] is compiled
        with np.errstate(all="ignore"):
            if former is not None and again:
                state = former[2]
            else:
                given = self._given(numbers)
                state = self.code[0](given) if compiled else carried_out(self.shared, given)
            places = self.least.values()
            ratios = [state[k] for k in range(len(places))] if compiled else [state[place] for place in places]
            for ratio in ratios:
                if not ratio > SUSPECT:
                    return None
            numbers.former = self, compiled, state
            pushes = [loads.values[k] for k in self.loads]
            if compiled:
                nodes, known = self.code[1](state, pushes)
            else:
                values = carried_out(self.loaded, [*state, *pushes])
                nodes, known = [values[k] for k in self.nodes], [values[k] for k in self.unknowns.values()]
            found = np.array(nodes, dtype=np.float64).reshape(-1, 6)
        unknowns, least = dict(zip(self.unknowns, known, strict=True)), dict(zip(self.least, ratios, strict=True))
        return EntrySolution(found, unknowns, self.component, self.excited, least, self.method, again)

    def _given(self, numbers: EntryNumbers) -> list[Any]:
        values: list[Any] = [numbers.edges[k] for k in self.edges]
        values += [numbers.turns[k] for k in self.turns]
        for stack, places in zip(numbers.stacks, self.members, strict=True):
            values += stack.reshape(-1)[places].tolist()
        values += self.constants
        return values

    @cached_property
    def code(self) -> tuple[Callable[[list[Any]], list[Any]], Callable[[list[Any], list[Any]], Any]]:
        """Both parts as functions of Python, which takes some ten milliseconds; the first begins with the ratios."""
        size = len(self.edges) + len(self.turns) + sum(map(len, self.members)) + len(self.constants)
        first = size + len(self.shared)
        wanted = [*self.nodes, *self.unknowns.values()]
        used = {k for _, a, b in self.loaded for k in (a, b)}.union(wanted)
        kept = [*self.least.values(), *sorted(k for k in used if k < first)]
        source = [
            "def shared(given):",
            f" {_names(range(size))} = given",
            *_lines(self.shared, size),
            f" return {_names(kept)}",
            "def loaded(kept, loads):",
            f" {_names(kept)} = kept",
            f" {_names(range(first, first + len(self.loads)))} = loads",
            *_lines(self.loaded, first + len(self.loads)),
            f" return {_names(self.nodes)}, {_names(self.unknowns.values())}",
        ]
        made: dict[str, Any] = {"wide": Extended, "inf": np.inf}
        exec(compile("\n".join(source), "<frame>", "exec"), made)
        return made["shared"], made["loaded"]


def carried_out(steps: Sequence[Step], given: list[Any]) -> list[Any]:
    """All numbers: what is given, and what each step makes."""
    values = list(given)
    put = values.append
    for operation, a, b in steps:
        put(operation(values[a], values[b]))
    return values


def _names(places: Iterable[int]) -> str:
    return "[" + ", ".join(f"v{place}" for place in places) + "]"


def _lines(steps: Sequence[Step], first: int) -> list[str]:
    return [f" v{first + k} = " + _TEXTS[do].format(a=f"v{a}", b=f"v{b}") for k, (do, a, b) in enumerate(steps)]


def values_of(
    rows: Sequence[Row], component: dict[int, int], excited: frozenset[int] | set[int], known: dict[int, Value]
) -> list[Value]:
    """Values of rows: of each the known part, and then the sum over each component that loads reach."""
    split: dict[int, dict[int, Row]] = {}
    for index, row in enumerate(rows):
        for k in unknowns(row):
            if component[k] in excited:
                split.setdefault(component[k], {}).setdefault(index, {})[k] = row[k]
    terms: list[list[tuple[Value, Value]]] = [[(value, 1.0) for k, value in row.items() if k < 0] for row in rows]
    for parts in split.values():
        for index, part in parts.items():
            terms[index].append((1.0, combine([(factor, known[k]) for k, factor in part.items()])))
    return [combine(term) for term in terms]


def widen(a: Any, _: Any) -> Any:
    return Extended(a)


def _divided(a: Any, b: Any) -> Any:
    """a / b; of an exact zero inf, as `reciprocal` has it."""
    return a / b if b else np.inf


def _negative(a: Any, _: Any) -> Any:
    return -a


def _least(a: Any, b: Any) -> Any:
    """As NumPy has it: what is none is the least."""
    return b if b < a or b != b else a


def _most(a: Any, b: Any) -> Any:
    return b if b > a or b != b else a


OPERATIONS: dict[Operation, Callable[[Any, Any], Any]] = {
    Operation.ADD: operator.add,
    Operation.SUBTRACT: operator.sub,
    Operation.MULTIPLY: operator.mul,
    Operation.DIVIDE: _divided,
    Operation.NEGATE: _negative,
    Operation.MINIMUM: _least,
    Operation.MAXIMUM: _most,
}
# The same in words of Python.
_TEXTS: dict[Callable[[Any, Any], Any], str] = {
    operator.add: "{a} + {b}",
    operator.sub: "{a} - {b}",
    operator.mul: "{a} * {b}",
    widen: "wide({a})",
    _divided: "{a} / {b} if {b} else inf",
    _negative: "-{a}",
    _least: "{b} if {b} < {a} or {b} != {b} else {a}",
    _most: "{b} if {b} > {a} or {b} != {b} else {a}",
}
