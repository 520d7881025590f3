"""Members whose stiffness varies over most of a large batch: never held as a whole, assembled chunk by chunk.

What is coupled is found once, in a first pass that looks at the deformations alone; the numbers follow when a chunk is
solved, and go with it. Each is a sum over the springs of a member, ``K = sum_i k_i b_i b_i^T``, made of operations
on whole arrays whose order does not depend on the chunk.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import reduce
from operator import or_

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, aligned
from .group import Group
from .parts import Grid, Value, combine, mask_of, product

# Entries looked at together in the first pass.
_CHUNK = 2**14
# A number (n, ...) of n pieces, or a float that is the same for all.
Number = Array | float
Pair = tuple[int, int]
# Stiffnesses, and by spring its deformation for a unit of each of the twelve displacements of the nodes.
Springs = tuple[list[Value], list[list[Value]]]


@dataclass(frozen=True)
class Entry:
    """A term of the stiffness: where it stands (i, j), the axes over which it varies, and what it is a sum over.

    Attributes
    ----------
    at
        DOF numbers.
    mask
        Batch axes.
    ends
        Which of the piece's twelve displacements these are.
    springs
        The springs that both deform.
    """

    at: Pair
    mask: int
    ends: Pair
    springs: tuple[int, ...]


@dataclass(frozen=True)
class VaryingMember:
    """What is known of a piece beforehand.

    Attributes
    ----------
    codes
        Of each number that its stiffness is made of, 0 where it is zero all over the batch; else one, and the axes over
        which it varies from the second bit on. Stiffnesses, deformations in local axes, axes at the ends.
    entries
        Terms of the stiffness.
    """

    codes: list[list[int]]
    entries: list[Entry]

    def widened(self, most: int, large: Sequence[bool]) -> VaryingMember:
        """The piece, each entry that is not left to the chunks counted as varying over the axes of `most`."""
        wide = [each if large[each.mask] else replace(each, mask=each.mask | most) for each in self.entries]
        return replace(self, entries=wide)


@dataclass(frozen=True)
class Varying:
    """Stiffness of such members, its pattern known.

    Attributes
    ----------
    grid
        The batch.
    groups
        The members, by piece.
    """

    grid: Grid
    groups: Sequence[tuple[Group, list[VaryingMember]]]

    @classmethod
    def of(cls, groups: Iterable[Group], grid: Grid, large: Sequence[bool]) -> Varying:
        """Find the entries that `groups` have; those are left out whose stiffness is the same over the batch after all.

        Parameters
        ----------
        groups
            Members that may vary.
        grid
            The batch.
        large
            By mask, whether what varies so is left to the chunks.
        """
        found = []
        for group in groups:
            pieces = _pieces(group, grid)
            masks = {entry.mask for piece in pieces for entry in piece.entries}
            most = reduce(or_, (mask for mask in masks if large[mask]), 0)
            if most:
                # what is put where it meets the chunks counts as what varies with them
                found.append((group, [piece.widened(most, large) for piece in pieces]))
        return cls(grid, found)

    @property
    def entries(self) -> Iterator[Entry]:
        """All entries."""
        return (entry for _, pieces in self.groups for piece in pieces for entry in piece.entries)

    def within(self, own: set[int], coupled: set[int]) -> Varying | None:
        """Those of one component: between DOFs `coupled`, one at least its `own`; None where there are none."""
        groups = []
        for group, pieces in self.groups:
            kept = [
                [e for e in piece.entries if coupled.issuperset(e.at) and not own.isdisjoint(e.at)] for piece in pieces
            ]
            at = [k for k, entries in enumerate(kept) if entries]
            if at:
                some = group.part(np.array(at)) if len(at) < len(pieces) else group
                groups.append((some, [VaryingMember(pieces[k].codes, kept[k]) for k in at]))
        return Varying(self.grid, groups) if groups else None

    @property
    def masks(self) -> list[int]:
        """Axes over which each of `numbers` varies."""
        each = (codes for _, pieces in self.groups for piece in pieces for codes in piece.codes)
        return [code >> 1 for codes in each for code in codes if code]

    def numbers(self, axis: int, indices: slice) -> list[Value]:
        """What the stiffness is made of at some indices of a batch axis: all that is not zero, piece by piece."""
        found: list[Value] = []
        for group, pieces in self.groups:
            given = _given(group.cut(axis, indices))
            for number, piece in enumerate(pieces):
                for array, codes in zip(given, piece.codes, strict=True):
                    used = [array[k] for k, code in enumerate(codes) if code]
                    found += [self.grid.value(each[number]) if isinstance(each, np.ndarray) else each for each in used]
        return found

    def values(self, numbers: Iterable[Value]) -> Iterator[tuple[Entry, Value]]:
        """The entries that these `numbers` make."""
        following = iter(numbers)
        for _, pieces in self.groups:
            for piece in pieces:
                each = [[next(following) if code else 0.0 for code in codes] for codes in piece.codes]
                yield from _summed(piece.entries, (each[0], _deformed(each)))


def _summed(entries: list[Entry], springs: Springs) -> Iterator[tuple[Entry, Value]]:
    stiffness, deformed = springs
    forces: dict[Pair, Value] = {}
    for entry in entries:
        a, b = entry.ends
        for i in entry.springs:
            if (i, a) not in forces:
                forces[i, a] = product(stiffness[i], deformed[i][a])
        yield entry, combine([(forces[i, a], deformed[i][b]) for i in entry.springs])


def _given(group: Group) -> list[Sequence[Number]]:
    """Stiffnesses, deformations in local axes, axes at the start and, where those differ, at the end."""
    stiffness, deformed = group.element.spring_numbers(group.length)
    local = [deformed.get((spring, dof), 0.0) for spring in range(len(stiffness)) for dof in range(12)]
    if all(axes is None for axes in group.axes):
        return [stiffness, local, group.element.axis_numbers(group.chord)]
    start, end = group.end_axes
    turns = [start] if end is start else [start, end]
    return [stiffness, local, *([turn[..., i, k] for i in range(3) for k in range(3)] for turn in turns)]


def _deformed(each: Sequence[Sequence[Value]]) -> list[list[Value]]:
    """By spring, its deformation for a unit of each of the twelve displacements in the nodes' axes."""
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


def _pieces(group: Group, grid: Grid) -> list[VaryingMember]:
    """The pieces, with the entries that are not zero all over the batch."""
    axis, slices = grid.slices(_CHUNK)
    found: list[list[NDArray[np.int64]]] = []
    for indices in slices:
        given = _given(group.cut(axis, indices))
        if not found:
            found = [[_codes(number, len(group.pieces), grid) for number in numbers] for numbers in given]
            continue
        # What does not vary, and what is known not to be zero, is not looked at again.
        open_ones = [
            (codes, k, number)
            for numbers, codes in zip(given, found, strict=True)
            for k, number in enumerate(numbers)
            if isinstance(number, np.ndarray) and number[0].size > 1 and not codes[k].all()
        ]
        if not open_ones:
            break
        for codes, k, number in open_ones:
            codes[k] |= _codes(number, len(group.pieces), grid)
    each = zip(*(np.stack(codes, axis=-1).tolist() for codes in found), strict=True)
    return [
        VaryingMember(list(codes), _pairs(dofs, *codes)) for dofs, codes in zip(group.dofs.tolist(), each, strict=True)
    ]


def _codes(number: Number, pieces: int, grid: Grid) -> NDArray[np.int64]:
    """Code of a number for each of n pieces, (n,)."""
    if not isinstance(number, np.ndarray):
        return np.full(pieces, int(number != 0.0))
    mask = mask_of(aligned(number[0], len(grid.shape)))
    # Most are not zero from the first entry on, or all over.
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
