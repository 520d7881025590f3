"""Members of a short batch whose springs and axes are computed by its program, from their numbers and chords.

Other members give their springs and axes to the program as numbers, see `linkframe.framework.batched.batch_numbers`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from ..batch import Array, all_of, any_of
from ..orientation import level_axis_numbers
from ..structure.group import EXTENDED
from ..structure.member_numbers import ALONG_X
from ..structure.topology import Topology
from .number_blocks import Blocks

# A number that is not there.
ABSENT = -1


class MemberFormulas(NamedTuple):
    """The numbers of a member, by index, and its formulas.

    Attributes
    ----------
    inputs
        Those of its `linkframe.framework.protocol.SpringFormulas`.
    chord
        The first of the three components of its chord.
    horizontal, length
        Lengths as of `linkframe.framework.orientation.level_axis_numbers`; `ABSENT` where the chord is along x, and for
        the second where both are the same.
    stiffness, deformations
        The functions of the formulas.
    """

    inputs: tuple[int, ...]
    chord: int
    horizontal: int
    length: int
    stiffness: Callable[[Sequence[Any], Any], list[Any]]
    deformations: Callable[[Any], Mapping[tuple[int, int], Any]]

    def axes(self, chord: Sequence[Any], number: Callable[[int], Any]) -> list[Any]:
        """Components of the local axes, row by row, from those of the chord; `number` is the function of an index."""
        if self.horizontal == ABSENT:
            return ALONG_X
        horizontal = number(self.horizontal)
        length = horizontal if self.length == ABSENT else number(self.length)
        x, y, z = chord
        return level_axis_numbers(x, y, z, horizontal, length)


def member_formulas(blocks: Blocks, topology: Topology) -> tuple[MemberFormulas, ...] | None:
    """The numbers of all members, added to blocks, with their formulas; None unless all members have some.

    None as well where chords vary over different axes, nodes of a member are on different bodies, a member is along
    global z at some entry, or there are so many members that not all are computed in extended precision.
    """
    members, bodies = topology.frame.members.values(), topology.bodies
    whole = len(members) == len(topology.ends) and len(members) * blocks.grid.sizes[-1] <= EXTENDED
    if not whole or any(bodies[a] != bodies[b] for a, b in topology.ends.tolist()):
        return None
    leaders, which = topology.distinct_elements
    elements = [member.element for member in members]
    formulas = [formula for k in leaders if (formula := elements[k].formulas) is not None]
    if len(formulas) < len(leaders):
        return None
    chords = _stacked(list(topology.chords))
    if chords is None:
        return None
    x, y, z = chords[:, 0], chords[:, 1], chords[:, 2]
    count, level, horizontal, length = len(chords), not any_of(z), ABSENT, ABSENT
    if not (level and not any_of(y) and all_of(x > 0.0)):
        across = np.hypot(x, y)
        if not all_of(across):
            return None
        horizontal = blocks.put(across)
        length = ABSENT if level else blocks.put(np.hypot(across, z))
    start = blocks.put(chords.reshape(3 * count, *chords.shape[2:]))
    inputs = _inputs(blocks, [formula.inputs for formula in formulas])
    # places of the members among the lengths, if these are there
    across_by, length_by = int(horizontal != ABSENT), int(length != ABSENT)
    found = []
    for k, n in enumerate(which.tolist()):
        places = start + 3 * k, horizontal + k * across_by, length + k * length_by
        found.append(MemberFormulas(inputs[n], *places, formulas[n].stiffness, formulas[n].deformations))
    return tuple(found)


def _stacked(chords: list[Array]) -> Array | None:
    """Chords (..., 3) as (members, 3, ...); None if they vary over different axes."""
    if len({chord.shape for chord in chords}) != 1:
        return None
    return np.array([chord.T if chord.ndim < 3 else np.moveaxis(chord, -1, 0) for chord in chords])


def _inputs(blocks: Blocks, given: list[tuple[Array | float, ...]]) -> list[tuple[int, ...]]:
    """Indices of the numbers of some elements, added to blocks: those that do not vary together, and so the others."""
    each = [number for numbers in given for number in numbers]
    fixed = [number for number in each if isinstance(number, float)]
    varying = [number for number in each if not isinstance(number, float)]
    first = iter(range(blocks.put(np.array(fixed)), blocks.count)) if fixed else iter(())
    if len({number.shape for number in varying}) == 1:
        second = iter(range(blocks.put(np.array(varying)), blocks.count))
    else:
        second = iter([blocks.one(number) for number in varying])
    return [tuple([next(first if isinstance(x, float) else second) for x in numbers]) for numbers in given]
