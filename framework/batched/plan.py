"""The plan of a frame: numbering, joint-relative coordinates, connected components and orders of elimination."""

from __future__ import annotations

import copy
from collections.abc import Iterable
from dataclasses import replace
from time import perf_counter
from typing import cast

from ..cache import Bounded
from ..clock import timed
from ..description import Description
from ..lazily import cached_property
from ..solvers.coupling import Coupling
from ..solvers.graph import Graph
from ..solvers.method import LARGE, Method, choose
from ..structure.assembly import force_entries
from ..structure.parts import Grid, Matrix, RightHandSideParameters, Value, unknowns
from ..structure.topology import Index
from ..structure.tree import JointTree
from ..structure.varying import Varying
from . import batch_recording
from .batch_numbers import BatchLoads, BatchNumbers
from .block import Block
from .condensation import Chain, Condensation, chains, loaded
from .entry_program import EntrySolution
from .entry_recording import solved
from .one_entry import EntryLoads
from .stage import Forces
from .unloaded import Chained, Former, Unloaded

# Number of sets of condensed chains that are kept; they differ by the nodes that have loads.
_CHAINED = 2


class Plan:
    """The unknowns of a frame, how they are coupled, and which of them loads reach.

    Parameters
    ----------
    frame
        The description.
    cut
        Whether members are divided into their segments: for inertia and buckling, not for statics.
    method
        Name of the method, see `linkframe.framework.solvers.method`; None chooses by expected time.
    former
        What is known of an earlier frame whose members, not divided, connect the same nodes; None for nothing.
    apart
        Whether each offset that varies is a right-hand-side parameter of its own, even if the geometry varies as well.
    """

    def __init__(
        self,
        frame: Description,
        *,
        cut: bool = False,
        method: str | None = None,
        former: Former | None = None,
        apart: bool = False,
    ) -> None:
        times: dict[str, float] = {}
        with timed(times, "numbering"):
            unloaded = Unloaded(frame, cut=cut, method=method, former=former, apart=apart)
        self._chained: Bounded[tuple[object, ...], Chained] = Bounded(_CHAINED)
        self._of(frame, unloaded, times, again=False)

    def _of(self, frame: Description, unloaded: Unloaded, times: dict[str, float], *, again: bool) -> None:
        self.frame, self.unloaded, self.times, self.again = frame, unloaded, times, again
        # properties of members are computed once, for the first loads and all others
        self.topology = unloaded.topology if frame is unloaded.frame else unloaded.topology.loaded(frame)
        self._blocks: dict[int, Block] = {}
        # Unknowns that count as loaded whether or not loads reach them.
        self.asked_unknowns: frozenset[int] = frozenset()

    def reloaded(self, frame: Description) -> Plan:
        """The plan of a frame that differs in its loads alone: numbering, matrix and orders are shared."""
        clone = object.__new__(Plan)
        clone._chained = self._chained
        clone._of(frame, self.unloaded, {}, again=self.again or "solution" in self.times)
        return clone

    def under(self, frame: Description, grid: Grid, rhs_parameters: RightHandSideParameters) -> Plan:
        """This plan, whose stiffness is constant, with the loads of a frame of another batch shape."""
        unloaded = copy.copy(self.unloaded)
        unloaded.grid, unloaded.rhs_parameters = grid, rhs_parameters
        clone = object.__new__(Plan)
        clone._chained = Bounded(_CHAINED)
        clone._of(frame, unloaded, self.times, again=self.again)
        clone.method = self.method
        return clone

    def _exciting(self, components: set[int]) -> Plan:
        """This plan with other `components` counting as loaded."""
        clone = copy.copy(self)
        clone.excited, clone.entry = components, None
        return clone

    def written(self, tree: JointTree, matrix: Matrix, forces: Forces) -> Plan:
        """This plan with other numbers, such as terms of a recording, for joint tree, stiffness and loads."""
        unloaded = copy.copy(self.unloaded)
        unloaded.tree, unloaded.rhs_parameters = tree, tree.rhs_parameters
        chained = Chained(unloaded, [])
        chained.matrix = matrix
        clone = object.__new__(Plan)
        clone._chained = Bounded(_CHAINED)
        clone._of(self.frame, unloaded, {}, again=False)
        clone.chains, clone.chained, clone.forces, clone.entry = [], chained, forces, None
        return clone

    @cached_property
    def rhs_parameters(self) -> RightHandSideParameters:
        """Those of the frame without loads, to which loads that vary add theirs."""
        if self.grid.shape:
            self.unloaded.tree  # noqa: B018  # which adds those of offsets and prescribed displacements
        found = self.unloaded.rhs_parameters.copy()
        if self.grid.shape and self.known_entry is not None:
            self.forces = force_entries(self.topology, found)  # which nothing else asked for
        return found

    @cached_property
    def entry(self) -> EntrySolution | None:
        """The solution of a single batch entry or a short batch by the program of its topology; None without one."""
        begin, numbers = perf_counter(), self.unloaded.numbers
        if numbers is None:
            return None
        found = (
            batch_recording.solved(self, numbers, BatchLoads(self.topology, self.grid))
            if isinstance(numbers, BatchNumbers)
            else solved(self, numbers, EntryLoads(self.topology, self.grid))
        )
        if found is not None:
            self.times["solution"] = self.times.get("solution", 0.0) + perf_counter() - begin
        return found

    @property
    def known_entry(self) -> EntrySolution | None:
        """`entry` if it has been computed already, else None."""
        known: EntrySolution | None = vars(self).get("entry")
        return known

    @property
    def medium(self) -> bool:
        """Whether a program solves a batch whose members vary, and that is not short."""
        numbers = self.unloaded.numbers
        return isinstance(numbers, BatchNumbers) and not numbers.at_once and self.entry is not None

    # -- without the loads ------------------------------------------------------------------------------------------

    @property
    def asked(self) -> str | None:
        """Name of the method that the user asked for; None for none."""
        return self.unloaded.asked

    @property
    def grid(self) -> Grid:
        """Shape of the batch, and its size for each mask."""
        return self.unloaded.grid

    @property
    def tree(self) -> JointTree:
        """The joint tree, which expresses each node's displacement in joint-relative coordinates."""
        return self.unloaded.tree

    @property
    def constant(self) -> bool:
        """Whether the stiffness does not vary over the batch."""
        return self.unloaded.constant

    @property
    def imposed(self) -> list[Value]:
        """The right-hand-side parameters without loads: one, and varying prescribed displacements and offsets."""
        return self.rhs_parameters.values[: len(self.unloaded.rhs_parameters.values)]

    @property
    def large(self) -> bool:
        """Whether this is a large frame of constant stiffness, for which sparse methods are faster."""
        return len(self.unknowns) > LARGE and self.constant

    @property
    def graph(self) -> Graph:
        """Graph of the nodes and their coupling, for the sparse methods."""
        return self.unloaded.graph

    @cached_property
    def coupling(self) -> Coupling:
        """Coupling of the unknowns by members and springs, for the method with one banded matrix for each entry."""
        if (rough := vars(self).get("rough_coupling")) is not None and rough.exact:
            return cast(Coupling, rough)
        with timed(self.times, "pattern"):
            return Coupling(self)

    @cached_property
    def rough_coupling(self) -> Coupling:
        """`coupling` as found from the first batch entry alone, to estimate costs."""
        with timed(self.times, "pattern"):
            return Coupling(self, everywhere=False)

    @cached_property
    def method(self) -> Method:
        """The method by which this plan is solved, and why."""
        if self.known_entry is not None:
            return self.known_entry.method
        return choose(self, self.asked)

    @property
    def unknowns(self) -> list[int]:
        """All unknowns: displacements of free nodes, joint-relative coordinates of the others."""
        return self.unloaded.links.unknowns

    @property
    def connected_components(self) -> Index:
        """Number of the connected part of the frame for each node, (nodes,); supports do not connect."""
        return self.unloaded.connected_components

    @cached_property
    def varying(self) -> Varying:
        """Members whose stiffness varies so much that each chunk assembles it."""
        with timed(self.times, "pattern"):
            return self.unloaded.varying

    # -- condensed --------------------------------------------------------------------------------------------------

    @cached_property
    def chained(self) -> Chained:
        """The stiffness with unloaded chains of members condensed."""
        found = self.chains
        key = tuple(tuple(part) for chain in found for part in chain)
        return self._chained.found(key, lambda: Chained(self.unloaded, found))

    @cached_property
    def chains(self) -> list[Chain]:
        """Chains of members whose inner nodes carry nothing else, to be condensed."""
        return chains(self.topology, self.tree.rows.keys() | loaded(self.topology))

    @property
    def condensed(self) -> Condensation:
        """The condensed chains of members."""
        return self.chained.condensed

    @cached_property
    def matrix(self) -> Matrix:
        """Parts of the stiffness of members and chains by pair of DOFs, in the nodes' axes."""
        self.varying  # noqa: B018  # which is timed separately
        with timed(self.times, "assembly"):
            return self.chained.matrix

    @property
    def component(self) -> dict[int, int]:
        """Connected component of every unknown, identified by one of its unknowns."""
        return self.chained.component if self.known_entry is None else self.known_entry.component

    # -- loaded -----------------------------------------------------------------------------------------------------

    @cached_property
    def forces(self) -> Forces:
        """Parts of the loads by DOF and right-hand-side parameter, in the nodes' axes."""
        with timed(self.times, "assembly"):
            return force_entries(self.topology, self.rhs_parameters)

    @cached_property
    def excited(self) -> set[int]:
        """Components that a load, an offset or a prescribed displacement acts on."""
        return self._loaded_components()

    def _loaded_components(self) -> set[int]:
        if self.known_entry is not None:
            return set(self.known_entry.excited)
        pushed = set(self.forces)
        rows = {6 * n + k: row for n, six in self.tree.rows.items() for k, row in enumerate(six)}
        moved = [dof for dof, row in rows.items() if min(row, default=0) < 0]
        if moved:
            pushed |= self.chained.coupled_with(moved)
        reached = {k for dof in pushed for k in self._coupled(dof)}
        reached |= {k for spring in self.tree.springs if min(spring.row, default=0) < 0 for k in unknowns(spring.row)}
        component = self.component
        return {component[k] for k in reached}

    def part(self, node: int) -> Plan:
        """The plan in which only the part of the frame that contains a node counts as loaded."""
        clone, parts = copy.copy(self), self.connected_components
        found = self._loaded_components()
        clone.excited = found if self.known_entry else {k for k in found if parts[k // 6] == parts[node]}
        return clone

    def reaching(self, unknowns: Iterable[int]) -> Plan:
        """The plan in which the components of these unknowns count as loaded, too; itself where they do already."""
        asked = set(unknowns)
        inside = self.excited | {self.component[k] for k in asked}
        return self if len(inside) == len(self.excited) else self._exciting(inside).asking(asked)

    def asking(self, unknowns: Iterable[int]) -> Plan:
        """The plan with these unknowns recorded in `asked_unknowns`, as counting as loaded whether or not they are."""
        clone = copy.copy(self)
        clone.asked_unknowns = self.asked_unknowns.union(unknowns)
        return clone

    def members_of(self, component: int) -> set[int]:
        """Unknowns of a component."""
        return set(self.chained.members[component])

    @property
    def components(self) -> set[int]:
        """All components, each identified by one of its unknowns."""
        return set(self.chained.members)

    def block(self, component: int) -> Block:
        """The assembled equations of a component, with its orders of elimination."""
        if component not in self._blocks:
            with timed(self.times, "elimination order"):
                bare, own = self.chained.block(component)
                forces = {a: parts for a, parts in self.forces.items() if a in own}
                self._blocks[component] = replace(bare, forces=forces, rhs_parameters=self.rhs_parameters.values)
        return self._blocks[component]

    def _coupled(self, dof: int) -> list[int]:
        """Unknowns on which a nodal displacement depends."""
        node, k = divmod(dof, 6)
        return unknowns(self.tree.row(node, k))
