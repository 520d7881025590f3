"""The numbers of a batch whose joints close no loop, as input to the program of its topology.

As `linkframe.framework.batched.one_entry` does for a single entry: the program is found by a key, which tells which
number belongs to which joint, member or load, over which batch axes it varies, and which are zero at all entries.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO, Array, all_of, distinct
from ..structure.assembly import component_loads, member_and_mass_loads
from ..structure.edge import GROUND, preference
from ..structure.group import Group, precise
from ..structure.member_numbers import numbers_of
from ..structure.parts import Grid, is_zero, mask_of_shape
from ..structure.topology import Topology
from .chunks import large_masks
from .member_formulas import ABSENT, member_formulas
from .number_blocks import Blocks
from .one_entry import UNITS, Head

# Largest number of entries of a short batch: all that the elimination computes is computed for the whole batch at once.
SHORT = 2**10
# Largest number of entries of a batch that has a program.
MEDIUM = 2**16
# Numbers are gathered, and a program is recorded, after this many solutions of batches that look alike: recording takes
# as long as two of them, and saves half of each that follows. What entries share takes as long as eight, and saves a
# third: numbers are gathered again after SHARED.
FEW, SHARED = 2, 12
_NONE = (ABSENT,) * 6


class Met:
    """How often batches that look alike were planned, after how many of them the numbers of the next are gathered, and
    whether one of them turned out to have no program.
    """

    count = least = 0
    without = False


class Piecewise(NamedTuple):
    """The numbers of a group of n members: indices of the first of each block, and how many members and springs.

    Attributes
    ----------
    stiffness
        Stiffness of the springs, (s, n).
    deformations
        For each spring and end displacement of its members by which it is deformed: a number that all members have in
        common, or the index of the first of those of the members, (n,).
    axes
        Local axes as rows, at the start and, where they differ, at the end, (9, n) each; none where deformations are
        per unit displacement in the nodes' axes.
    pieces, springs
        The numbers n and s.
    precise
        Whether the stiffness of the members is summed in extended precision.
    """

    stiffness: int
    deformations: tuple[tuple[tuple[int, int], float | int], ...]
    axes: tuple[int, ...]
    pieces: int
    springs: int
    precise: bool


class PieceNumbers(NamedTuple):
    """The numbers of a group of members whose stiffness each entry computes for itself.

    Attributes
    ----------
    pieces
        For each member, the indices of the numbers in each of the lists of its `MemberNumbers`.
    formulas
        What tells apart the ways from these numbers to the springs.
    """

    pieces: tuple[tuple[tuple[int, ...], ...], ...]
    formulas: Hashable


class LinkNumbers(NamedTuple):
    """The numbers of a joint, tie or support, by index; `ABSENT` for those that are not there.

    Attributes
    ----------
    springs, pitch
        The first of six springs, and the pitch over 2 pi.
    offsets
        Six offsets.
    axes
        The first of nine components of the axes; None if these are the global ones.
    arm
        The first of three components of the arm of a rigid link; None for others.
    """

    springs: int
    pitch: int
    offsets: tuple[int, ...]
    axes: int | None = None
    arm: int | None = None


class BatchNumbers(Blocks):
    """The numbers of a batch, without its loads.

    Parameters
    ----------
    topology
        Its nodes and members.
    grid
        The batch.
    met
        How often batches like this one were solved.
    geometry
        Mask of the axes over which positions vary, by which loads are divided among right-hand-side parameters.

    Attributes
    ----------
    links
        Joints, ties and supports in turn.
    order
        Indices of these in order of preference for the joint tree.
    turns
        Index of the first component of the axes of bodies, by name.
    units
        Those of the numbers of axes, arms and deformations that are 0, 1 or -1 at all entries, and so are part of the
        program.
    members
        The groups of members; none where the program computes their springs.
    formulas
        The members whose springs the program computes, all or none.
    at_once
        Whether the stiffness of all members is summed for all entries at once: the batch is short, or no stiffness
        varies over many of its entries.
    key
        What each number belongs to, over which axes it varies, and which are zero.
    former
        The program that was last run on these numbers, and the results of its first part.
    """

    def __init__(self, topology: Topology, grid: Grid, met: Met, geometry: int) -> None:
        super().__init__(grid)
        self.topology, self.met = topology, met
        self.links: list[LinkNumbers] = []
        self.units: dict[int, float] = {}
        heads = [*self._joints(), *self._ties(), *self._supports()]
        self.order = preference([ends for _, ends, _ in heads], [strength for _, _, strength in heads])
        self.turns: dict[str, int] = {}
        for body in topology.bodies:
            if body is not None and body not in self.turns:
                self.turns[body] = self._turned(topology.frame.bodies[body].axes)
        places = {body: k for k, body in enumerate(self.turns)}
        large = large_masks(grid)
        self.at_once = not any(large[mask_of_shape(group.stiffness_shape)] for group in topology.groups)
        self.formulas = (member_formulas(self, topology) if self.at_once else None) or ()
        self.members: list[Piecewise | PieceNumbers] = []
        on: tuple[Hashable, ...] = (topology.ends.tobytes(),)
        if not self.formulas:
            own = self._springs if self.at_once else self._pieces
            self.members = [own(group) for group in topology.groups]
            on = tuple([group.dofs.tobytes() for group in topology.groups])
        self.former: tuple[Any, Any] | None = None
        self.key: Hashable = (
            grid.shape,
            geometry,
            self.pattern,
            tuple([(head, ends) for head, ends, _ in heads]),
            # numbers that are zero have no place, so that the pattern does not tell to what the others belong
            (*self.links,),
            (*self.order,),
            tuple([None if body is None else places[body] for body in topology.bodies]),
            (*self.units.items(),),
            on,
            (*self.members, *self.formulas),
        )

    @property
    def shared(self) -> bool:
        """Whether the batch is not short, and no stiffness of a member varies over many of its entries."""
        return self.at_once and not self.short

    @property
    def short(self) -> bool:
        """Whether the batch is short; other batches are solved in double precision, if their members vary."""
        return self.grid.sizes[-1] <= SHORT

    def __getstate__(self) -> dict[str, Any]:
        """The fields to pickle: without the last program, which another process records itself."""
        return vars(self) | {"former": None}

    @property
    def wide(self) -> list[bool]:
        """For each number, whether it is converted to extended precision."""
        found = [False] * self.count
        for each in self.members:
            if isinstance(each, Piecewise) and each.precise:
                stop = each.stiffness + each.pieces * each.springs
                found[each.stiffness : stop] = [True] * (stop - each.stiffness)
        return found

    def _joints(self) -> list[Head]:
        frame, number, heads = self.topology.frame, self.topology.number, list[Head]()
        for name, link in frame.joints.items():
            element = link.element
            stiffness, most = element.stiffness, float(np.maximum.reduce(element.stiffness, axis=None))
            ideal: tuple[int, ...] = ()
            if most == np.inf:
                infinite = np.isinf(stiffness)
                ideal = tuple(np.flatnonzero(infinite.reshape(-1, 6)[0]).tolist())
                stiffness = np.where(infinite, 0.0, stiffness)
                most = float(stiffness.max())
            springs = self.put(_first(stiffness, 1))
            screwless = not element.pitch.ndim and element.pitch.item() == 0.0
            pitch = ABSENT if screwless else self.one(element.pitch / (2.0 * np.pi))
            offsets = self._six(frame.offsets[name]) if name in frame.offsets else _NONE
            axes = None if element.axes is None else self._turned(element.axes)
            self.links.append(LinkNumbers(springs, pitch, offsets, axes))
            strength = len(ideal), most
            heads.append((("joint", ideal, axes is None), (number[link.first], number[link.second]), strength))
        return heads

    def _ties(self) -> list[Head]:
        frame, number, heads = self.topology.frame, self.topology.number, list[Head]()
        for tie in frame.ties:
            arm = None
            if tie.rigid:
                arm = self._turned(frame.position(tie.slave) - frame.position(tie.master))
            self.links.append(LinkNumbers(ABSENT, ABSENT, _NONE, arm=arm))
            ends = number[tie.master], number[tie.slave]
            heads.append((("tie", tie.components, tie.rigid), ends, (len(tie.components), 0.0)))
        return heads

    def _supports(self) -> list[Head]:
        frame, number, heads = self.topology.frame, self.topology.number, list[Head]()
        for node, constrained in frame.supports.items():
            self.links.append(LinkNumbers(ABSENT, ABSENT, self._six(constrained)))
            ideal = (*sorted(constrained),)
            heads.append((("support", ideal), (GROUND, number[node]), (len(ideal), 0.0)))
        return heads

    def _six(self, given: Mapping[int, Array]) -> tuple[int, ...]:
        found = [ABSENT] * 6
        for k, number in given.items():
            if number is not ZERO:
                found[k] = self.one(number)
        return tuple(found)

    def _turned(self, array: Array) -> int:
        """Add axes (..., 3, 3) or an arm (..., 3), whose numbers 0, 1 and -1 are part of the program."""
        start = self.put(_first(array, 2 if array.shape[-2:] == (3, 3) else 1))
        if not self.masks[-1]:
            numbers = self.blocks[-1].reshape(-1).tolist()
            self.units.update({k: x for k, x in enumerate(numbers, start) if x in UNITS})
        return start

    def _pieces(self, group: Group) -> PieceNumbers:
        given = numbers_of(group, self.grid)
        found = [[self._each(number, len(group.pieces)) for number in numbers] for numbers in given.at(0, slice(None))]
        pieces = [tuple([tuple([k[n] for k in numbers]) for numbers in found]) for n in range(len(group.pieces))]
        return PieceNumbers(tuple(pieces), given.kind)

    def _each(self, number: Array | float, pieces: int) -> list[int]:
        """Add a number of each of some members; its indices."""
        if isinstance(number, np.ndarray):
            return [self.one(each) for each in number]
        if number == 0.0:
            return [ABSENT] * pieces
        place = self.one(np.asarray(number))
        if number in UNITS:
            self.units[place] = number
        return [place] * pieces

    def _springs(self, group: Group) -> Piecewise:
        count, local, stiffness = len(group.pieces), group.deformation_numbers, group.spring_stiffness
        if local is None or stiffness is None:
            return self._turned_springs(group)
        first = self._members(_first(stiffness, 1), count)
        scale = self.masks[-1]
        varying = [number for number in local.values() if type(number) is not float]
        leaders, which = distinct(varying)
        known = [self._members(np.asarray(varying[k])[None], count) for k in leaders]
        place = iter([known[k] for k in which.tolist()])
        found = tuple([(at, number if type(number) is float else next(place)) for at, number in local.items()])
        axes = tuple([self._axes(each, count, scale) for each in group.axis_components])
        return Piecewise(first, found, axes, count, stiffness.shape[-1], precise(stiffness))

    def _turned_springs(self, group: Group) -> Piecewise:
        """`_springs` of members whose deformations are sums of several products in the nodes' axes."""
        stiffness, rows, fine = group.turned_springs()
        count, springs = len(group.pieces), stiffness.shape[-1]
        first = self._members(_first(stiffness, 1), count)
        place = self._axes(_first(rows, 2), count, self.masks[-1])
        found = [((k, a), place + (12 * k + a) * count) for k in range(springs) for a in range(12)]
        return Piecewise(first, tuple(found), (), count, springs, fine)

    def _members(self, numbers: Array, count: int) -> int:
        """Add numbers (m, n, ...) of n members; the index of the first. Those of all members come together."""
        if numbers.shape[1] != count:
            numbers = np.broadcast_to(numbers, (len(numbers), count, *numbers.shape[2:]))
        return self.put(numbers.reshape(-1, *numbers.shape[2:]))

    def _axes(self, array: Array, count: int, scale: int) -> int:
        """Add components (m, n, ...) of the axes of n members; the index of the first.

        Those that are 1 or -1 at all entries are part of the program. A factor that varies must not be left out of a
        product that varies over fewer axes without it, such as one that varies over the axes `scale`.
        """
        place = self._members(array, count)
        if not self.masks[-1] & ~scale:
            self.units.update({place + k: x for k, x in _units(self.blocks[-1]).items()})
        return place


def _first(array: NDArray[Any], trailing: int) -> NDArray[Any]:
    """An array with its last axes, merged into one, before the others."""
    if trailing > 1:
        array = array.reshape(*array.shape[:-trailing], -1)
    return array.T if array.ndim < 3 else array.transpose(-1, *range(array.ndim - 1))


def _units(block: Array) -> dict[int, float]:
    """Those numbers of a block (m, ...) that are 1 or -1 at all entries, by their index in it."""
    rows = block.reshape(len(block), -1)
    found = {k: x for k, x in enumerate(rows[:, 0].tolist()) if abs(x) == 1.0}
    return {k: x for k, x in found.items() if all_of(rows[k] == x)}


class BatchLoads(Blocks):
    """The loads on a batch.

    Parameters
    ----------
    topology
        Its nodes and members, and the loads on them.
    grid
        The batch.

    Attributes
    ----------
    nodal
        Node, component and index of each load at a node that is not zero at all entries.
    shares
        DOF and index of the equivalent nodal loads of members, and of the weights of masses.
    key
        Nodes, components and DOFs of the loads, and over which axes they vary.
    """

    def __init__(self, topology: Topology, grid: Grid) -> None:
        super().__init__(grid)
        each = [(node, k, self.one(value)) for node, k, value in component_loads(topology)]
        found = member_and_mass_loads(topology, grid)
        shares = [(dof, self.one(np.asarray(share))) for dof, share in found if not is_zero(share)]
        used = self.used
        self.nodal = [(node, k, place) for node, k, place in each if used[place]]
        self.shares = [(dof, place) for dof, place in shares if used[place]]
        self.key: Hashable = self.pattern, (*self.nodal,), (*self.shares,)
