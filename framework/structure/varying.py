"""Members whose stiffness varies over most of a large batch: never held as a whole, assembled chunk by chunk.

What is coupled is found once, in a first pass that looks at the deformations alone; the numbers follow when a chunk is
solved, and go with it. Each is a sum over the springs of a member, ``K = sum_i k_i b_i b_i^T``, made of operations
on whole arrays whose order does not depend on the chunk.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .group import Group
from .parts import Grid, Value, combine, is_zero

# Entries looked at together in the first pass.
_CHUNK = 2**13
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
class Varying:
    """Stiffness of such members, its pattern known.

    Attributes
    ----------
    grid
        The batch.
    groups
        The members, with the entries of each piece.
    """

    grid: Grid
    groups: Sequence[tuple[Group, list[list[Entry]]]]

    @classmethod
    def of(cls, groups: Iterable[Group], grid: Grid) -> Varying:
        """Find the entries that `groups` have."""
        return cls(grid, [(group, _entries(group, grid)) for group in groups])

    @property
    def entries(self) -> Iterator[Entry]:
        """All entries."""
        return (entry for _, pieces in self.groups for entries in pieces for entry in entries)

    def within(self, own: set[int], held: set[int]) -> Varying | None:
        """Those of one component: between DOFs `held`, one at least its `own`; None where there are none."""
        groups = []
        for group, pieces in self.groups:
            kept = [[e for e in entries if held.issuperset(e.at) and not own.isdisjoint(e.at)] for entries in pieces]
            if any(kept):
                groups.append((group, kept))
        return Varying(self.grid, groups) if groups else None

    def values(self, axis: int, indices: slice) -> Iterator[tuple[Entry, Value]]:
        """The numbers at some indices of a batch axis."""
        for group, pieces in self.groups:
            for entries, springs in zip(pieces, _springs(group.cut(axis, indices), self.grid), strict=True):
                yield from _summed(entries, springs)


def _summed(entries: list[Entry], springs: Springs) -> Iterator[tuple[Entry, Value]]:
    stiffness, deformed = springs
    forces: dict[Pair, Value] = {}
    for entry in entries:
        a, b = entry.ends
        for i in entry.springs:
            if (i, a) not in forces:
                forces[i, a] = combine([(stiffness[i], deformed[i][a])])
        yield entry, combine([(forces[i, a], deformed[i][b]) for i in entry.springs])


def _springs(group: Group, grid: Grid) -> Iterator[Springs]:
    """Of each piece, in the nodes' axes."""
    stiffness, rows = group.element.springs(group.length)
    start, end = group.turns
    for piece in range(len(group.pieces)):
        local = grid.components(rows[piece], trailing=2)
        first = grid.components(start[piece], trailing=2)
        turns = first, first if end is start else grid.components(end[piece], trailing=2)
        deformed = [
            [
                combine([(local[12 * i + 3 * block + k], turns[block // 2][3 * k + c]) for k in range(3)])
                for block in range(4)
                for c in range(3)
            ]
            for i in range(stiffness.shape[-1])
        ]
        yield grid.components(stiffness[piece]), deformed


def _entries(group: Group, grid: Grid) -> list[list[Entry]]:
    """Entries of each piece that are not zero all over the batch."""
    axis, slices = grid.slices(_CHUNK)
    codes: NDArray[np.int64] | int = 0
    for indices in slices:
        found = [
            [[_code(value, grid) for value in (*row, k)] for k, row in zip(stiffness, deformed, strict=True)]
            for stiffness, deformed in _springs(group.cut(axis, indices), grid)
        ]
        codes = codes | np.array(found, dtype=np.int64).reshape(len(group.pieces), -1, 13)
    assert isinstance(codes, np.ndarray)
    return [_pairs(dofs, code) for dofs, code in zip(group.dofs.tolist(), codes, strict=True)]


def _code(value: Value, grid: Grid) -> int:
    """0 for a zero; else one, and the axes over which it varies from the second bit on."""
    return 0 if is_zero(value) else 1 + 2 * grid.mask(value)


def _pairs(dofs: list[int], codes: NDArray[np.int64]) -> list[Entry]:
    found, code = [], codes.tolist()
    for a in range(12):
        for b in range(a, 12):
            springs = tuple(i for i, row in enumerate(code) if row[a] and row[b] and row[12])
            mask = 0
            for i in springs:
                mask |= (code[i][a] | code[i][b] | code[i][12]) >> 1
            if springs:
                found.append(Entry((dofs[a], dofs[b]), mask, (a, b), springs))
    return found
