"""The solution of a frame with a single batch entry as a list of arithmetic operations.

The list has two parts: the first does not depend on the loads, and its results serve other loads as well. It is run
with single numbers, each in the precision of the original calculation, in the same order, so that results are the same
to the last bit.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass
from enum import Enum
from functools import cached_property, partial
from typing import Any

import numpy as np

from ..batch import Array, Shape
from ..solvers.method import Method
from ..structure.parts import Extended, Row, Value, combine
from .entry_machine import EntryMachineCode
from .entry_steps import EntryCode, Step, carried_out
from .one_entry import EntryLoads, EntryNumbers
from .stage import SUSPECT


class Way(Enum):
    """How the steps are run, in words."""

    STEPS = "by Python one by one"
    COMPILED = "as Python functions"
    MACHINE = "as machine code"


def _of_a_batch(number: int) -> Array:
    raise ValueError(f"node {number} of a single batch entry: read `displacements`")


@dataclass(eq=False)
class EntrySolution:
    """The solution of a frame by a program, all of whose pivots are well above rounding.

    Attributes
    ----------
    displacements
        Displacements of all nodes of a single batch entry in global axes, (nodes, 6); None of a batch.
    numbers
        Numbers of the unknowns in loaded components.
    known
        Function that returns their values.
    component
        Connected component of every unknown, by its number.
    excited
        Components that loads reach.
    ratios
        Least pivot ratio of each of these components.
    method
        Method by which the plan would be solved otherwise, and why.
    again
        Whether the part that is independent of the loads was reused from an earlier solution.
    way, size
        How the steps of the program were run, and how many there are.
    node
        Function from the number of a node to its displacements in global axes, (..., 6), for a batch.
    parameters
        Right-hand-side parameters.
    shape
        Batch shape.
    of_rows
        Function that returns the values of rows over the unknowns and the right-hand-side parameters, where they do not
        follow from `known`; else None.
    """

    displacements: Array | None
    numbers: Iterable[int]
    known: Callable[[], Sequence[Value]]
    component: dict[int, int]
    excited: frozenset[int]
    ratios: Sequence[Value]
    method: Method
    again: bool
    way: Way
    size: int
    node: Callable[[int], Array] = _of_a_batch
    parameters: Sequence[Value] = (1.0,)
    shape: Shape = ()
    of_rows: Callable[[Sequence[Row]], list[Value]] | None = None

    @property
    def ran(self) -> str:
        """How the program was run, in words."""
        if self.displacements is not None:
            return f"{self.size} steps, recorded for all frames of this topology, {self.way.value}"
        how = "as machine code" if self.way is Way.MACHINE else "by NumPy one by one"
        numbers = f"{math.prod(self.shape)} entries" if self.of_rows is None else "what entries share"
        return f"{self.size} steps on {numbers}, recorded for all batches of this topology and shape, {how}"

    @cached_property
    def unknowns(self) -> dict[int, Value]:
        """Values of the unknowns by number."""
        return dict(zip(self.numbers, self.known(), strict=True))

    def values(self, rows: Sequence[Row]) -> list[Value]:
        """Values of rows over the unknowns and the right-hand-side parameters."""
        if self.of_rows is not None:
            return self.of_rows(rows)
        return values_of(rows, self.component, self.excited, self.unknowns, self.parameters)


@dataclass(frozen=True)
class EntryProgram:
    """A program for all frames of one topology with a single batch entry.

    Its numbers are identified by their place in the order: given numbers, constants, results of the shared steps,
    loads, results of the loaded steps.

    Attributes
    ----------
    edges, turns
        Which of the frame's numbers of joints, ties and supports, and of its axes and arms, see `EntryLinks`, are
        given to the program.
    members
        For each stack of member matrices, which of its entries are given to the program.
    constants
        Constants of the program.
    shared
        Steps that do not depend on the loads.
    loads
        Which of the frame's loads are given to the program.
    loaded
        Steps that depend on the loads.
    nodes
        Places of the displacements of all nodes, six for each.
    unknowns, least
        Places of the unknowns by number, and of the least pivot ratios by component.
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
        """The solution of a frame, its steps run in the given way; None where a pivot is close to rounding."""
        former = numbers.former
        again = former is not None and former[0] is self and former[1] is way
        # machine code does not raise floating-point warnings
        with nullcontext() if way is Way.MACHINE else np.errstate(all="ignore"):
            ratios, state = former[2] if former is not None and again else self._shared(numbers, way)
            for ratio in ratios:
                if not ratio > SUSPECT:
                    return None
            numbers.former = self, way, (ratios, state)
            nodes, known = self._loaded(state, [loads.values[k] for k in self.loads], way)
        found = self.unknowns, known, self.component, self.excited, ratios, self.method
        return EntrySolution(nodes, *found, again, way, self.size)

    def _shared(self, numbers: EntryNumbers, way: Way) -> tuple[list[Any], Any]:
        """Run the first part: the pivot ratios, and the state for the second part."""
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
        """Run the second part: displacements of all nodes, (nodes, 6), and a function that returns the unknowns."""
        if way is Way.MACHINE:
            return self.machine.loaded(state, pushes)
        if way is Way.COMPILED:
            nodes, known = self.code.loaded(state, pushes)
        else:
            values = carried_out(self.loaded, [*state, *pushes])
            nodes, known = [values[k] for k in self.nodes], [values[k] for k in self.unknowns.values()]
        # Python converts numbers in extended precision in less than half the time of NumPy
        return np.array([*map(float, nodes)]).reshape(-1, 6), partial(list, known)

    @property
    def size(self) -> int:
        """Number of steps."""
        return len(self.shared) + len(self.loaded)

    @cached_property
    def code(self) -> EntryCode:
        """The steps as compiled Python functions."""
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
    rows: Sequence[Row],
    component: dict[int, int],
    excited: frozenset[int] | set[int],
    known: dict[int, Value],
    parameters: Sequence[Value] = (1.0,),
) -> list[Value]:
    """Values of rows: for each the sum of its constant terms and of its terms in each loaded component."""
    split, direct = divided_rows(rows, component, excited)
    terms: list[list[tuple[Value, Value]]] = [
        [(value, parameters[-1 - k]) for k, value in row.items()] for row in direct
    ]
    for parts in split.values():
        for index, part in parts.items():
            terms[index].append((1.0, combine([(factor, known[k]) for k, factor in part.items()])))
    return [combine(term) for term in terms]


def divided_rows(
    rows: Sequence[Row], component: Mapping[int, int], excited: Container[int]
) -> tuple[dict[int, dict[int, Row]], list[Row]]:
    """The part of each row over the unknowns of each loaded component, by index of the row, and over the parameters."""
    split: dict[int, dict[int, Row]] = {}
    for index, row in enumerate(rows):
        for k, factor in row.items():
            if k >= 0 and component[k] in excited:
                split.setdefault(component[k], {}).setdefault(index, {})[k] = factor
    return split, [{k: value for k, value in row.items() if k < 0} for row in rows]
