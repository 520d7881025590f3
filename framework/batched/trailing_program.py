"""The solution of a medium batch whose members are the same for many of its entries.

What many entries share is a program: joint tree, assembly, and elimination up to the trailing unknowns. These follow as
without a program, by matrix products.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, cast

import numpy as np

from ..batch import Array, Shape
from ..ldl import Pivot
from ..program.recording import Term
from ..solvers.method import Method
from ..structure.parts import Row, Value, sums
from .batch_numbers import BatchLoads, BatchNumbers
from .batch_program import Steps, batch_solution, parameters_of
from .block import Block
from .block_factor import BlockFactor
from .entry_program import EntrySolution, Way, divided_rows
from .entry_recording import TermPlan
from .partial_factorisation import PartialFactorisation
from .stage import SUSPECT, mapped_row
from .step_layout import StepLayout


class Place(int):
    """The place of a number among those of a program, where the number itself is to stand."""


@dataclass(frozen=True)
class CarriedRows:
    """Rows over the unknowns and the right-hand-side parameters.

    Attributes
    ----------
    direct
        For each row, its part over the right-hand-side parameters.
    carried
        By component and by index of the row: the part over its unknowns, expressed in the trailing ones.
    """

    direct: list[Row]
    carried: dict[int, dict[int, Row]]

    @classmethod
    def of(
        cls, rows: Sequence[Row], component: Mapping[int, int], factors: Mapping[int, PartialFactorisation]
    ) -> CarriedRows:
        """Rows carried by the factorisations of the loaded components."""
        split, direct = divided_rows(rows, component, factors)
        carried = {
            name: {index: factors[name].carried(part) for index, part in parts.items()} for name, parts in split.items()
        }
        return cls(direct, carried)

    def mapped(self, change: Callable[[Value], Value]) -> CarriedRows:
        """The same with `change` applied to every number."""
        carried = {
            name: {index: mapped_row(row, change) for index, row in parts.items()}
            for name, parts in self.carried.items()
        }
        return CarriedRows([mapped_row(row, change) for row in self.direct], carried)

    def values(
        self, factors: Mapping[int, BlockFactor], parameters: Sequence[Value], places: Sequence[Array]
    ) -> list[Value]:
        """Values of the rows, which may be written into the arrays `places`, one for each."""
        terms = [[(value, parameters[-1 - k]) for k, value in row.items()] for row in self.direct]
        for name, parts in self.carried.items():
            mine = [places[k] if places and len(self.carried) == 1 and not terms[k] else None for k in parts]
            found = factors[name].from_trailing(list(parts.values()), mine)
            for index, value in zip(parts, found, strict=True):
                terms[index].append((1.0, value))
        return sums(terms)


@dataclass(frozen=True)
class TrailingProgram:
    """A program for all medium batches of one topology and shape whose members are the same for many entries.

    Attributes
    ----------
    layout
        The steps, with a place for each number.
    blocks
        By component: the block without numbers.
    shared
        By component: its factorisation as far as entries share it, with the places of its numbers.
    nodes
        By number of the node: the rows of its displacements, with the places of their numbers.
    least
        Places of the least pivot ratios of what entries share.
    parameters
        For each right-hand-side parameter but the first: whether it is a load, and its index.
    component, excited, method
        As of an `EntrySolution`.
    """

    layout: StepLayout
    blocks: dict[int, Block]
    shared: dict[int, PartialFactorisation]
    nodes: list[CarriedRows]
    least: tuple[int, ...]
    parameters: tuple[tuple[bool, int], ...]
    component: dict[int, int]
    excited: frozenset[int]
    method: Method

    @property
    def unknowns(self) -> Mapping[int, object]:
        """The unknowns in loaded components by number."""
        return {k: None for k, name in self.component.items() if name in self.excited}

    @cached_property
    def steps(self) -> Steps:
        """The steps by NumPy; the numbers of each node are a group, and those of all factorisations are the last."""
        groups = [*[_places_of([rows]) for rows in self.nodes], _places_of(self.shared.values())]
        return Steps(self.layout, self.least, _places_of(self._trailing.values()), groups)

    @cached_property
    def _trailing(self) -> dict[int, PartialFactorisation]:
        """`shared`, with the equations of the trailing unknowns alone."""
        return {name: _trailing(progress) for name, progress in self.shared.items()}

    def factorisations(self, values: Sequence[Any]) -> dict[int, PartialFactorisation]:
        """By component: its factorisation as far as entries share it, from the numbers that `steps` returned."""
        number = numbered(self.steps.of_group(len(self.nodes), values))
        return {name: progress.mapped(number) for name, progress in self.shared.items()}

    def run(self, numbers: BatchNumbers, loads: BatchLoads, way: Way) -> EntrySolution | None:
        """The solution of a batch, its steps run by NumPy whatever the way; None where a pivot is close to rounding."""
        with np.errstate(all="ignore"):
            found = self.steps.run(numbers, loads)
            if found is None:
                return None
            values, again = found
            parameters = parameters_of(self, numbers, loads)
            factors = {name: self._factor(name, values, parameters) for name in self.blocks}
            if not all(np.all(factor.trailing_least() > SUSPECT) for factor in factors.values()):
                return None
        results = FromTrailing(self, numbers.grid.shape, values, factors, parameters)
        solution = batch_solution(self, results, numbers, loads, Way.STEPS, self.steps.size, again=again)
        solution.of_rows = results.rows
        return solution

    def _factor(self, name: int, values: Sequence[Any], parameters: list[Value]) -> BlockFactor:
        shared = replace(self._trailing[name].mapped(numbered(values)), rhs_parameters=parameters)
        return BlockFactor(self.blocks[name], shared=shared)


def trailing_program(
    written: TermPlan,
    blocks: Mapping[int, Block],
    layout: Callable[[Sequence[Value]], StepLayout],
    parameters: tuple[tuple[bool, int], ...],
    method: Method,
) -> TrailingProgram | None:
    """The program of a batch whose numbers are terms.

    Parameters
    ----------
    written
        The plan of the batch.
    blocks
        The blocks of its loaded components, by component.
    layout
        Function that returns the steps for some terms.
    parameters, method
        As of the program.

    Returns
    -------
    TrailingProgram or None
        The program; None where more than the trailing unknowns varies over many entries, the batch has several chunks,
        or a pivot is zero whatever the numbers.
    """
    factors = {name: BlockFactor(block) for name, block in blocks.items()}
    if not all(factor.only_trailing and factor.chunks == 1 for factor in factors.values()):
        return None
    begun = {name: _kept(factor.shared) for name, factor in factors.items()}
    least = [progress.least for progress in begun.values()]
    if not all(isinstance(value, Term) or value > SUSPECT for value in least):
        return None
    tree = written.tree
    each = [tree.global_rows(node) for node in range(len(tree.topology.number))]
    nodes = [CarriedRows.of(rows, written.component, begun) for rows in each]
    terms = {
        value.number: value for value in [*_numbers_of([*begun.values(), *nodes]), *least] if isinstance(value, Term)
    }
    found = layout(cast(list[Value], [*terms.values()]))
    place = placed(dict(zip(terms, found.outputs, strict=True)))
    return TrailingProgram(
        layout=found,
        blocks={name: _bare(block) for name, block in blocks.items()},
        shared={name: progress.mapped(place) for name, progress in begun.items()},
        nodes=[rows.mapped(place) for rows in nodes],
        least=tuple(int(place(value)) for value in least if isinstance(value, Term)),
        parameters=parameters,
        component=written.component,
        excited=frozenset(written.excited),
        method=method,
    )


class FromTrailing:
    """Results of a batch from the trailing unknowns of its components.

    Parameters
    ----------
    program
        The program.
    shape
        Batch shape.
    values
        Its numbers by place, as far as all results need them.
    factors
        The factors by component.
    parameters
        Values of the right-hand-side parameters.
    """

    def __init__(
        self,
        program: TrailingProgram,
        shape: Shape,
        values: Sequence[Any],
        factors: dict[int, BlockFactor],
        parameters: list[Value],
    ) -> None:
        self._program, self._shape, self._values = program, shape, values
        self._factors, self._parameters = factors, parameters

    def node(self, number: int) -> Array:
        """Displacements of a node, (..., 6)."""
        program = self._program
        own = program.steps.of_group(number, self._values)
        out = np.zeros((6, *self._shape))
        places = [out[k] for k in range(6)]
        rows = program.nodes[number].mapped(numbered(own))
        for place, value in zip(places, rows.values(self._factors, self._parameters, places), strict=True):
            if value is not place:
                place[...] = value
        return np.moveaxis(out, 0, -1)

    def known(self) -> list[Value]:
        """The unknowns."""
        return self.rows([{k: 1.0} for k in self._program.unknowns])

    def rows(self, rows: Sequence[Row]) -> list[Value]:
        """Values of rows over the unknowns and the right-hand-side parameters."""
        carried = CarriedRows.of(rows, self._program.component, self._shared)
        return carried.values(self._factors, self._parameters, ())

    @cached_property
    def _shared(self) -> dict[int, PartialFactorisation]:
        return self._program.factorisations(self._values)


def numbered(values: Sequence[Any]) -> Callable[[Value], Value]:
    """The function that puts a number of a program in place of its place."""
    return lambda value: values[value] if isinstance(value, Place) else value


def placed(outputs: Mapping[int, int]) -> Callable[[Value], Value]:
    """The function that puts the place of a number of a program in place of its term."""
    return lambda value: cast(Value, Place(outputs[value.number])) if isinstance(value, Term) else value


def _bare(block: Block) -> Block:
    """A block without its numbers."""
    return Block(block.grid, block.orders, block.masks, {}, {}, {}, {}, [], [])


def _kept(progress: PartialFactorisation) -> PartialFactorisation:
    """What the trailing unknowns need of a factorisation, and rows over the others."""
    inner = replace(progress.inner, matrix={}, scale={})
    return replace(progress, inner=inner, springs=[], rhs_parameters=[], imposed={})


def _trailing(progress: PartialFactorisation) -> PartialFactorisation:
    """The equations that a factorisation leaves, with the masks of its steps, but without their numbers."""
    inner, outer = progress.inner, progress.outer
    forces = {k: loads for k, loads in outer.forces.items() if k not in outer.pivots}
    left = replace(outer, forces=forces, pivots=_masks(outer.pivots))
    return replace(progress, inner=replace(inner, forces={}, pivots=_masks(inner.pivots)), outer=left, rows={})


def _masks(pivots: Mapping[int, Pivot]) -> dict[int, Pivot]:
    return {k: Pivot(step.mask, 0.0, {}) for k, step in pivots.items()}


def _places_of(parts: Iterable[PartialFactorisation | CarriedRows]) -> list[int]:
    """All places in some parts of a program."""
    return sorted({int(value) for value in _numbers_of(parts) if isinstance(value, Place)})


def _numbers_of(parts: Iterable[PartialFactorisation | CarriedRows]) -> list[Value]:
    """All numbers in some parts of a program."""
    found: list[Value] = []

    def note(value: Value) -> Value:
        found.append(value)
        return value

    for part in parts:
        part.mapped(note)
    return found
