"""The numbers of a batch whose joints close no loop, as input to the program of its topology.

As `linkframe.framework.batched.one_entry` does for a single entry: the program is found by a key, which tells which
number belongs to which joint, member or load, over which batch axes it varies, and which are zero at all entries.
"""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO, Array, aligned, all_of, any_of, distinct
from ..structure.assembly import component_loads, member_and_mass_loads
from ..structure.edge import GROUND, preference
from ..structure.group import Group, precise
from ..structure.parts import Grid, Value, is_zero, mask_of_shape
from ..structure.topology import Topology
from ..structure.varying import spring_values
from .one_entry import UNITS, Head

# Largest number of entries of a short batch: all that the elimination computes is computed for the whole batch at once.
SHORT = 2**10
# Largest number of entries of a batch that has a program.
MEDIUM = 2**14
# Numbers are gathered, and a program is recorded, after this many solutions of batches that look alike: recording takes
# as long as two of them, and saves half of each that follows.
FEW = 2
# Up to so many numbers are looked at one by one.
_LOOKS = 4
# A number that is zero at all entries, or not there.
ABSENT = -1
_NONE = [ABSENT] * 6
_ONE = np.ones(1, dtype=bool)


# Of each block of which numbers are wanted: which block, the places of the wanted numbers, and which of its own these
# are.
Columns = list[tuple[int, slice, "slice | NDArray[np.int64]"]]


class Met:
    """How often batches that look alike were planned, and whether one of them turned out to have no program."""

    count = 0
    without = False


class Blocks:
    """Numbers that vary over a batch, in blocks of those that belong together.

    Parameters
    ----------
    grid
        The batch.

    Attributes
    ----------
    blocks
        Arrays (..., m) with all batch axes.
    masks
        For each block the mask of the axes over which it varies.
    used
        For each block, which of its numbers are not zero at all entries, (m,).
    starts
        For each block, the index of its first number among all numbers.
    """

    def __init__(self, grid: Grid) -> None:
        self.grid, self.count = grid, 0
        self.blocks: list[NDArray[Any]] = []
        self.masks: list[int] = []
        self.used: list[NDArray[np.bool_]] = []
        self.starts: list[int] = []

    def put(self, array: NDArray[Any]) -> list[int]:
        """Add a block (..., m); the index of each of its numbers, `ABSENT` where it is zero at all entries."""
        start, found = self.count, self._put(array)
        return [start + k if some else ABSENT for k, some in enumerate(found.tolist())]

    def one(self, number: Array) -> int:
        """Add a number (...); its index, `ABSENT` if it is zero at all entries."""
        # most are not zero at the first entry, and need no second look
        if number.flat[0] == 0.0 and not number.any():
            return ABSENT
        self._add(aligned(number[..., None], len(self.grid.shape), 1), _ONE)
        return self.count - 1

    def _put(self, array: NDArray[Any]) -> NDArray[np.bool_]:
        whole = aligned(array, len(self.grid.shape), 1)
        used = _used(whole.reshape(-1, whole.shape[-1]))
        self._add(whole, used)
        return used

    def _add(self, block: NDArray[Any], used: NDArray[np.bool_]) -> None:
        self.blocks.append(block)
        self.masks.append(mask_of_shape(block.shape[:-1]))
        self.used.append(used)
        self.starts.append(self.count)
        self.count += block.shape[-1]

    @property
    def pattern(self) -> Hashable:
        """What varies over which axes, and which numbers are zero at all entries."""
        return (*self.masks, *self.starts), np.concatenate(self.used).tobytes() if self.used else b""

    def values(self, wanted: Sequence[int]) -> list[Value]:
        """Some of the numbers by index, in order, contiguous, each of the shape over which it varies."""
        found: list[Value] = []
        ends = np.searchsorted(wanted, [*self.starts, self.count]).tolist()
        for block, mask, start, a, b in zip(self.blocks, self.masks, self.starts, ends, ends[1:], strict=False):
            if b == a:
                continue
            own = [k - start for k in wanted[a:b]]
            if not mask:
                numbers = block.reshape(-1)
                found += [numbers[k] for k in own]
            elif block.shape[-1] == 1:
                found.append(np.ascontiguousarray(block[..., 0]))
            else:
                columns = np.ascontiguousarray(np.moveaxis(block, -1, 0))
                found += [columns[k] for k in own]
        return found

    def columns(self, wanted: Sequence[int]) -> Columns:
        """Where some of the numbers are, given by index in order, in all batches of this pattern."""
        ends = np.searchsorted(wanted, [*self.starts, self.count]).tolist()
        found: Columns = []
        for number, (start, (a, b)) in enumerate(zip(self.starts, pairwise(ends), strict=True)):
            own = [k - start for k in wanted[a:b]]
            if own:
                together = own[-1] - own[0] == len(own) - 1
                found.append((number, slice(a, b), slice(own[0], own[-1] + 1) if together else np.array(own)))
        return found

    def table(self, columns: Columns) -> Array:
        """Some of the numbers, given by `columns`, at each entry: (entries, n)."""
        shape = self.grid.shape
        out = np.empty((*shape, columns[-1][1].stop if columns else 0))
        for number, place, own in columns:
            out[..., place] = self.blocks[number][..., own]
        return out.reshape(math.prod(shape), out.shape[-1])


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
        For each member, the indices of stiffnesses, of deformations in local axes, and of the axes at the ends.
    """

    pieces: tuple[tuple[tuple[int, ...], ...], ...]


class LinkNumbers(NamedTuple):
    """The numbers of a joint, tie or support, by index.

    Attributes
    ----------
    springs, pitch, offsets
        Six springs, the pitch over 2 pi, six offsets.
    axes
        Nine components of the axes; None if these are the global ones.
    arm
        Three components of the arm of a rigid link; None for others.
    """

    springs: list[int]
    pitch: int
    offsets: list[int]
    axes: list[int] | None = None
    arm: list[int] | None = None


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

    Attributes
    ----------
    links
        Joints, ties and supports in turn.
    order
        Indices of these in order of preference for the joint tree.
    turns
        Indices of the components of the axes of bodies, by name.
    units
        Those of the numbers of axes, arms and deformations that are 0, 1 or -1 at all entries, and so are part of the
        program.
    members
        The groups of members.
    key
        What each number belongs to, over which axes it varies, and which are zero.
    former
        The program that was last run on these numbers, and the results of its first part.
    """

    def __init__(self, topology: Topology, grid: Grid, met: Met) -> None:
        super().__init__(grid)
        self.topology, self.met = topology, met
        self.links: list[LinkNumbers] = []
        self.units: dict[int, float] = {}
        heads = [*self._joints(), *self._ties(), *self._supports()]
        self.order = preference([ends for _, ends, _ in heads], [strength for _, _, strength in heads])
        self.turns: dict[str, list[int]] = {}
        for body in topology.bodies:
            if body is not None and body not in self.turns:
                self.turns[body] = self._turned(topology.frame.bodies[body].axes)
        places = {body: k for k, body in enumerate(self.turns)}
        own = self._springs if self.short else self._pieces
        self.members: list[Piecewise | PieceNumbers] = [own(group) for group in topology.groups]
        self.former: tuple[Any, Any] | None = None
        self.key: Hashable = (
            grid.shape,
            self.pattern,
            tuple([(head, ends) for head, ends, _ in heads]),
            # numbers that are zero have no place, so that the pattern does not tell to what the others belong
            tuple([(link.pitch, *link.offsets) for link in self.links]),
            (*self.order,),
            tuple([None if body is None else places[body] for body in topology.bodies]),
            (*self.units.items(),),
            tuple([(group.dofs.tobytes(), found) for group, found in zip(topology.groups, self.members, strict=True)]),
        )

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
            element, offsets = link.element, frame.offsets.get(name, {})
            stiffness, most = element.stiffness, float(element.stiffness.max())
            ideal: tuple[int, ...] = ()
            if most == np.inf:
                infinite = np.isinf(stiffness)
                ideal = tuple(np.flatnonzero(infinite.reshape(-1, 6)[0]).tolist())
                stiffness = np.where(infinite, 0.0, stiffness)
                most = float(stiffness.max())
            axes = None if element.axes is None else self._turned(element.axes)
            springs, pitch = self.put(stiffness), self.one(element.pitch / (2.0 * np.pi))
            self.links.append(LinkNumbers(springs, pitch, self._six(offsets), axes))
            strength = len(ideal), most
            heads.append((("joint", ideal, axes is None), (number[link.first], number[link.second]), strength))
        return heads

    def _ties(self) -> list[Head]:
        frame, number, heads = self.topology.frame, self.topology.number, list[Head]()
        for tie in frame.ties:
            arm = None
            if tie.rigid:
                arm = self._turned(frame.position(tie.slave) - frame.position(tie.master))
            self.links.append(LinkNumbers(_NONE, ABSENT, _NONE, arm=arm))
            ends = number[tie.master], number[tie.slave]
            heads.append((("tie", tie.components, tie.rigid), ends, (len(tie.components), 0.0)))
        return heads

    def _supports(self) -> list[Head]:
        frame, number, heads = self.topology.frame, self.topology.number, list[Head]()
        for node, constrained in frame.supports.items():
            self.links.append(LinkNumbers(_NONE, ABSENT, self._six(constrained)))
            ideal = (*sorted(constrained),)
            heads.append((("support", ideal), (GROUND, number[node]), (len(ideal), 0.0)))
        return heads

    def _six(self, given: Mapping[int, Array]) -> list[int]:
        return [self.one(given[k]) if k in given and given[k] is not ZERO else ABSENT for k in range(6)]

    def _turned(self, array: Array) -> list[int]:
        """Add axes (..., 3, 3) or an arm (..., 3), whose numbers 0, 1 and -1 are part of the program."""
        trailing = 2 if array.shape[-2:] == (3, 3) else 1
        start = self.count
        found = self.put(array.reshape(*array.shape[:-trailing], -1))
        if not self.masks[-1]:
            numbers = self.blocks[-1].reshape(-1).tolist()
            self.units.update({k: x for k, x in enumerate(numbers, start) if x in UNITS})
        return found

    def _pieces(self, group: Group) -> PieceNumbers:
        each = spring_values(group, self.grid, 0, slice(None))
        found = [[self._each(number, len(group.pieces)) for number in numbers] for numbers in each]
        pieces = [tuple([tuple([k[n] for k in numbers]) for numbers in found]) for n in range(len(group.pieces))]
        return PieceNumbers(tuple(pieces))

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
        first = self._members(stiffness, count, 1)
        scale = self.masks[-1]
        varying = [number for number in local.values() if type(number) is not float]
        leaders, which = distinct(varying)
        known = [self._members(np.asarray(varying[k]), count, 0) for k in leaders]
        place = iter([known[k] for k in which.tolist()])
        found = tuple([(at, number if type(number) is float else next(place)) for at, number in local.items()])
        axes = tuple([self._axes(each, count, scale) for each in group.distinct_axes])
        return Piecewise(first, found, axes, count, stiffness.shape[-1], precise(stiffness))

    def _turned_springs(self, group: Group) -> Piecewise:
        """`_springs` of members whose deformations are sums of several products in the nodes' axes."""
        stiffness, rows, fine = group.turned_springs()
        count, springs = len(group.pieces), stiffness.shape[-1]
        first = self._members(stiffness, count, 1)
        place = self._axes(rows, count, self.masks[-1])
        found = [((k, a), place + (12 * k + a) * count) for k in range(springs) for a in range(12)]
        return Piecewise(first, tuple(found), (), count, springs, fine)

    def _members(self, numbers: Array, count: int, trailing: int) -> int:
        """Add numbers (n, ...) of n members, with so many axes behind the batch; the index of the first.

        Those of all members that belong to one another come together, as they often do in memory.
        """
        place = self.count
        if len(numbers) != count:
            numbers = np.broadcast_to(numbers, (count, *numbers.shape[1:]))
        batch = numbers.shape[1 : numbers.ndim - trailing]
        self._put(numbers.transpose(*range(1, numbers.ndim), 0).reshape(*batch, -1))
        return place

    def _axes(self, array: Array, count: int, scale: int) -> int:
        """Add numbers (n, ..., i, j) of n members; the index of the first.

        Those that are 1 or -1 at all entries are part of the program. A factor that varies must not be left out of a
        product that varies over fewer axes without it, such as one that varies over the axes `scale`.
        """
        place = self._members(array, count, 2)
        if not self.masks[-1] & ~scale:
            self.units.update({place + k: x for k, x in _units(self.blocks[-1]).items()})
        return place


def _used(rows: NDArray[Any]) -> NDArray[np.bool_]:
    """Which numbers (entries, m) are not zero at all entries, (m,)."""
    used: NDArray[np.bool_] = rows[0] != 0.0
    # most are not zero at the first entry, and need no second look
    missing = [k for k, some in enumerate(used.tolist()) if not some]
    if len(missing) <= _LOOKS:
        for k in missing:
            used[k] = any_of(rows[:, k])
        return used
    found: NDArray[np.bool_] = (rows != 0.0).any(axis=0)
    return found


def _units(block: Array) -> dict[int, float]:
    """Those numbers of a block (..., m) that are 1 or -1 at all entries, by their index in it."""
    rows = block.reshape(-1, block.shape[-1])
    found = {k: x for k, x in enumerate(rows[0].tolist()) if abs(x) == 1.0}
    if len(rows) == 1 or not found:
        return found
    if len(found) <= _LOOKS:
        return {k: x for k, x in found.items() if all_of(rows[:, k] == x)}
    same = (rows[:, [*found]] == [*found.values()]).all(axis=0).tolist()
    return {k: x for (k, x), alike in zip(found.items(), same, strict=True) if alike}


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
        self.nodal = [(node, k, place) for node, k, place in each if place != ABSENT]
        found = member_and_mass_loads(topology, grid)
        self.shares = [(dof, self.one(np.asarray(share))) for dof, share in found if not is_zero(share)]
        self.key: Hashable = self.pattern, (*self.nodal,), (*self.shares,)
