"""Load cases that are combinations of a few: one solution for a unit of each varying load, and one for all constants.

A large batch of loads often consists of one or a few loads of many sizes. As the solution is linear in each, it is the
solution for a unit load times the size.
"""

from __future__ import annotations

import copy
from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from ..batch import Array, Shape, aligned
from ..description import Description
from ..stacking import changed
from ..structure.parts import Grid, RightHandSideParameters, Value, mask_of

# Shape and bytes of an array.
_Content = tuple[Shape, bytes]


class Loaded(Protocol):
    """The part of a plan of constant stiffness that determines how its loads vary."""

    frame: Description

    @property
    def rhs_parameters(self) -> RightHandSideParameters:
        """Given numbers that loads are combinations of."""
        ...

    @property
    def grid(self) -> Grid:
        """The batch."""
        ...

    @property
    def imposed(self) -> Sequence[Value]:
        """The number one, and prescribed displacements and offsets that vary."""
        ...


def varying(plan: Loaded) -> list[Value]:
    """Numbers in which the solution is linear, the first being one; empty if member loads or geometry vary, too."""
    given = _given(plan)
    return [] if given is None else [*plan.imposed, *given[0]]


def _given(plan: Loaded) -> tuple[list[Value], list[int | None]] | None:
    """Varying loads at nodes, each different array once; and for each load in turn its index among them, or None.

    A constant load has None. The result is None if member loads, gravity or geometry vary, too.
    """
    frame, grid = plan.frame, plan.grid
    along = [array for loads in frame.member_loads.values() for load in loads for array in load.forces]
    along += [] if frame.weight is None else [frame.weight]
    if plan.rhs_parameters.geometry or any(not set(array.shape[:-1]) <= {1} for array in along):
        return None
    numbers: list[Value] = []
    places: dict[_Content, int] = {}
    which: list[int | None] = []
    for value in [grid.value(array) for loads in frame.loads.values() for _, array in loads]:
        which.append(places.setdefault(_content(value), len(numbers)) if mask_of(value) else None)
        if which[-1] == len(numbers):
            numbers.append(value)
    return numbers, which


def _content(value: Value) -> _Content:
    array = np.asarray(value)
    return array.shape, array.tobytes()


def count(plan: Loaded) -> int:
    """Number of right-hand sides to solve for."""
    cases = plan.grid.sizes[-1]
    units = len(varying(plan)) if cases > 1 else 0
    return min(units, cases) if units else cases


def by_units(plan: Loaded) -> tuple[Description, Grid, RightHandSideParameters, list[Value]] | None:
    """Frame, batch and right-hand-side parameters for unit loads along the last batch axis, and the sizes of the loads.

    Each size broadcasts to the batch. None if there are not fewer units than load cases.
    """
    given = _given(plan) if plan.grid.sizes[-1] > 1 else None
    if given is None:
        return None
    numbers = [*plan.imposed, *given[0]]
    if not 0 < len(numbers) < plan.grid.sizes[-1]:
        return None
    own, unit = (1,) * (len(plan.grid.shape) - 1) + (len(numbers),), np.eye(len(numbers))
    grid = Grid(own)
    units: list[Value] = [row.reshape(own) for row in unit]
    each = [None if place is None else units[len(plan.imposed) + place] for place in given[1]]
    frame = _units(plan.frame, plan.grid, units[0], iter(each))
    return frame, grid, RightHandSideParameters(grid, 0, units[: len(plan.imposed)]), numbers


def _units(frame: Description, grid: Grid, first: Value, each: Iterator[Value | None]) -> Description:
    """A copy of the frame with each varying load replaced by its unit of `each`, and constants times `first`."""
    clone, ndim = copy.copy(frame), len(grid.shape)
    one = np.asarray(first)

    def load(value: Array) -> Array:
        unit = next(each)
        return one * value.reshape(-1)[0] if unit is None else np.asarray(unit)

    def alone(array: Array, trailing: int) -> Array:
        found: Array = one.reshape(*one.shape, *(1,) * trailing) * aligned(array, ndim, trailing)
        return found

    clone.shape = one.shape
    clone.loads = {node: [(k, load(value)) for k, value in loads] for node, loads in frame.loads.items()}
    clone.member_loads = {
        member: [changed(load, alone) for load in loads] for member, loads in frame.member_loads.items()
    }
    clone.weight = None if frame.weight is None else alone(frame.weight, 1)
    return clone
