"""The solution of a medium batch, whose members vary, as a program in double precision."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from ..batch import Array, Shape
from ..entries import Stretch
from ..program.calculation import Calculation, seconds
from ..program.recording import Recording, Term
from ..program.sweep import CHUNK
from ..solvers.method import Method
from ..structure.parts import Value
from .batch_numbers import BatchLoads, BatchNumbers
from .batch_program import batch_solution
from .entry_program import EntrySolution, Way
from .stage import SUSPECT


@dataclass(frozen=True)
class MediumProgram:
    """A program for all medium batches of one topology and shape, which NumPy or machine code runs.

    Attributes
    ----------
    recording
        The recorded operations, whose inputs are the numbers of the frame and then its loads.
    nodes
        Displacements of all nodes, six for each.
    unknowns, least
        The unknowns by number, and the least pivot ratios.
    parameters
        For each right-hand-side parameter but the first: whether it is a load, and its index.
    component, excited, method
        As of an `EntrySolution`.
    """

    recording: Recording
    nodes: Sequence[Value]
    unknowns: dict[int, Value]
    least: Sequence[Value]
    parameters: tuple[tuple[bool, int], ...]
    component: dict[int, int]
    excited: frozenset[int]
    method: Method
    _ways: dict[Way, Calculation] = field(default_factory=dict)

    def pays(self, runs: int) -> bool:
        """Whether so many runs by NumPy take as long as compiling."""
        if Way.STEPS not in self._ways:
            return False
        calculation = self._ways[Way.STEPS]
        numpy, compiling = seconds(calculation.program, calculation.shape)
        return runs * numpy >= compiling

    def run(self, numbers: BatchNumbers, loads: BatchLoads, way: Way) -> EntrySolution | None:
        """The solution of a batch, its steps run in the given way; None where a pivot is close to rounding."""
        shape, asked = numbers.grid.shape, [*self.nodes, *self.unknowns.values(), *self.least]
        if way not in self._ways:
            terms = [value for value in asked if isinstance(value, Term)]
            self._ways[way] = Calculation.recorded(self.recording, terms, shape, compiled=way is Way.MACHINE)
        calculation = self._ways[way]
        given = _given(calculation, numbers, loads)
        outputs = calculation.places()
        with np.errstate(all="ignore"):
            axis, slices = numbers.grid.slices(CHUNK if way is Way.STEPS else numbers.grid.sizes[-1])
            for indices in slices:
                change = Stretch(ndim=len(shape), axis=axis, indices=indices)
                parts = [change(out, 0) for out in outputs]
                calculation.run(axis, indices, parts, [_of(change, value) for value in given])
        calculation.release()  # the program outlives this batch
        following = iter(outputs)
        found: list[Value] = [next(following) if isinstance(value, Term) else value for value in asked]
        first, second = len(self.nodes), len(self.nodes) + len(self.unknowns)
        if not all(np.all(ratio > SUSPECT) for ratio in found[second:]):
            return None
        results = InArrays(shape, found[:first], found[first:second])
        size = len(calculation.program.steps)
        return batch_solution(self, results, numbers, loads, way, size, again=False)


def _given(calculation: Calculation, numbers: BatchNumbers, loads: BatchLoads) -> list[Value]:
    """Inputs of a calculation, the numbers and then the loads; zero for those that it does not need."""
    count, needed = numbers.count, calculation.needed
    given: list[Value] = [0.0] * (count + loads.count)
    for blocks, start, wanted in (
        (numbers, 0, [k for k in needed if k < count]),
        (loads, count, [k - count for k in needed if k >= count]),
    ):
        for k, value in zip(wanted, blocks.values(wanted), strict=True):
            given[start + k] = value
    return given


def _of(change: Stretch, value: Value) -> Value:
    return change(value, 0) if isinstance(value, np.ndarray) else value


class InArrays:
    """Results as arrays, each of the shape over which it varies.

    Parameters
    ----------
    shape
        Batch shape.
    nodes
        Displacements of all nodes, six for each.
    unknowns
        The unknowns.
    """

    def __init__(self, shape: Shape, nodes: Sequence[Value], unknowns: list[Value]) -> None:
        self._shape, self._nodes, self._unknowns = shape, nodes, unknowns

    def node(self, number: int) -> Array:
        """Displacements of a node, (..., 6)."""
        out = np.empty((6, *self._shape))
        for k, value in enumerate(self._nodes[6 * number : 6 * number + 6]):
            out[k] = value
        return np.moveaxis(out, 0, -1)

    def known(self) -> list[Value]:
        """The unknowns."""
        return self._unknowns
