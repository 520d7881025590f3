"""The solution of a frame of one entry as a list of operations, in two parts: what depends on its loads, and what does
not, which other loads take up.

The list is run with plain numbers, each in the precision that it has in the calculation itself: the same operations in
the same order, and so the same bits.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..batch import Array
from ..solvers.method import Method
from ..structure.parts import Extended, Row, Value, combine, unknowns
from .entry_machine import EntryMachineCode
from .entry_steps import EntryCode, Step, carried_out
from .one_entry import EntryLoads, EntryNumbers
from .stage import SUSPECT


class Way(Enum):
    """How the steps are done: one by one, as functions of Python, or as machine code."""

    STEPS, COMPILED, MACHINE = range(3)


@dataclass(eq=False)
class EntrySolution:
    """All unknowns of a frame of one entry that loads reach, none of whose pivots is suspicious.

    Attributes
    ----------
    displacements
        Of all nodes in global axes, (nodes, 6).
    numbers
        Numbers of the unknowns.
    known
        Gives their values.
    component
        Of every unknown.
    excited
        Components that the loads reach.
    ratios
        Of each of these: least ratio of a pivot to the stiffness whose rounding it carries.
    method
        How a plan would be solved, and why.
    again
        Whether what does not depend on the loads was taken up from other loads.
    """

    displacements: Array
    numbers: Iterable[int]
    known: Callable[[], Sequence[Value]]
    component: dict[int, int]
    excited: frozenset[int]
    ratios: Sequence[Value]
    method: Method
    again: bool

    @cached_property
    def unknowns(self) -> dict[int, Value]:
        """Unknowns by number."""
        return dict(zip(self.numbers, self.known(), strict=True))

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

    def run(self, numbers: EntryNumbers, loads: EntryLoads, way: Way) -> EntrySolution | None:
        """The solution of a frame in one of the ways; None where a pivot is suspicious."""
        former = numbers.former
        again = former is not None and former[0] is self and former[1] is way
        # machine code has its own mind about what overflows
        with nullcontext() if way is Way.MACHINE else np.errstate(all="ignore"):
            ratios, state = former[2] if former is not None and again else self._shared(numbers, way)
            for ratio in ratios:
                if not ratio > SUSPECT:
                    return None
            numbers.former = self, way, (ratios, state)
            nodes, known = self._loaded(state, [loads.values[k] for k in self.loads], way)
        return EntrySolution(nodes, self.unknowns, known, self.component, self.excited, ratios, self.method, again)

    def _shared(self, numbers: EntryNumbers, way: Way) -> tuple[list[Any], Any]:
        """The ratios, and all that the second part takes up."""
        links = numbers.links
        narrow: list[Any] = [links.edges[k] for k in self.edges]
        narrow += [links.turns[k] for k in self.turns]
        wide = [stack.reshape(-1)[places] for stack, places in zip(numbers.stacks, self.members, strict=True)]
        if way is Way.MACHINE:
            return self.machine.shared(narrow, np.concatenate(wide, dtype=Extended) if wide else np.zeros(0, Extended))
        given = narrow
        for part in wide:
            given += part.tolist()
        given += self.constants
        if way is Way.COMPILED:
            return self.code.shared(given)
        values = carried_out(self.shared, given)
        return [values[k] for k in self.least.values()], values

    def _loaded(self, state: Any, pushes: list[float], way: Way) -> tuple[Array, Callable[[], Sequence[Value]]]:
        """Displacements of all nodes, and what gives the unknowns."""
        if way is Way.MACHINE:
            return self.machine.loaded(state, pushes)
        if way is Way.COMPILED:
            nodes, known = self.code.loaded(state, pushes)
        else:
            values = carried_out(self.loaded, [*state, *pushes])
            nodes, known = [values[k] for k in self.nodes], [values[k] for k in self.unknowns.values()]
        # of numbers in extended precision Python makes its own in less than half the time of NumPy
        return np.array([*map(float, nodes)]).reshape(-1, 6), partial(list, known)

    @property
    def size(self) -> int:
        """Number of steps."""
        return len(self.shared) + len(self.loaded)

    @cached_property
    def code(self) -> EntryCode:
        """The steps as functions of Python."""
        narrow = len(self.edges) + len(self.turns)
        given = narrow + sum(map(len, self.members)) + len(self.constants)
        return EntryCode(given, *self._parts)

    @cached_property
    def machine(self) -> EntryMachineCode:
        """The steps as machine code."""
        narrow = len(self.edges) + len(self.turns)
        given = [k >= narrow for k in range(narrow + sum(map(len, self.members)))]
        return EntryMachineCode(given, self.constants, *self._parts)

    @property
    def _parts(self) -> tuple[Sequence[Step], int, Sequence[Step], list[int], list[int], Sequence[int]]:
        ratios, known = list(self.least.values()), list(self.unknowns.values())
        return self.shared, len(self.loads), self.loaded, ratios, known, self.nodes


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
