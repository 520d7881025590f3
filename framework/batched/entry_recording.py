"""Recording of the solution of a frame with a single batch entry, once for all frames of its topology.

Joint tree, elimination, substitution and the displacements of all nodes are computed with terms instead of numbers; the
recorded operations become an `EntryProgram`.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Protocol

import numpy as np

from ..cache import PROGRAMS
from ..program.recording import Recording, Term
from ..solvers.method import BROADCAST, Compiled, Method, choose
from ..structure.edge import Edge
from ..structure.forest import spanning
from ..structure.parts import Matrix, Row, Value, add, enter_all, is_zero, product
from ..structure.topology import Index, Topology
from ..structure.tree import JointTree, Matrix3, edges_of
from ..structure.varying import Varying
from . import entry_machine
from .block import Block
from .entry_program import EntryProgram, EntrySolution, Way, values_of
from .one_entry import EACH, OFFSETS, PITCH, EntryLoads, EntryNumbers
from .replay import MOST, RecordedElimination, operations
from .stage import Forces
from .step_layout import StepLayout

# The program is recorded after this many solutions of a topology, since recording takes as long as some six of them.
_FEW = 3
# It is compiled to Python functions after _OFTEN solutions, which takes as long again, and to machine code after
# _ALWAYS solutions, which takes ten times as long.
_OFTEN, _ALWAYS = 200, 1000
# Loads are recorded as varying over axis 0, so that the steps that depend on them can be told from the others.
LOADS = 1


class TermPlan(Protocol):
    """A plan whose numbers are terms of a recording."""

    @property
    def tree(self) -> JointTree: ...

    @property
    def component(self) -> dict[int, int]: ...

    @property
    def excited(self) -> set[int]: ...

    def block(self, component: int) -> Block: ...


class Writable(Compiled, Protocol):
    """A plan that can be solved with terms of a recording."""

    @property
    def asked(self) -> str | None: ...

    @property
    def topology(self) -> Topology: ...

    @property
    def connected_components(self) -> Index: ...

    @property
    def varying(self) -> Varying: ...

    @property
    def method(self) -> Method: ...

    def written(self, tree: JointTree, matrix: Matrix, forces: Forces) -> TermPlan: ...


class _Topology:
    """A topology in the cache: how often it was solved, and its program once there is one."""

    def __init__(self) -> None:
        self.met = 0
        self.program: EntryProgram | None = None
        self.without = False

    def solution(self, plan: Writable, numbers: EntryNumbers, loads: EntryLoads) -> EntrySolution | None:
        """The solution by the program of the topology; None where there is none, or a pivot is close to rounding."""
        self.met += 1
        if self.met <= _FEW or self.without:
            return None
        if self.program is None:
            self.program = _written(plan, numbers, loads)
            self.without = self.program is None
        return None if self.program is None else self.program.run(numbers, loads, self.way)

    @property
    def way(self) -> Way:
        """How to run the steps: code that takes longer to compile is made for topologies that are solved more often."""
        if self.met > _ALWAYS and entry_machine.available():
            return Way.MACHINE
        return Way.COMPILED if self.met > _OFTEN else Way.STEPS


def solved(plan: Writable, numbers: EntryNumbers, loads: EntryLoads) -> EntrySolution | None:
    """The solution of a frame by the program of its topology.

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
        rounding: then the frame is to be solved without a program.
    """
    weight = 80 * len(numbers.topology.number) ** 2
    topology: _Topology = PROGRAMS.found((numbers.key, loads.key, plan.asked), _Topology, weight)
    return topology.solution(plan, numbers, loads)


@dataclass(eq=False)
class TermTree(JointTree):
    """A joint tree whose numbers, axes and arms are terms of a recording."""

    turns: tuple[Matrix3, ...] = ()
    edge_axes: dict[int, Matrix3] = field(default_factory=dict)
    arms: dict[int, list[Value]] = field(default_factory=dict)
    places: dict[Edge, int] = field(default_factory=dict)

    def turn(self, node: int) -> Matrix3:
        """Axes of a node as columns."""
        return self.turns[node] if node >= 0 else None

    def axes(self, edge: Edge) -> Matrix3:
        """Axes of an edge as columns."""
        return self.edge_axes.get(self.places[edge])

    def arm(self, edge: Edge) -> list[Value]:
        """Vector from the first to the second node of a rigid link, global."""
        return self.arms[self.places[edge]]


class _Writer:
    """A frame whose numbers are terms of a recording."""

    def __init__(self, plan: Writable, numbers: EntryNumbers, loads: EntryLoads) -> None:
        self.plan, self.numbers, self.loads = plan, numbers, loads
        self.recording = recording = Recording()
        self.edges = recording.later_ones(0, len(numbers.links.edges))
        self.turns = recording.later_ones(0, len(numbers.links.turns))
        self.members = [recording.later_ones(0, stack.size) for stack in numbers.stacks]
        self.pushes = recording.later_ones(LOADS, len(loads.values))
        self.tree = self._tree()

    def _tree(self) -> JointTree | None:
        """The joint tree; None where joints that close a loop have ideal components: which unknowns these make
        dependent follows from the numbers.
        """
        numbers, topology, rhs_parameters = self.numbers, self.plan.topology, self.plan.rhs_parameters
        edges = edges_of(topology, rhs_parameters)
        by_place = [self._edge(place, edge) for place, edge in enumerate(edges)]
        turn = iter(zip(self.turns, numbers.links.turns, strict=True))

        def taken(count: int) -> list[Value]:
            pairs = [next(turn) for _ in range(count)]
            return [number if number in (0.0, 1.0, -1.0) else term for term, number in pairs]

        axes: dict[int, Matrix3] = {}
        arms: dict[int, list[Value]] = {}
        for place, edge in enumerate(edges):
            if edge.axes is not None:
                axes[place] = square(taken(9))
            if edge.kind == "rigid":
                arms[place] = taken(3)
        bodies: dict[str | None, Matrix3] = {None: None}
        for body in topology.bodies:
            if body not in bodies:
                bodies[body] = square(taken(9))
        chosen, closing = spanning([edges[k] for k in numbers.links.order])
        if any(edge.ideal for edge in closing):
            return None
        by_edge = dict(zip(edges, by_place, strict=True))
        tree = TermTree(
            topology,
            rhs_parameters.grid,
            rhs_parameters,
            by_place,
            turns=tuple(bodies[body] for body in topology.bodies),
            edge_axes=axes,
            arms=arms,
            places={edge: place for place, edge in enumerate(by_place)},
        )
        tree.grow([by_edge[edge] for edge in chosen], [by_edge[edge] for edge in closing])
        return tree

    def _edge(self, place: int, edge: Edge) -> Edge:
        """An edge with terms in place of its numbers."""
        given = self.numbers.links.edges[EACH * place : EACH * (place + 1)]
        terms = [term if number else 0.0 for term, number in zip(self.edges[EACH * place :], given, strict=False)]
        offset: tuple[Row, ...] = tuple({-1: value} if not is_zero(value) else {} for value in terms[OFFSETS:])
        return replace(edge, stiffness=tuple(terms[:PITCH]), pitch=terms[PITCH], offset=offset)

    @property
    def matrix(self) -> Matrix:
        """Stiffness of the members, summed in the same order as without recording."""
        matrix: Matrix = {}
        topology = self.plan.topology
        for group, stack, terms in zip(topology.groups, self.numbers.stacks, self.members, strict=True):
            piece, a, b = np.nonzero(np.triu(stack != 0.0))
            places = ((12 * piece + a) * 12 + b).tolist()
            enter_all(matrix, group.dofs[piece, a].tolist(), group.dofs[piece, b].tolist(), [terms[k] for k in places])
        return matrix

    @property
    def forces(self) -> Forces:
        """Loads in the nodes' axes, summed in the same order as without recording."""
        forces: Forces = {}

        def put(dof: int, value: Value) -> None:
            if not is_zero(value):
                add(forces.setdefault(dof, {}).setdefault(0, {}), 0, value)

        assert self.tree is not None
        for (node, k, _), term in zip(self.loads.nodal, self.pushes, strict=False):
            turn = self.tree.turn(node)
            if turn is None:
                put(6 * node + k, term)
                continue
            for c in range(3):
                put(6 * node + 3 * (k // 3) + c, product(term, turn[k % 3][c]))
        for (dof, _), term in zip(self.loads.shares, self.pushes[len(self.loads.nodal) :], strict=True):
            put(dof, term)
        return forces


def square(nine: list[Value]) -> Matrix3:
    """Nine numbers as three rows."""
    return [nine[:3], nine[3:6], nine[6:]]


def _written(plan: Writable, numbers: EntryNumbers, loads: EntryLoads) -> EntryProgram | None:
    """The program of a frame.

    None where there can be none: for another method, chains, ideal joints that close loops, several separate parts,
    too many operations, or a mechanism.
    """
    method = choose(plan, plan.asked)
    if method.name != BROADCAST or plan.chains:
        return None
    writer = _Writer(plan, numbers, loads)
    if writer.tree is None:
        return None
    with np.errstate(all="ignore"):
        written = plan.written(writer.tree, writer.matrix, writer.forces)
        if len({int(plan.connected_components[name // 6]) for name in written.excited}) > 1:
            return None  # separate parts are each solved when their results are read
        blocks = {name: written.block(name) for name in sorted(written.excited)}
        if sum(operations(block.orders) for block in blocks.values()) > MOST:
            return None
        known: dict[int, Value] = {}
        least: dict[int, Value] = {}
        for name, block in blocks.items():
            given = block.matrix, block.forces, block.scale, block.rows, block.springs
            done = RecordedElimination(block.orders, *given).plainly(block.masks, block.rhs_parameters)
            own = [k for k, other in written.component.items() if other == name]
            known.update(zip(own, done.values([{k: 1.0} for k in own]), strict=True))
            least[name] = done.least
        nodes: list[Value] = []
        for node in range(len(plan.topology.number)):
            nodes += values_of(written.tree.global_rows(node), written.component, written.excited, known)
    asked = [*nodes, *known.values(), *least.values()]
    if any(not isinstance(value, Term) and np.isnan(value) for value in asked):
        return None  # a pivot is zero whatever the numbers: the frame is a mechanism
    sizes = [len(writer.edges), len(writer.turns), *map(len, writer.members)]
    starts = np.cumsum([0, *sizes]).tolist()
    wide = [k >= starts[2] for k in range(starts[-1])]
    program = StepLayout(writer.recording, asked, wide, len(writer.pushes), LOADS)
    places, inside = program.outputs, [[k - a for k in program.given if a <= k < b] for a, b in pairwise(starts)]
    known_at = places[len(nodes) : len(nodes) + len(known)]
    return EntryProgram(
        edges=tuple(inside[0]),
        turns=tuple(inside[1]),
        members=tuple(np.array(found, dtype=np.int64) for found in inside[2:]),
        constants=program.constants,
        shared=program.shared,
        loads=program.loads,
        loaded=program.loaded,
        nodes=tuple(places[: len(nodes)]),
        unknowns=dict(zip(known, known_at, strict=True)),
        least=dict(zip(least, places[len(nodes) + len(known) :], strict=True)),
        component=written.component,
        excited=frozenset(written.excited),
        method=method,
    )
