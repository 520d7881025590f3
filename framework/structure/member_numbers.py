"""The numbers from which the stiffness of members follows, for parts of a large batch.

Those of most members are the stiffnesses of their springs, deformations and axes. Those of prismatic members with the
default axes are moduli, sizes of the section, and chord: springs and axes then follow by a few operations, which are
recorded with the others and may run as machine code.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable, Sequence
from typing import Any

import numpy as np

from ..batch import Array, aligned
from ..entries import Stretch
from ..orientation import level_axis_numbers
from ..protocol import SpringFormulas
from .group import Group, Index
from .parts import Grid, Value, is_zero, mask_of

# A number of each of n pieces, (n, ...), or a float that is the same for all.
Number = Array | float
# The chord, up to its length, of members along x, and their axes.
_X = (1.0, 0.0, 0.0)
ALONG_X: list[Value] = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0]


class MemberNumbers(ABC):
    """The numbers from which the stiffness of a group of n members follows.

    Parameters
    ----------
    group
        The members.
    grid
        The batch.
    """

    def __init__(self, group: Group, grid: Grid) -> None:
        self.group, self.grid = group, grid

    @abstractmethod
    def at(self, axis: int, indices: slice) -> list[Sequence[Number]]:
        """Lists of numbers at some indices of a batch axis; over which axes they vary is the same for all indices."""

    @abstractmethod
    def springs(self, numbers: Sequence[Sequence[Value]]) -> Sequence[Sequence[Value]]:
        """Stiffnesses of the springs, deformations in local axes, and axes at the start and, where they differ, at the
        end, of one member from its `numbers`: arrays, or terms of a recording.
        """

    @abstractmethod
    def part(self, part: Index) -> MemberNumbers:
        """The numbers of some of the members."""

    @property
    def kind(self) -> Hashable:
        """Key that tells how `springs` follow from the numbers."""
        return type(self)

    def codes_of_springs(self, codes: Sequence[Sequence[int]]) -> list[list[int]]:
        """Which of the `springs` of a member are not zero, and over which axes they vary, from `codes` of its numbers.

        The code of a number is 0 if it is zero in the whole batch, else ``1 + 2 mask``.
        """
        given = [[self._example(code) for code in each] for each in codes]
        return [[self._code(value) for value in each] for each in self.springs(given)]

    def _example(self, code: int) -> Value:
        """A positive number with a code."""
        if not code:
            return 0.0
        return np.full([1 + (code >> axis + 1 & 1) for axis in range(len(self.grid.shape))], 2.0)

    def _code(self, value: Value) -> int:
        return 1 + 2 * mask_of(value) if np.any(value) else 0


def numbers_of(group: Group, grid: Grid) -> MemberNumbers:
    """The numbers of a group of members in a batch."""
    formulas = group.element.formulas
    suits = formulas is not None and all(axes is None for axes in group.axes) and bool(np.all(group.counts == 1.0))
    if not suits or not (group.along_x or _all_aslant(group.chord)):
        return SpringNumbers(group, grid)
    assert formulas is not None
    return FormulaNumbers(group, grid, formulas, group.along_x, not np.count_nonzero(group.chord[..., 2]))


class SpringNumbers(MemberNumbers):
    """Springs, deformations and axes as they are."""

    def at(self, axis: int, indices: slice) -> list[Sequence[Number]]:
        return spring_values(self.group, self.grid, axis, indices)

    def springs(self, numbers: Sequence[Sequence[Value]]) -> Sequence[Sequence[Value]]:
        return numbers

    def part(self, part: Index) -> SpringNumbers:
        return SpringNumbers(self.group.part(part), self.grid)

    def codes_of_springs(self, codes: Sequence[Sequence[int]]) -> list[list[int]]:
        return [list(each) for each in codes]


class FormulaNumbers(MemberNumbers):
    """The inputs of the formulas of members, and their chords x, y, z with the length of x and y and that of all three.

    The former length is missing where the chords are along x, and the latter where the chords are level.

    Parameters
    ----------
    group, grid
        The members, none of which is along global z at any entry, and the batch.
    formulas
        Their formulas.
    along, level
        Whether all chords are along x, or level, of these members and those with which they were told apart.
    """

    def __init__(self, group: Group, grid: Grid, formulas: SpringFormulas, along: bool, level: bool) -> None:
        super().__init__(group, grid)
        self.formulas, self._along, self._level = formulas, along, level
        ndim, whole = len(grid.shape), (len(group.pieces), *(1,) * len(grid.shape))
        self._inputs: list[Number] = []
        for each in formulas.inputs:
            if isinstance(each, np.ndarray):
                each = aligned(each, ndim) if each.ndim <= ndim else each
                each = each if each.ndim > ndim else np.broadcast_to(each, (whole[0], *each.shape))
            self._inputs.append(each)

    def at(self, axis: int, indices: slice) -> list[Sequence[Number]]:
        change = Stretch(ndim=len(self.grid.shape), axis=axis, indices=indices)
        inputs = [change(each, 0) if isinstance(each, np.ndarray) else each for each in self._inputs]
        chord = change(self.group.chord, 1)
        x, y, z = chord[..., 0], chord[..., 1], chord[..., 2]
        if self._along:
            return [inputs, [x, 0.0, 0.0, 0.0, 0.0]]
        across = np.hypot(x, y)
        return [inputs, [x, y, 0.0, across, 0.0] if self._level else [x, y, z, across, np.hypot(across, z)]]

    def springs(self, numbers: Sequence[Sequence[Value]]) -> Sequence[Sequence[Value]]:
        return springs_by_formulas(self.formulas, *numbers)

    @property
    def kind(self) -> Hashable:
        return self.formulas.stiffness, self.formulas.deformations

    def part(self, part: Index) -> FormulaNumbers:
        some = self.group.part(part)
        assert some.element.formulas is not None
        return FormulaNumbers(some, self.grid, some.element.formulas, self._along, self._level)


def springs_by_formulas(
    formulas: SpringFormulas, inputs: Sequence[Any], chord: Sequence[Any]
) -> Sequence[Sequence[Value]]:
    """Stiffnesses, deformations in local axes and axes of a member, from the numbers of a `FormulaNumbers`."""
    x, y, z, across, whole = chord
    length = np.sqrt(x * x + y * y + z * z)
    stiffness = formulas.stiffness(inputs, length)
    deformations: list[Value] = [0.0] * (12 * len(stiffness))
    for (spring, dof), number in formulas.deformations(length).items():
        deformations[12 * spring + dof] = number
    if is_zero(across):
        return stiffness, deformations, ALONG_X
    return stiffness, deformations, level_axis_numbers(x, y, z, across, across if is_zero(whole) else whole)


def spring_values(whole: Group, grid: Grid, axis: int, indices: slice) -> list[Sequence[Number]]:
    """Stiffnesses, deformations in local axes, axes at the start and, where they differ, at the end, of a group.

    They are those at some indices of a batch axis; which of them vary is the same for all indices.
    """
    length = grid.shape[axis]
    # of a batch of one chunk they are computed once, and kept with the group
    group = whole if len(range(length)[indices]) == length else whole.cut(axis, indices)
    stiffness, deformed = group.spring_numbers
    local = [deformed.get((spring, dof), 0.0) for spring in range(len(stiffness)) for dof in range(12)]
    if all(axes is None for axes in group.axes):
        chord = np.broadcast_to(_X, (len(group.pieces), *(1,) * (group.chord.ndim - 2), 3))
        return [stiffness, local, group.element.axis_numbers(chord if whole.along_x else group.chord)]
    start, end = group.end_axes
    turns = [start] if end is start else [start, end]
    return [stiffness, local, *([turn[..., i, k] for i in range(3) for k in range(3)] for turn in turns)]


def _all_aslant(chord: Array) -> bool:
    """Whether no chord (..., 3) is along z."""
    x, y = chord[..., 0], chord[..., 1]
    return np.count_nonzero(x) == x.size or bool(np.all((x != 0.0) | (y != 0.0)))
