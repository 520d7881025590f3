"""Members divided into pieces, and groups of similar pieces that are evaluated together as stacks."""

from __future__ import annotations

import copy
from collections.abc import Collection, Hashable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from ..batch import ZERO, Array, Shape, distinct
from ..description import Description
from ..entries import Stretch
from ..examined import Examined, examined
from ..lazily import cached_property
from ..protocol import LineElement, is_proven
from ..stacking import changed, stacked
from .group import Group, Index
from .numbered_pieces import NumberedPieces, index_in_member
from .parts import Extended

__all__ = ["Group", "Index", "Piece", "Topology"]

# Cached properties that follow from the positions of nodes alone, and from the elements of members alone.
_OF_NODES, _OF_ELEMENTS = ("plain_positions", "chords"), ("strained",)


@dataclass(slots=True)
class Piece:
    """Part `index` of the `count` equal parts of a member, between two node numbers."""

    member: str
    index: int
    count: int
    element: LineElement
    nodes: tuple[int, int]


class FormerStacks(NamedTuple):
    """Groups of an earlier frame with the same connections.

    Attributes
    ----------
    groups
        The groups.
    changed
        Numbers of the members whose elements differ from those of the groups.
    others
        Numbers of the members whose elements differ from those of the frame before this one.
    """

    groups: list[Group]
    changed: frozenset[int]
    others: set[int]


@dataclass(eq=False)
class Topology(NumberedPieces):
    """Numbered nodes and pieces, and the groups in which pieces are evaluated.

    Attributes
    ----------
    gathered
        Groups of an earlier frame with the same connections, which differ from those of this frame in numbers alone.
    """

    gathered: FormerStacks | None = None

    @cached_property
    def pieces(self) -> list[Piece]:
        """All pieces, by number."""
        names, counts = list(self.frame.members), self.counts.tolist()
        each = zip(
            self.members.tolist(),
            index_in_member(self.counts).tolist(),
            self._elements,
            self.ends.tolist(),
            strict=True,
        )
        return [Piece(names[m], index, counts[m], element, (a, b)) for m, index, element, (a, b) in each]

    @cached_property
    def _elements(self) -> list[LineElement]:
        """Element of each piece."""
        names, own = list(self.frame.members), [member.element for member in self.frame.members.values()]
        leaders, which = self.distinct_elements
        each = [examined(own[k], names[k]) for k in leaders]
        if len(self.ends) == len(self.counts):
            return each * len(which) if len(each) == 1 else [each[k] for k in which.tolist()]
        whole = zip((each[k] for k in which.tolist()), self.counts.tolist(), strict=True)
        return [e for element, n in whole for e in ([element] if n == 1 else [element.part(i, n) for i in range(n)])]

    @cached_property
    def groups(self) -> list[Group]:
        """Groups of pieces with the same family or kind of element, batch shape of the geometry, and bodies."""
        if self.gathered is not None:
            return [self._remade(group, self.gathered.changed) for group in self.gathered.groups]
        kinds: dict[Hashable, int] = {}
        leaders, which = self.distinct_elements if len(self.ends) == len(self.counts) else distinct(self._elements)
        alike = [_family(self._elements[k]) for k in leaders]
        chords = self.chords
        if len(leaders) == 1 and isinstance(chords, np.ndarray):
            groups = [self._group(np.arange(len(chords)), chords)]
            self._check_kind(groups[0])
            return groups
        codes = np.array([kinds.setdefault(each, len(kinds)) for each in alike], dtype=np.int64)[which]
        if not isinstance(chords, np.ndarray):
            keys: dict[Hashable, int] = {}
            ends = ((self.bodies[a], self.bodies[b]) for a, b in self.ends.tolist())
            where = zip(codes.tolist(), (chord.shape for chord in chords), ends, strict=True)
            codes = np.array([keys.setdefault(key, len(keys)) for key in where], dtype=np.int64)
        members = [np.arange(len(codes))]
        if codes.any():
            members = np.split(np.argsort(codes, kind="stable"), np.cumsum(np.bincount(codes))[:-1])
        groups = [self._group(numbers, chords) for numbers in members if len(numbers)]
        for group in groups:
            self._check_kind(group)
        return groups

    def _check_kind(self, group: Group) -> None:
        """Raise an error if elements of a group claim to be alike, by `kind` or `family`, and are not."""
        if isinstance(group.element, Examined):
            elements = [self._elements[piece] for piece in group.pieces.tolist()]
            length = group.length[:1].reshape(-1)[:1].reshape((1,) * group.length.ndim)
            for other in (elements[k] for k in distinct(elements)[0][1:]):
                assert isinstance(other, Examined)
                other.same_as(group.element, length)

    @property
    def loaded_shape(self) -> Shape:
        """Batch shape over which loaded members and their loads vary; () without loads on members."""
        frame = self.frame
        weight = [] if frame.weight is None else [frame.weight]
        given = [array for loads in frame.member_loads.values() for load in loads for array in load.forces] + weight
        if not given and not self.strained:
            return ()
        shapes = {array.shape[:-1] for array in given} | {group.stiffness_shape for group in self.groups}
        shapes |= {group.body.shape[:-2] for group in self.groups if group.body is not None}
        return np.broadcast_shapes(*shapes)

    def cut(self, axis: int, indices: slice) -> Topology:
        """The members and their loads at some indices of a batch axis."""
        change = Stretch(ndim=len(self.frame.shape), axis=axis, indices=indices)
        frame = copy.copy(self.frame)
        frame.weight = None if frame.weight is None else change(frame.weight, 1)
        frame.member_loads = {
            member: [changed(load, change) for load in loads] for member, loads in frame.member_loads.items()
        }
        clone = self.loaded(frame)
        clone.groups = [group.cut(axis, indices) for group in self.groups]
        return clone

    def loaded(self, frame: Description) -> Topology:
        """The same members, with all properties computed so far, under the loads of another description."""
        clone = object.__new__(type(self))
        vars(clone).update(vars(self), frame=frame)
        return clone

    def remade(self, frame: Description, *, moved: bool, elements: bool) -> Topology:
        """The topology of a frame with the same connections but other elements or positions, reusing these groups.

        Parameters
        ----------
        frame
            Description with the same connections, whose members are not divided.
        moved
            Whether positions of its nodes differ.
        elements
            Whether elements of its members may differ.
        """
        others = _others(self.frame, frame) if elements else set()
        before, after = ([], []) if not others else (_elements(each, others) for each in (self.frame, frame))
        if others and not (len(self.ends) == len(self.counts) and all(new.exact for new in after)):
            return Topology.of(frame, cut=False)
        clone = Topology(frame, self.number, self.bodies, self.counts, self.ends)
        kept = (*(() if moved else _OF_NODES), *(() if others else _OF_ELEMENTS))
        vars(clone).update({name: vars(self)[name] for name in kept if name in vars(self)})
        known = self.gathered
        if "groups" in vars(self):
            known = FormerStacks(self.groups, frozenset(), set())
        elif frame.shape:
            known = None  # a batch whose program did without groups: the next one most likely will, too
        if known is None or not (len(self.ends) == len(self.counts) and _alike_in_shape(self.chords, clone.chords)):
            return clone
        if all(_alike_in_stack(*each) for each in zip(before, after, strict=True)):
            clone.gathered = FormerStacks(known.groups, known.changed.union(others), others)
        return clone

    def _remade(self, group: Group, changed: frozenset[int]) -> Group:
        """A group with the positions, and the elements of the `changed` members, of this frame."""
        chords, pieces = self.chords, group.pieces.tolist()
        each = chords[group.pieces] if isinstance(chords, np.ndarray) else np.array([chords[k] for k in pieces])
        chord = each.reshape(group.chord.shape)
        if changed and not changed.isdisjoint(pieces):
            return group.between(chord, self._stacked(self._elements_of(pieces)))
        return group.between(chord)

    def stiffness_beside(self, former: Topology, known: Sequence[NDArray[Any]]) -> list[NDArray[Any]] | None:
        """Stiffness of the groups at a single batch entry, reused for members that are the same as in `former`.

        Parameters
        ----------
        former
            The topology from which this one was `remade`.
        known
            Stiffness of its groups, (n, 12, 12) each.

        Returns
        -------
        list of ndarray or None
            Stiffness as by `Group.extended_stiffness`, (n, 12, 12) for each group; None where groups are not reused.
        """
        if self.gathered is None or not isinstance(self.chords, np.ndarray):
            return None
        assert isinstance(former.chords, np.ndarray)
        groups, others = self.gathered.groups, self.gathered.others
        if self.chords is not former.chords:
            others = others.union(np.not_equal(self.chords, former.chords).nonzero()[0].tolist())
        each = enumerate(zip(groups, known, strict=True))
        return [self._stiffness(number, group, stack, others) for number, (group, stack) in each]

    def _stiffness(self, number: int, group: Group, stack: NDArray[Any], others: set[int]) -> NDArray[Any]:
        """Stiffness of a group, computed anew for its pieces in `others` and taken from `stack` for the rest."""
        at = [place for place, k in enumerate(group.pieces.tolist()) if k in others]
        if not at:
            return stack
        if len(at) == len(stack) or stack.dtype != Extended or not group.element.elementwise:
            return self.groups[number].extended_stiffness()
        assert isinstance(self.chords, np.ndarray)
        some = np.array(at)  # indexes five arrays, in half the time of a list
        pieces, out = group.pieces[some], stack.copy()
        element = self._stacked(self._elements_of(pieces.tolist()))
        chord = self.chords[pieces].reshape(len(at), *group.chord.shape[1:])
        part = Group(element, pieces, group.dofs[some], chord, group.counts[some], group.axes, group.body)
        out[some] = part.extended_stiffness()
        return out

    @property
    def stack_dofs(self) -> list[Index]:
        """DOF numbers of the pieces of each group, (n, 12)."""
        return [group.dofs for group in (self.groups if self.gathered is None else self.gathered.groups)]

    @cached_property
    def strained(self) -> bool:
        """Whether members have a free strain, such as by heat; may be True where such elements have been replaced."""
        if "groups" in vars(self):
            elements = [group.element for group in self.groups]
        elif self.gathered is None:
            members = [*self.frame.members.items()]
            elements = [examined(members[k][1].element, members[k][0]) for k in self.distinct_elements[0]]
        else:
            changed = self.gathered.changed
            elements = [group.element for group in self.gathered.groups] + self._elements_of(changed)
        return any(elements[k].free_strain(ZERO) is not None for k in distinct(elements)[0])

    @cached_property
    def geometry(self) -> tuple[object, ...] | None:
        """Key of the axes and deformations of all members, for given connections.

        None where they depend on more than the positions of nodes and `deforms_as` of the elements.
        """
        plain = self.plain_positions
        forms = None if plain is None else [group.element.deforms_as for group in self.groups]
        if plain is None or forms is None or None in forms:
            return None
        pieces = [group.pieces.tobytes() for group in self.groups] if len(forms) > 1 else []
        return plain.tobytes(), self.counts.tobytes(), *forms, *pieces

    @cached_property
    def chords(self) -> Array | list[Array]:
        """Chord of each piece's member, (..., 3)."""
        if (plain := self.plain_chords(np.float64)) is not None:
            return plain
        chords = [self.frame.chord(name) for name in self.frame.members]
        return [chords[member] for member in self.members.tolist()]

    def _elements_of(self, members: Collection[int]) -> list[LineElement]:
        """Elements of some members, which are not divided."""
        names = list(self.frame.members)
        return [examined(e, names[k]) for k, e in zip(members, _elements(self.frame, members), strict=True)]

    def _stacked(self, elements: list[LineElement]) -> LineElement:
        """One element for several pieces, its parameters being arrays where those of the elements differ."""
        one = elements[0]
        if len({*map(id, elements)}) == 1 or one.family is None:
            return one
        kind = one.kind
        if all(other is one or other.kind == kind for other in elements):
            return one
        whole: LineElement = stacked(elements, len(self.frame.shape))
        return whole

    def _group(self, numbers: Index, chords: Array | list[Array]) -> Group:
        ndim = len(self.frame.shape)
        whole = len(self.ends) == len(self.counts)
        alike = whole and len(self.distinct_elements[0]) == 1
        chosen = [self._elements[k] for k in (numbers[:1] if alike else numbers).tolist()]
        # numbers are in order, so that as many as there are pieces are all of them
        every: slice | Index = slice(None) if len(numbers) == len(self.ends) else numbers
        element, nodes = self._stacked(chosen), self.ends[every]
        chord = chords[every] if isinstance(chords, np.ndarray) else np.array([chords[k] for k in numbers.tolist()])
        chord = chord.reshape(len(chord), *(1,) * (ndim + 2 - chord.ndim), *chord.shape[1:])
        counts = self.counts[every if whole else self.members[numbers]].astype(float).reshape(-1, *(1,) * ndim)
        first, second = (self.bodies[node] for node in nodes[0].tolist())
        shared = first == second
        start = self.axes_of[first]
        ends = (None, None) if shared else (start, self.axes_of[second])
        dofs = (6 * nodes[:, :, None] + np.arange(6)).reshape(-1, 12)
        return Group(element, numbers, dofs, chord, counts, ends, start if shared else None)


def _others(one: Description, other: Description) -> set[int]:
    """Numbers of the members whose elements differ between two descriptions with the same members."""
    members = zip(one.members.values(), other.members.values(), strict=True)
    return {k for k, (a, b) in enumerate(members) if a is not b and a.element is not b.element}


def _alike_in_shape(one: Array | list[Array], other: Array | list[Array]) -> bool:
    """Whether the chords of two frames with the same connections vary over the same batch axes."""
    if isinstance(one, np.ndarray) or isinstance(other, np.ndarray):
        return isinstance(one, np.ndarray) and isinstance(other, np.ndarray)
    return [chord.shape for chord in one] == [chord.shape for chord in other]


def _elements(frame: Description, members: Collection[int]) -> list[LineElement]:
    """Elements of some members, as described."""
    each = list(frame.members.values())
    return [each[k].element for k in members]


def _family(element: LineElement) -> Hashable:
    """Key of elements that are evaluated together: family and batch shape, or else the kind."""
    family = element.family
    return element.kind if family is None else (family, element.shape)


def _alike_in_stack(before: LineElement, new: LineElement) -> bool:
    """Whether an element can replace another one in its group; only proven elements can."""
    return is_proven(before) and is_proven(new) and _family(before) == _family(new)
