"""The solution of a short batch as a list of arithmetic operations, run by NumPy or as machine code.

The operations, their order and their precision are those without a program, so that results are the same to the last
bit.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
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
from .numpy_calls import NumpyCalls, carry_out
from .stage import SUSPECT
from .step_layout import StepLayout


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
        parameters=parameters_of(program, numbers, loads),
        shape=numbers.grid.shape,
    )


def parameters_of(program: BatchProgramFacts, numbers: BatchNumbers, loads: BatchLoads) -> list[Value]:
    """Values of the right-hand-side parameters of a batch."""
    return [1.0, *[(loads if load else numbers).value(k) for load, k in program.parameters]]


class Steps:
    """The steps of a program by NumPy, those that do not depend on the loads once for all loads.

    Parameters
    ----------
    layout
        The steps.
    least
        Places of the least pivot ratios.
    needed
        Places of the other numbers that all results need.
    groups
        Places of each group of numbers that are asked for together.
    """

    def __init__(
        self, layout: StepLayout, least: Sequence[int], needed: Sequence[int], groups: Sequence[Sequence[int]]
    ) -> None:
        self.layout, self._least = layout, least
        begin = len(layout.given) + len(layout.constants)
        self.calls = NumpyCalls(begin, layout.shared, len(layout.loads), layout.loaded, [*least, *needed], groups)

    def run(self, numbers: BatchNumbers, loads: BatchLoads) -> tuple[list[Any], bool] | None:
        """The numbers by place, as far as all results need them, and whether those without the loads were known.

        None where a pivot is close to rounding.
        """
        former, calls, layout = numbers.former, self.calls, self.layout
        again = former is not None and former[0] is self
        if former is not None and again:
            values = list(former[1])
        else:
            values = self._begun(numbers)
            carry_out(calls.shared, values)
            if not all(np.all(values[k] > SUSPECT) for k in self._least):
                return None
            numbers.former = self, list(values)
        values[calls.first : calls.first + len(layout.loads)] = loads.values(layout.loads)
        carry_out(calls.loaded, values)
        return values, again

    @property
    def size(self) -> int:
        """Number of the steps that all results need."""
        return len(self.calls.shared) + len(self.calls.loaded)

    def of_group(self, index: int, values: Sequence[Any]) -> list[Any]:
        """The numbers by place, those of a group among them, from those that `run` returned."""
        own = list(values)
        with np.errstate(all="ignore"):
            carry_out(self.calls.of_group(index), own)
        return own

    def _begun(self, numbers: BatchNumbers) -> list[Any]:
        """A list for all numbers, with those given to the program and its constants."""
        layout = self.layout
        each = zip(numbers.values(layout.given), layout.wide, strict=True)
        given = [np.asarray(value).astype(Extended) if wide else value for value, wide in each]
        return [*given, *layout.constants, *([None] * (layout.size + len(layout.loads)))]


@dataclass(frozen=True)
class BatchProgram:
    """A program for all batches of one topology and shape.

    Attributes
    ----------
    layout
        The steps, with a place for each number.
    widths
        How many numbers and how many loads there are, given ones and others.
    nodes
        Places of the displacements of all nodes, six for each.
    unknowns, least
        Places of the unknowns by number, and of the least pivot ratios of the components.
    parameters
        For each right-hand-side parameter but the first: whether it is a load, and its index.
    component, excited, method
        As of an `EntrySolution`.
    """

    layout: StepLayout
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
        return batch_solution(self, results, numbers, loads, way, self.layout.size, again=again)

    def _by_machine(self, numbers: BatchNumbers, loads: BatchLoads) -> tuple[InTables, bool] | None:
        nodes, others = self.machine.run(numbers.table, loads.table)
        count = len(self.least)
        if not (others[:, :count] > SUSPECT).all():
            return None
        return InTables(numbers.grid.shape, nodes, others[:, count:]), False

    @cached_property
    def machine(self) -> BatchMachineCode:
        """The steps as machine code."""
        layout = self.layout
        given = dict(zip(layout.given, layout.wide, strict=True))
        steps = layout.shared, layout.loads, layout.loaded
        asked = [*self.least, *self.unknowns.values()]
        return BatchMachineCode(given, layout.constants, *steps, self.widths, self.nodes, asked)

    def _by_numpy(self, numbers: BatchNumbers, loads: BatchLoads) -> tuple[InLists, bool] | None:
        found = self.steps.run(numbers, loads)
        if found is None:
            return None
        values, again = found
        return InLists(numbers.grid.shape, self, values), again

    @cached_property
    def steps(self) -> Steps:
        """The steps by NumPy."""
        nodes = [self.nodes[k : k + 6] for k in range(0, len(self.nodes), 6)]
        return Steps(self.layout, self.least, [*self.unknowns.values()], nodes)


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
        own = self._program.steps.of_group(number, self._values)
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
