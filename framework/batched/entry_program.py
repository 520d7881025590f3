"""The solution of a frame of one entry as a list of operations, in two parts: what depends on its loads, and what does
not, which other loads take up.

The list is run with plain numbers, each in the precision that it has in the calculation itself: the same operations in
the same order, and so the same bits.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from dataclasses import dataclass
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
        """Value of each of `rows` over the unknowns and the known number one."""
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

    def run(self, numbers: EntryNumbers, loads: EntryLoads) -> EntrySolution | None:
        """The solution of a frame; None where a pivot is suspicious."""
        former = numbers.former
        again = former is not None and former[0] is self
        with np.errstate(all="ignore"):
            shared = former[1] if former is not None and again else self._shared(numbers)
            least = {name: shared[place] for name, place in self.least.items()}
            if not all(ratio > SUSPECT for ratio in least.values()):
                return None
            numbers.former = self, shared
            values = [*shared, *(loads.values[k] for k in self.loads)]
            _carry_out(self.loaded, values)
            found = np.array([values[k] for k in self.nodes], dtype=np.float64).reshape(-1, 6)
        known = {k: values[place] for k, place in self.unknowns.items()}
        return EntrySolution(found, known, self.component, self.excited, least, self.method, again)

    def _shared(self, numbers: EntryNumbers) -> list[Any]:
        values: list[Any] = [numbers.edges[k] for k in self.edges]
        values += [numbers.turns[k] for k in self.turns]
        for stack, places in zip(numbers.stacks, self.members, strict=True):
            values += stack.reshape(-1)[places].tolist()
        values += self.constants
        _carry_out(self.shared, values)
        return values


def _carry_out(steps: Sequence[Step], values: list[Any]) -> None:
    put = values.append
    for operation, a, b in steps:
        put(operation(values[a], values[b]))


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
