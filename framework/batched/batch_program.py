"""The solution of a short batch as a list of arithmetic operations, run by NumPy or as machine code.

The operations, their order and their precision are those without a program, so that results are the same to the last
bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..solvers.method import Method
from ..structure.parts import Extended, Value
from .batch_machine import BatchMachineCode
from .batch_numbers import BatchLoads, BatchNumbers
from .entry_program import EntrySolution, Way
from .entry_steps import Step
from .numpy_calls import NumpyCalls, carry_out
from .stage import SUSPECT


class BatchProgramFacts(Protocol):
    """What a program for batches knows of the frame."""

    @property
    def parameters(self) -> tuple[tuple[bool, int], ...]:
        """For each right-hand-side parameter but the first: whether it is a load, and its index."""
        ...

    @property
    def unknowns(self) -> Mapping[int, object]:
        """The unknowns by number."""
        ...

    @property
    def component(self) -> dict[int, int]:
        """As of an `EntrySolution`."""
        ...

    @property
    def excited(self) -> frozenset[int]:
        """As of an `EntrySolution`."""
        ...

    @property
    def method(self) -> Method:
        """As of an `EntrySolution`."""
        ...


class BatchResults(Protocol):
    """Results of a program for a batch."""

    def node(self, number: int) -> Array:
        """Displacements of a node, (..., 6)."""
        ...

    def known(self) -> list[Value]:
        """The unknowns."""
        ...


def batch_solution(
    program: BatchProgramFacts,
    results: BatchResults,
    numbers: BatchNumbers,
    loads: BatchLoads,
    way: Way,
    size: int,
    *,
    again: bool,
) -> EntrySolution:
    """The solution of a batch by the results of a program of so many steps, run in the given way."""
    parameters = [(loads if load else numbers).values([k])[0] for load, k in program.parameters]
    return EntrySolution(
        displacements=None,
        numbers=program.unknowns,
        known=results.known,
        component=program.component,
        excited=program.excited,
        ratios=[],
        method=program.method,
        again=again,
        way=way,
        size=size,
        node=results.node,
        parameters=[1.0, *parameters],
        shape=numbers.grid.shape,
    )


@dataclass(frozen=True)
class BatchProgram:
    """A program for all batches of one topology and shape.

    Its numbers are identified by their place in the order: given numbers, constants, results of the shared steps,
    loads, results of the loaded steps.

    Attributes
    ----------
    given, wide
        Which of the frame's numbers are given to the program, and whether each is converted to extended precision.
    constants
        Constants of the program.
    shared
        Steps that do not depend on the loads.
    loads
        Which of the loads are given to the program.
    widths
        How many numbers and how many loads there are, given ones and others.
    loaded
        Steps that depend on the loads.
    nodes
        Places of the displacements of all nodes, six for each.
    unknowns, least
        Places of the unknowns by number, and of the least pivot ratios of the components.
    parameters
        For each right-hand-side parameter but the first: whether it is a load, and its index.
    component, excited, method
        As of an `EntrySolution`.
    """

    given: tuple[int, ...]
    wide: tuple[bool, ...]
    constants: tuple[Value, ...]
    shared: tuple[Step, ...]
    loads: tuple[int, ...]
    loaded: tuple[Step, ...]
    widths: tuple[int, int]
    nodes: tuple[int, ...]
    unknowns: dict[int, int]
    least: tuple[int, ...]
    parameters: tuple[tuple[bool, int], ...]
    component: dict[int, int]
    excited: frozenset[int]
    method: Method

    def run(self, numbers: BatchNumbers, loads: BatchLoads, way: Way) -> EntrySolution | None:
        """The solution of a batch, its steps run in the given way; None where a pivot is close to rounding."""
        found: tuple[InTables | InLists, bool] | None
        with np.errstate(all="ignore"):
            found = self._by_machine(numbers, loads) if way is Way.MACHINE else self._by_numpy(numbers, loads)
        if found is None:
            return None
        results, again = found
        size = len(self.shared) + len(self.loaded)
        return batch_solution(self, results, numbers, loads, way, size, again=again)

    def _by_machine(self, numbers: BatchNumbers, loads: BatchLoads) -> tuple[InTables, bool] | None:
        nodes, others = self.machine.run(numbers.table, loads.table)
        count = len(self.least)
        if not (others[:, :count] > SUSPECT).all():
            return None
        return InTables(numbers.grid.shape, nodes, others[:, count:]), False

    @cached_property
    def machine(self) -> BatchMachineCode:
        """The steps as machine code."""
        given = dict(zip(self.given, self.wide, strict=True))
        steps = self.shared, self.loads, self.loaded
        asked = [*self.least, *self.unknowns.values()]
        return BatchMachineCode(given, self.constants, *steps, self.widths, self.nodes, asked)

    def _by_numpy(self, numbers: BatchNumbers, loads: BatchLoads) -> tuple[InLists, bool] | None:
        former, calls = numbers.former, self.calls
        again = former is not None and former[0] is self
        if former is not None and again:
            values = list(former[1])
        else:
            values = self._begun(numbers)
            carry_out(calls.shared, values)
            if not all(np.all(values[k] > SUSPECT) for k in self.least):
                return None
            numbers.former = self, list(values)
        values[calls.first : calls.first + len(self.loads)] = loads.values(self.loads)
        carry_out(calls.loaded, values)
        return InLists(numbers.grid.shape, self, values), again

    def _begun(self, numbers: BatchNumbers) -> list[Any]:
        """A list for all numbers, with those given to the program and its constants."""
        each = zip(numbers.values(self.given), self.wide, strict=True)
        given = [np.asarray(value).astype(Extended) if wide else value for value, wide in each]
        rest = len(self.shared) + len(self.loads) + len(self.loaded)
        return [*given, *self.constants, *([None] * rest)]

    @cached_property
    def calls(self) -> NumpyCalls:
        """The steps as calls of NumPy."""
        known = [*self.unknowns.values()]
        begin = len(self.given) + len(self.constants)
        return NumpyCalls(begin, self.shared, len(self.loads), self.loaded, self.nodes, known, self.least)


class InTables:
    """Results in tables with a row for each entry.

    Parameters
    ----------
    shape
        Batch shape.
    nodes
        Displacements of all nodes, (entries, 6 nodes).
    unknowns
        The unknowns, (entries, n).
    """

    def __init__(self, shape: Shape, nodes: Array, unknowns: NDArray[Any]) -> None:
        self._shape, self._nodes, self._unknowns = shape, nodes, unknowns

    def node(self, number: int) -> Array:
        """Displacements of a node, (..., 6)."""
        return self._nodes[:, 6 * number : 6 * number + 6].reshape(*self._shape, 6)

    def known(self) -> list[Value]:
        """The unknowns, each of the batch shape."""
        return [each.reshape(self._shape) for each in np.ascontiguousarray(self._unknowns.T)]


class InLists:
    """Results in a list of all numbers of a program, completed as displacements of nodes are read.

    Parameters
    ----------
    shape
        Batch shape.
    program
        The program.
    values
        The numbers by place, as far as they are still needed.
    """

    def __init__(self, shape: Shape, program: BatchProgram, values: list[Any]) -> None:
        self._shape, self._program, self._values = shape, program, values

    def node(self, number: int) -> Array:
        """Displacements of a node, (..., 6)."""
        own = list(self._values)
        with np.errstate(all="ignore"):
            carry_out(self._program.calls.of_node(number), own)
        out = np.empty((6, *self._shape))
        for k, place in enumerate(self._program.nodes[6 * number : 6 * number + 6]):
            out[k] = own[place]
        return np.moveaxis(out, 0, -1)

    def known(self) -> list[Value]:
        """The unknowns, each of the shape over which it varies."""
        return [self._values[k] for k in self._program.unknowns.values()]

    def __reduce__(self) -> tuple[type[InTables], tuple[Any, ...]]:
        """As tables: another process need not have the program."""
        count = math.prod(self._shape)
        nodes = [self.node(k).reshape(count, 6) for k in range(len(self._program.nodes) // 6)]
        known = [np.broadcast_to(np.asarray(value, Extended), self._shape).reshape(count) for value in self.known()]
        return InTables, (self._shape, np.concatenate(nodes, axis=1), np.array(known, Extended).reshape(-1, count).T)
