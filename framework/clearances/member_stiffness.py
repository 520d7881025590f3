"""The stiffness of the stiffest member, with which the stiffness against offsets is compared to see whether it is zero.

It is that of the springs of members in their own axes, so that it does not depend on the axes of the frame.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import reduce
from typing import Any

import numpy as np

from ..batch import Array, aligned
from ..batched.plan import Plan
from ..program.recording import Recording
from ..program.sweep import Sweep
from ..structure.group import Group
from ..structure.parts import Grid, Value, is_zero


def member_stiffness(plan: Plan) -> tuple[Array, Array]:
    """Largest stiffness of a spring of any member against the translation and against the rotation of one of its ends.

    Parameters
    ----------
    plan
        The plan of the frame.

    Returns
    -------
    translation, rotation
        Force per length and moment per radian, each of the batch shape over which it varies; zero without members.
    """
    grid, varying, recording = plan.grid, plan.varying, Recording()
    by_chunks = {numbers.group for numbers, _ in varying.groups}
    with np.errstate(all="ignore"):
        pairs = [_of_group(group, grid) for group in plan.topology.groups if group not in by_chunks]
        if not by_chunks:
            one, other = (_most([pair[kind] for pair in pairs]) for kind in (0, 1))
            return np.asarray(one, dtype=np.float64), np.asarray(other, dtype=np.float64)
        for stiffness, deformations, *_ in varying.springs([recording.later(mask) for mask in varying.masks]):
            used = {divmod(k, 12): value for k, value in enumerate(deformations) if not is_zero(value)}
            pairs.append(_largest(stiffness, used))
        asked = [_most([recording.take(pair[kind]) for pair in pairs]) for kind in (0, 1)]
        translation, rotation = Sweep(grid, recording, lambda rows: [], varying.numbers).run([], asked)[1]
    return translation, rotation


def _of_group(group: Group, grid: Grid) -> tuple[Value, Value]:
    """The same of the members of a group."""
    ndim = len(grid.shape)
    of_pieces = [np.asarray(each) for each in _largest(*group.spring_numbers)]
    one, other = (each.max(axis=0) if each.ndim > ndim else each for each in of_pieces)
    return grid.value(aligned(one, ndim)), grid.value(aligned(other, ndim))


def _largest(stiffness: Sequence[Any], deformations: Mapping[tuple[int, int], Any]) -> tuple[Any, Any]:
    """Largest stiffness against translation and against rotation of an end, from springs and their deformations."""
    kinds: tuple[list[Any], list[Any]] = [], []
    for (spring, dof), deformed in deformations.items():
        kinds[dof % 6 // 3].append(stiffness[spring] * (deformed * deformed))
    return _most(kinds[0]), _most(kinds[1])


def _most(values: Sequence[Any]) -> Any:
    return reduce(np.maximum, values) if values else 0.0
