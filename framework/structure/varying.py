"""Members whose stiffness varies over most of a large batch: assembled chunk by chunk, never stored as a whole.

A first pass over the numbers of the members finds which entries of the stiffness are not zero; the values are computed
when a chunk is solved, and dropped with it. Each entry is a sum over the springs of a member, ``K = sum_i k_i b_i
b_i^T``, by array operations in an order that does not depend on the chunk. Springs and axes of prismatic members are
part of these operations, see `linkframe.framework.structure.member_numbers`; those of others are given.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_

import numpy as np
from numpy.typing import NDArray

from ..batch import aligned
from .group import Group
from .member_numbers import MemberNumbers, Number, numbers_of
from .parts import Grid, Value, combine, mask_of, product

# Batch entries examined at a time in the first pass.
_CHUNK = 2**14
Pair = tuple[int, int]
# Stiffnesses of the springs, and for each spring its deformation per unit of the twelve displacements of the nodes.
Springs = tuple[list[Value], list[list[Value]]]


@dataclass(frozen=True)
class Entry:
    """A contribution of one piece to an entry of the stiffness.

    Attributes
    ----------
    at
        DOF numbers (i, j) of the entry.
    mask
        Mask of the batch axes over which it varies.
    ends
        Indices of the two displacements among the piece's twelve.
    springs
        Indices of the springs that both displacements deform, over which it is a sum.
    """

    at: Pair
    mask: int
    ends: Pair
    springs: tuple[int, ...]


@dataclass(frozen=True)
class VaryingMember:
    """The pattern of the stiffness of one piece.

    Attributes
    ----------
    codes
        For each number from which the stiffness is computed: 0 if it is zero in the whole batch, else ``1 + 2 mask``.
        The lists are those of `MemberNumbers`.
    entries
        Contributions to the stiffness.
    """

    codes: list[list[int]]
    entries: list[Entry]

    def widened(self, most: int, large: Sequence[bool]) -> VaryingMember:
        """The pattern in which every entry counts as left to the chunks: its mask is widened by `most` if need be."""
        wide = [each if large[each.mask] else replace(each, mask=each.mask | most) for each in self.entries]
        return replace(self, entries=wide)


@dataclass(frozen=True)
class Varying:
    """Members whose stiffness is assembled by the chunks, with its pattern.

    Attributes
    ----------
    grid
        The batch.
    groups
        Groups of members: the numbers from which their stiffness is computed, and the patterns of the pieces.
    """

    grid: Grid
    groups: Sequence[tuple[MemberNumbers, list[VaryingMember]]]

    @classmethod
    def of(cls, groups: Iterable[Group], grid: Grid, large: Sequence[bool]) -> Varying:
        """Find the patterns of groups; those whose stiffness turns out not to vary so much are left out.

        Parameters
        ----------
        groups
            Groups of members that may vary.
        grid
            The batch.
        large
            For each mask, whether numbers that vary over it are left to the chunks.
        """
        found = []
        for group in groups:
            numbers = numbers_of(group, grid)
            pieces = _pieces(numbers)
            masks = {entry.mask for piece in pieces for entry in piece.entries}
            most = reduce(or_, (mask for mask in masks if large[mask]), 0)
            if most:
                # all entries of a piece are assembled by the chunks, so all count as varying with them
                found.append((numbers, [piece.widened(most, large) for piece in pieces]))
        return cls(grid, found)

    @property
    def entries(self) -> Iterator[Entry]:
        """Contributions of all pieces."""
        return (entry for _, pieces in self.groups for piece in pieces for entry in piece.entries)

    def within(self, own: set[int], coupled: set[int]) -> Varying | None:
        """The members of one component: between DOFs `coupled`, of which one at least is its `own`; None for none."""
        groups = []
        for numbers, pieces in self.groups:
            kept = [
                [e for e in piece.entries if coupled.issuperset(e.at) and not own.isdisjoint(e.at)] for piece in pieces
            ]
            at = [k for k, entries in enumerate(kept) if entries]
            if at:
                some = numbers.part(np.array(at)) if len(at) < len(pieces) else numbers
                groups.append((some, [VaryingMember(pieces[k].codes, kept[k]) for k in at]))
        return Varying(self.grid, groups) if groups else None

    @property
    def masks(self) -> list[int]:
        """Mask of each of `numbers`."""
        each = (codes for _, pieces in self.groups for piece in pieces for codes in piece.codes)
        return [code >> 1 for codes in each for code in codes if code]

    def numbers(self, axis: int, indices: slice) -> list[Value]:
        """The numbers from which the stiffness is computed, at some indices of a batch axis, piece by piece, without
        those that are zero in the whole batch.
        """
        found: list[Value] = []
        for numbers, pieces in self.groups:
            given = numbers.at(axis, indices)
            for number, piece in enumerate(pieces):
                for array, codes in zip(given, piece.codes, strict=True):
                    used = [array[k] for k, code in enumerate(codes) if code]
                    found += [self.grid.value(each[number]) if isinstance(each, np.ndarray) else each for each in used]
        return found

    def values(self, numbers: Iterable[Value]) -> Iterator[tuple[Entry, Value]]:
        """The contributions to the stiffness, computed from `numbers`."""
        return self.summed(self.springs(numbers))

    def springs(self, numbers: Iterable[Value]) -> Iterator[Sequence[Sequence[Value]]]:
        """For each piece, stiffnesses of its springs, deformations in local axes, and axes at the ends."""
        following = iter(numbers)
        for given, pieces in self.groups:
            for piece in pieces:
                yield given.springs([[next(following) if code else 0.0 for code in codes] for codes in piece.codes])

    def summed(self, springs: Iterable[Sequence[Sequence[Value]]]) -> Iterator[tuple[Entry, Value]]:
        """The contributions to the stiffness, computed from the `springs` of all pieces."""
        pieces = (piece for _, pieces in self.groups for piece in pieces)
        for piece, each in zip(pieces, springs, strict=True):
            yield from _summed(piece.entries, (list(each[0]), _deformed(each)))


def _summed(entries: list[Entry], springs: Springs) -> Iterator[tuple[Entry, Value]]:
    stiffness, deformed = springs
    forces: dict[Pair, Value] = {}
    for entry in entries:
        a, b = entry.ends
        for i in entry.springs:
            if (i, a) not in forces:
                forces[i, a] = product(stiffness[i], deformed[i][a])
        yield entry, combine([(forces[i, a], deformed[i][b]) for i in entry.springs])


def _deformed(each: Sequence[Sequence[Value]]) -> list[list[Value]]:
    """For each spring, its deformation per unit of the twelve displacements in the nodes' axes."""
    stiffness, local, *end_axes = each
    return [
        [
            combine(
                [(local[12 * i + 3 * block + k], end_axes[block // 2 % len(end_axes)][3 * k + c]) for k in range(3)]
            )
            for block in range(4)
            for c in range(3)
        ]
        for i in range(len(stiffness))
    ]


def _pieces(numbers: MemberNumbers) -> list[VaryingMember]:
    """The patterns of the pieces, with the entries that are not zero in the whole batch."""
    group, grid = numbers.group, numbers.grid
    axis, (first, *others) = grid.slices(_CHUNK)
    given = numbers.at(axis, first)
    found = [[_codes(number, len(group.pieces), grid) for number in each] for each in given]
    # Numbers that do not vary, or are known not to be zero, are not examined again.
    open_ones = [
        (at, k)
        for at, (each, codes) in enumerate(zip(given, found, strict=True))
        for k, number in enumerate(each)
        if isinstance(number, np.ndarray) and number[0].size > 1 and not codes[k].all()
    ]
    for indices in others:
        if not open_ones:
            break
        given = numbers.at(axis, indices)
        for at, k in open_ones:
            found[at][k] |= _codes(given[at][k], len(group.pieces), grid)
        open_ones = [(at, k) for at, k in open_ones if not found[at][k].all()]
    each_piece = zip(*(np.stack(codes, axis=-1).tolist() for codes in found), strict=True)
    known: dict[str, list[list[int]]] = {}
    out = []
    for dofs, codes in zip(group.dofs.tolist(), each_piece, strict=True):
        key = str(codes)
        if key not in known:
            known[key] = numbers.codes_of_springs(codes)
        out.append(VaryingMember(list(codes), _pairs(dofs, *known[key])))
    return out


def _codes(number: Number, pieces: int, grid: Grid) -> NDArray[np.int64]:
    """Code of a number for each of n pieces, (n,)."""
    if not isinstance(number, np.ndarray):
        return np.full(pieces, int(number != 0.0))
    mask = mask_of(aligned(number[0], len(grid.shape)))
    # Testing the first entry first is faster, as most numbers are nonzero there.
    used = [bool(each.flat[0] != 0.0 or each.any()) for each in number]
    return np.where(used, 1 + 2 * mask, 0)


def _pairs(dofs: list[int], stiffness: list[int], local: list[int], *end_axes: list[int]) -> list[Entry]:
    code = [[0] * 12 for _ in stiffness]
    for i, row in enumerate(code):
        for a in range(12):
            turn = end_axes[a // 6 % len(end_axes)]
            for k in range(3):
                one, other = local[12 * i + 3 * (a // 3) + k], turn[3 * k + a % 3]
                row[a] |= one | other if one and other else 0
    found = []
    for a in range(12):
        for b in range(a, 12):
            springs = tuple(i for i, row in enumerate(code) if row[a] and row[b] and stiffness[i])
            mask = 0
            for i in springs:
                mask |= (code[i][a] | code[i][b] | stiffness[i]) >> 1
            if springs:
                found.append(Entry((dofs[a], dofs[b]), mask, (a, b), springs))
    return found
