"""Recording of the solution of a batch, once for all batches of its topology and shape.

As for a single entry, joint tree, elimination, substitution and the displacements of all nodes are computed with terms
instead of numbers. The terms vary over the same batch axes as the numbers, so that operations and their order are those
without recording. Joints that close loops are left out: which of them belong to the tree depends on the numbers.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import cast

import numpy as np

from ..cache import PROGRAMS
from ..program.program import Operation
from ..program.recording import Recording, Term
from ..solvers.method import BROADCAST
from ..structure.edge import Edge
from ..structure.forest import spanning
from ..structure.parts import (
    ONE,
    Matrix,
    RightHandSideParameters,
    Row,
    Value,
    add,
    enter_all,
    is_zero,
    mask_of,
    product,
)
from ..structure.tree import JointTree, Matrix3, edges_of
from ..structure.varying import Entry, Springs, Varying
from . import entry_machine
from .batch_numbers import SHARED, BatchLoads, BatchNumbers, PieceNumbers, Piecewise
from .batch_program import BatchProgram
from .block import Block
from .chunks import CHUNK, large_masks
from .entry_program import EntrySolution, Way, values_of
from .entry_recording import TermTree, Writable, square
from .medium_program import MediumProgram
from .member_formulas import ABSENT, MemberFormulas
from .number_blocks import Blocks
from .partial_factorisation import PartialFactorisation
from .replay import MOST, operations
from .stage import Forces, Stage
from .step_layout import StepLayout
from .trailing_program import TrailingProgram, trailing_program

# The program is recorded after this many solutions of a topology and shape whose numbers were gathered; it is compiled
# to machine code after _OFTEN, which takes ten times as long.
_FEW, _OFTEN = 0, 20
# What entries share is recorded after this many.
_SHARED = 4
# A program that found pivots close to rounding in so many runs, and in most, is not tried again.
_REFUSED = 3
# Largest number of results, for all entries together, that a program for a medium batch computes at once.
_ROOM = 2**22

Program = BatchProgram | MediumProgram | TrailingProgram


class _Alike:
    """Batches of one topology and shape in the cache: how often they were solved, and their program."""

    def __init__(self) -> None:
        self.met = self.refused = 0
        self.program: Program | None = None
        self.without = False

    def solution(self, plan: Writable, numbers: BatchNumbers, loads: BatchLoads) -> EntrySolution | None:
        """The solution by the program; None where there is none, or a pivot is close to rounding."""
        self.met += 1
        if self.met == 1:
            # what is known without recording, so that the next ones need not gather their numbers
            numbers.met.without = not _suits(plan, numbers)
            numbers.met.least = SHARED if numbers.shared else numbers.met.least
        if self.met <= (_SHARED if numbers.shared else _FEW) or self.without:
            return None
        if self.program is None:
            self.program = _written(plan, numbers, loads)
            self.without = numbers.met.without = self.program is None
        return None if self.program is None else self._run(self.program, numbers, loads)

    def _run(self, program: Program, numbers: BatchNumbers, loads: BatchLoads) -> EntrySolution | None:
        found = program.run(numbers, loads, self.way)
        if found is None:
            self.refused += 1
            self.without = numbers.met.without = self.refused >= max(_REFUSED, self.met // 2)
        return found

    @property
    def way(self) -> Way:
        """How to run the steps: code that takes longer to compile is made for topologies that are solved more often."""
        often = self.met > _OFTEN or (isinstance(self.program, MediumProgram) and self.program.pays(self.met))
        return Way.MACHINE if often and entry_machine.available() else Way.STEPS


def solved(plan: Writable, numbers: BatchNumbers, loads: BatchLoads) -> EntrySolution | None:
    """The solution of a batch by the program of its topology and shape.

    Parameters
    ----------
    plan
        The plan of the frame.
    numbers
        The numbers of the frame.
    loads
        The loads on the frame.

    Returns
    -------
    EntrySolution or None
        The solution; None where the topology was solved a few times only, has no program, or a pivot is close to
        rounding at some entry: then the frame is to be solved without a program.
    """
    weight = (320 if numbers.shared else 80) * len(numbers.topology.number) ** 2
    alike: _Alike = PROGRAMS.found(("batch", numbers.key, loads.key, plan.asked), _Alike, weight)
    return alike.solution(plan, numbers, loads)


class _BatchWriter:
    """A batch whose numbers are terms of a recording.

    Attributes
    ----------
    later
        Mask of what depends on the loads, beyond those of the batch axes; 0 where that is not told apart.
    parameters
        For each right-hand-side parameter but the first: whether it is a load, and its index.
    """

    def __init__(self, plan: Writable, numbers: BatchNumbers, loads: BatchLoads) -> None:
        self.plan, self.numbers, self.loads = plan, numbers, loads
        grid = numbers.grid
        self.later = len(grid.sizes) if numbers.at_once else 0
        self.recording = Recording(axes=len(grid.sizes) - 1, signless=True)
        self._given = self._terms(numbers, 0)
        self._pushes = self._terms(loads, self.later)
        self.rhs_parameters = RightHandSideParameters(grid, plan.rhs_parameters.geometry)
        self.parameters: list[tuple[bool, int]] = []
        self._used = numbers.used
        self.tree = self._tree()

    def _terms(self, numbers: Blocks, mask: int) -> list[Value]:
        return [
            term
            for block, own in zip(numbers.blocks, numbers.masks, strict=True)
            for term in self.recording.later_ones(own | mask, len(block))
        ]

    def _numbers(self, places: Sequence[int]) -> list[Value]:
        """Terms of numbers by index; those that are zero, or part of the program, themselves."""
        return [0.0 if k == ABSENT else self._number(k) for k in places]

    def _several(self, start: int, count: int) -> list[Value]:
        """`_numbers` of as many as belong together from the first of them; of none if that is not there."""
        return self._numbers([ABSENT] * count if start == ABSENT else range(start, start + count))

    def _row(self, place: int, *, load: bool) -> Row:
        """A load or an offset as a row over the right-hand-side parameters, to which it is added if need be."""
        if place == ABSENT or not (load or self._used[place]):
            return {}
        term = self._pushes[place] if load else self._given[place]
        if not mask_of(term) & ~self.rhs_parameters.geometry:
            return {ONE: term}
        self.rhs_parameters.values.append(term)
        self.parameters.append((load, place))
        return {-len(self.rhs_parameters.values): 1.0}

    def _tree(self) -> JointTree:
        numbers, topology = self.numbers, self.plan.topology
        edges = edges_of(topology, RightHandSideParameters(numbers.grid, self.rhs_parameters.geometry))
        given = [self._edge(edge, k) for k, edge in enumerate(edges)]
        links = numbers.links
        axes: dict[int, Matrix3] = {
            k: square(self._several(link.axes, 9)) for k, link in enumerate(links) if link.axes is not None
        }
        bodies: dict[str | None, Matrix3] = {None: None}
        bodies |= {body: square(self._several(start, 9)) for body, start in numbers.turns.items()}
        tree = TermTree(
            topology,
            numbers.grid,
            self.rhs_parameters,
            given,
            turns=tuple(bodies[body] for body in topology.bodies),
            edge_axes=axes,
            arms={k: self._several(link.arm, 3) for k, link in enumerate(links) if link.arm is not None},
            places={edge: k for k, edge in enumerate(given)},
        )
        tree.grow(*spanning([given[k] for k in numbers.order]))
        return tree

    def _edge(self, edge: Edge, place: int) -> Edge:
        """An edge with terms in place of its numbers."""
        link = self.numbers.links[place]
        (pitch,) = self._numbers([link.pitch])
        offset = tuple(self._row(k, load=False) for k in link.offsets)
        return replace(edge, stiffness=tuple(self._several(link.springs, 6)), pitch=pitch, offset=offset)

    @property
    def matrix(self) -> Matrix | None:
        """Stiffness of the members, summed in the same order as without recording.

        None where the numbers of this batch make another entry zero than those that lack all terms.
        """
        matrix: Matrix = {}
        for entry in self.plan.varying.entries:
            i, j = entry.at
            matrix.setdefault(i, {})[j] = matrix.setdefault(j, {})[i] = {}
        springs = self._springs()
        for group in self.plan.topology.groups:
            pieces = group.pieces.tolist()
            if pieces[0] not in springs:
                continue
            stack = group.extended_stiffness()
            used = np.triu((stack != 0.0).any(axis=tuple(range(1, stack.ndim - 2))))
            found = {(p, *at): value for p, k in enumerate(pieces) for at, value in _sums(*springs[k]).items()}
            places = [*zip(*(each.tolist() for each in np.nonzero(used)), strict=True)]
            if places != [*found]:
                return None
            dofs = group.dofs.tolist()
            rows, columns = ([dofs[at[0]][at[end]] for at in places] for end in (1, 2))
            enter_all(matrix, rows, columns, found.values())
        return matrix

    def varying(self, varying: Varying) -> Iterator[tuple[Entry, Value]]:
        """Entries of the stiffness of members that each batch entry computes for itself, and their values."""
        groups = zip(self.plan.topology.groups, self.numbers.members, strict=True)
        own = {
            piece: places
            for group, found in groups
            if isinstance(found, PieceNumbers)
            for piece, places in zip(group.pieces.tolist(), found.pieces, strict=True)
        }
        return varying.summed(
            given.springs([self._numbers(places) for places in own[piece]])
            for given, _ in varying.groups
            for piece in given.group.pieces.tolist()
        )

    def _springs(self) -> dict[int, Springs]:
        """Stiffness and deformations of the springs of the pieces whose stiffness is summed for all entries at once."""
        if self.numbers.formulas:
            return {k: self._by_formulas(each) for k, each in enumerate(self.numbers.formulas)}
        return {
            piece: self._given_springs(numbers, place)
            for group, numbers in zip(self.plan.topology.groups, self.numbers.members, strict=True)
            if isinstance(numbers, Piecewise)
            for place, piece in enumerate(group.pieces.tolist())
        }

    def _by_formulas(self, numbers: MemberFormulas) -> Springs:
        chord = [self._number(numbers.chord + k) for k in range(3)]
        squares = [part * part for part in chord]
        length = np.sqrt(squares[0] + squares[1] + squares[2])
        inputs = [self._number(k) for k in numbers.inputs]
        stiffness = [self.recording.write(Operation.WIDEN, each) for each in numbers.stiffness(inputs, length)]
        axes = numbers.axes(chord, self._number)
        rows: list[list[Value]] = [[0.0] * 12 for _ in stiffness]
        for (spring, a), number in numbers.deformations(length).items():
            block, start = a - a % 3, 3 * (a % 3)
            rows[spring][block : block + 3] = [product(number, axes[start + c]) for c in range(3)]
        return cast("list[Value]", stiffness), rows

    def _given_springs(self, numbers: Piecewise, piece: int) -> Springs:
        stiffness = [self._number(numbers.stiffness + k * numbers.pieces + piece) for k in range(numbers.springs)]
        return stiffness, self._deformations(numbers, piece)

    def _deformations(self, numbers: Piecewise, piece: int) -> list[list[Value]]:
        """For each spring of a member, its deformation per unit of the twelve displacements in the nodes' axes."""
        rows: list[list[Value]] = [[0.0] * 12 for _ in range(numbers.springs)]
        for (spring, a), given in numbers.deformations:
            number = given if isinstance(given, float) else self._number(given + piece)
            if not numbers.axes:
                rows[spring][a] = number
                continue
            # those of the local axis along which the end moves
            start = numbers.axes[a // 6 % len(numbers.axes)] + 3 * (a % 3) * numbers.pieces + piece
            block = a - a % 3
            rows[spring][block : block + 3] = [
                product(number, self._number(start + c * numbers.pieces)) for c in range(3)
            ]
        return rows

    def _number(self, k: int) -> Value:
        return self.numbers.units.get(k, self._given[k]) if self._used[k] else 0.0

    @property
    def forces(self) -> Forces:
        """Loads in the nodes' axes, summed in the same order as without recording."""
        forces: Forces = {}

        def put(dof: int, source: int, value: Value) -> None:
            if not is_zero(value):
                add(forces.setdefault(dof, {}).setdefault(source, {}), mask_of(value), value)

        for node, k, place in self.loads.nodal:
            turn = self.tree.turn(node)
            for key, factor in self._row(place, load=True).items():
                if turn is None:
                    put(6 * node + k, -1 - key, factor)
                    continue
                for c in range(3):
                    put(6 * node + 3 * (k // 3) + c, -1 - key, product(turn[k % 3][c], factor))
        for dof, place in self.loads.shares:
            put(dof, 0, self._pushes[place])
        return forces


def _sums(stiffness: list[Value], rows: list[list[Value]]) -> dict[tuple[int, int], Value]:
    """Entries of the upper triangle of the stiffness of a member that are not zero, in order."""
    weighted = [[product(value, k) for value in row] for row, k in zip(rows, stiffness, strict=True)]
    found: dict[tuple[int, int], Value] = {}
    for a in range(12):
        for b in range(a, 12):
            for row, other in zip(rows, weighted, strict=True):
                if not (is_zero(row[a]) or is_zero(other[b])):
                    term = row[a] * other[b]
                    found[a, b] = found[a, b] + term if (a, b) in found else term
    return found


def _suits(plan: Writable, numbers: BatchNumbers) -> bool:
    """Whether a batch may have a program: by its method, and as all of its members vary over many entries, or none."""
    if plan.method.name != BROADCAST or plan.chains:
        return False
    if numbers.at_once:
        return numbers.grid.sizes[-1] <= CHUNK
    return len(plan.varying.groups) == len(plan.topology.groups)


def _written(plan: Writable, numbers: BatchNumbers, loads: BatchLoads) -> Program | None:
    """The program of a batch.

    None where there can be none: for another method, chains, several separate parts, too many operations, a mechanism,
    or a medium batch with too many results or with members that do not vary.
    """
    if not _suits(plan, numbers):
        return None
    writer = _BatchWriter(plan, numbers, loads)
    matrix = writer.matrix
    if matrix is None:
        return None
    with np.errstate(all="ignore"):
        written = plan.written(writer.tree, matrix, writer.forces)
        if len({int(plan.connected_components[name // 6]) for name in written.excited}) > 1:
            return None  # separate parts are each solved when their results are read
        blocks = {name: written.block(name) for name in sorted(written.excited)}
        if sum(operations(block.orders) for block in blocks.values()) > MOST:
            return None
        layout = partial(StepLayout, writer.recording, wide=numbers.wide, loads=loads.count, mask=writer.later)
        if numbers.shared:
            return trailing_program(written, blocks, layout, tuple(writer.parameters), plan.method)
        if not numbers.short and not all(block.varying for block in blocks.values()):
            return None
        known: dict[int, Value] = {}
        least: dict[int, Value] = {}
        for name, block in blocks.items():
            done, least[name] = _eliminated(block, writer)
            own = [k for k, other in written.component.items() if other == name]
            known.update(zip(own, done.values([{k: 1.0} for k in own]), strict=True))
        parameters = writer.rhs_parameters.values
        nodes: list[Value] = []
        for node in range(len(plan.topology.number)):
            rows = written.tree.global_rows(node)
            nodes += values_of(rows, written.component, written.excited, known, parameters)
    asked = [*nodes, *known.values(), *least.values()]
    if any(not isinstance(value, Term) and np.isnan(value) for value in asked):
        return None  # a pivot is zero whatever the numbers: the frame is a mechanism
    if not numbers.short:
        if (len(nodes) + len(known)) * numbers.grid.sizes[-1] > _ROOM:
            return None
        parts = writer.recording, nodes, known, [*least.values()], tuple(writer.parameters)
        return MediumProgram(*parts, written.component, frozenset(written.excited), plan.method)
    steps = layout(asked)
    a, b = accumulate((len(nodes), len(known)))
    return BatchProgram(
        layout=steps,
        widths=(numbers.count, loads.count),
        nodes=tuple(steps.outputs[:a]),
        unknowns=dict(zip(known, steps.outputs[a:b], strict=True)),
        least=tuple(steps.outputs[b:]),
        parameters=tuple(writer.parameters),
        component=written.component,
        excited=frozenset(written.excited),
        method=plan.method,
    )


def _eliminated(block: Block, writer: _BatchWriter) -> tuple[PartialFactorisation, Value]:
    """The elimination of a component, and its least pivot ratio."""
    large = large_masks(block.grid)
    stage = Stage(block.matrix, block.forces, block.scale)
    linked = block.rows, block.springs, block.rhs_parameters
    shared = PartialFactorisation.begun(block.orders, stage, *linked, block.masks, [not each for each in large])
    if block.varying is None:
        return shared, shared.least
    # what a batch leaves to its chunks, of which a medium one has a single one
    progress = shared.anew(lambda value: value)
    for entry, value in writer.varying(block.varying):
        progress.inner.put(*entry.at, entry.mask, value)
    progress.factorise(large, given=False)
    progress.forget()
    progress.load(large)
    least = shared.least if shared.pivot_ratios else np.inf
    return progress, progress.least if isinstance(least, float) else np.minimum(least, progress.least)
