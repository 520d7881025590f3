"""Which entries of a batch lie and are loaded in a coordinate plane: motion out of it is zero and is not solved for."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, block_diagonal, rotated
from ..entries import flattened
from ..joint_protocol import JointElement
from ..protocol import is_proven
from ..structure.edge import Edge
from ..structure.member_loads import strain_forces
from ..structure.parts import is_zero
from ..structure.topology import Group, Topology
from .joints import offsets
from .numbers import Loads

Mask = NDArray[np.bool_]
WHOLE = (0, 1, 2, 3, 4, 5)
# Displacement components in the planes across z, y and x, two translations and the rotation about the normal; in space.
_PLANES = ((0, 1, 5), (0, 2, 4), (1, 2, 3), WHOLE)
# Coupling of two components, by the root of their stiffnesses, that is rounding; and displacements tried on a law.
_COUPLED = 1e-12
_TRIED = (1e-6, 1e-3, 0.1)


@dataclass(frozen=True)
class EntryPlanes:
    """In which plane each entry stays, by its own geometry and loads, whatever the rest of the batch is.

    Attributes
    ----------
    numbers
        Place in `_PLANES` of the components in which nodes move, of size one where nothing varies (...).
    absent
        Entries that were left out, which are in any plane; None for none.
    """

    numbers: NDArray[np.int64]
    absent: Mask | None

    @classmethod
    def of(cls, topology: Topology, edges: list[Edge], loads: Loads, *, in_plane: bool = True) -> EntryPlanes:
        """The first of the planes to which frame, loads and given motions keep, else space; space where not `in_plane`.

        A screw pushes across the plane in which it turns, or turns across that in which it is pushed.
        """
        numbers = np.full((1,) * len(topology.frame.shape), len(_PLANES) - 1)
        if not in_plane:
            return cls(numbers, topology.frame.absent)
        axes, vectors = _axes(topology, edges), _vectors(topology, edges, loads)
        unpitched: Mask = np.ones(numbers.shape, dtype=bool)
        for edge in edges:
            if edge.name is not None and not is_zero(edge.pitch):
                unpitched = unpitched & (topology.frame.joints[edge.name].element.pitch == 0.0)
        for number in reversed(range(len(_PLANES) - 1)):
            kept = unpitched
            for lies in _lie(topology, axes, vectors, _PLANES[number]):
                kept = kept & lies
                if not kept.any():
                    break
            numbers = np.where(kept, number, numbers)
        return cls(numbers, topology.frame.absent)

    def split(self) -> list[Mask]:
        """Entries of each plane in which there are some, (...)."""
        there = np.ones((), dtype=bool) if self.absent is None else ~self.absent
        parts = [there & (self.numbers == number) for number in range(len(_PLANES))]
        return [part for part in parts if part.any()]

    @property
    def components(self) -> tuple[int, ...]:
        """Components in which nodes move at all entries: of their plane, or all six where they have not the same."""
        parts = self.split()
        if len(parts) != 1:
            return WHOLE
        return _PLANES[int(np.broadcast_to(self.numbers, parts[0].shape)[parts[0]][0])]


def _lie(
    topology: Topology, axes: list[tuple[Array, int]], vectors: list[tuple[Array, int]], plane: tuple[int, ...]
) -> Iterator[Mask]:
    """What keeps to a plane of these components, one thing after another, (...)."""
    normal = plane[2] - 3
    left = [k for k in WHOLE if k not in plane]
    for group in topology.groups:
        yield _all(np.asarray(group.local_axes[..., 0, normal] == 0.0), 1)
    for rows, leading in axes:
        yield _all(_keeps(rows, normal), leading)
    for each, leading in vectors:
        yield _all(np.asarray(~each[..., left].any(axis=-1)), leading)
    for group in topology.groups:
        if not is_proven(group.element):
            yield _all(_uncoupled(group, plane), 1)
    for joint in topology.frame.joints.values():
        if joint.element.has_law:
            yield _law_keeps(joint.element, normal)


def _all(lies: Mask, leading: int) -> Mask:
    """Whether that is so for all pieces, (...)."""
    return np.asarray(lies.all(axis=tuple(range(leading))))


def _keeps(rows: Array, normal: int) -> Mask:
    """Whether each of the axes (..., 3, 3), the rows, lies either along the normal or across it, (...)."""
    across = np.delete(rows, normal, axis=-1)
    return np.asarray(~np.any((rows[..., normal] != 0.0) & (across != 0.0).any(axis=-1), axis=-1))


def _uncoupled(group: Group, kept: tuple[int, ...]) -> Mask:
    """Whether the stiffness of members does not couple what moves in the plane with what does not, (n, ...)."""
    inside = [6 * end + k for end in (0, 1) for k in kept]
    outside = [k for k in range(12) if k not in inside]
    turn = block_diagonal([group.local_axes] * 4)
    out: Mask = np.ones((), dtype=bool)
    for local in (
        group.element.stiffness_matrix(group.length),
        group.element.geometric_matrix(group.length, np.ones(())),
    ):
        matrix = np.swapaxes(turn, -1, -2) @ local @ turn
        size = np.sqrt(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)))
        coupled = np.abs(matrix[..., inside, :][..., outside])
        out = out & ~np.any(coupled > _COUPLED * size[..., inside, None] * size[..., None, outside], axis=(-1, -2))
    return out


def _law_keeps(element: JointElement, normal: int) -> Mask:
    """Whether a joint of a law of its own does not push across the plane where it is displaced in it, (...)."""
    shape = element.shape
    axes = np.eye(3) if element.axes is None else element.axes
    across = flattened(axes[..., normal, :] == 0.0, shape, 1)
    kept = np.concatenate([across, ~across], axis=-1)
    tried = kept[:, None] * np.array(_TRIED)[:, None] * (1.0, 0.7, -0.4, 1.0, 0.7, -0.4)

    def pick(array: Array, trailing: int) -> Array:
        return np.repeat(flattened(array, shape, trailing), len(_TRIED), axis=0)

    _, force, tangent = element.resistance(tried.reshape(-1, 6), pick)
    left = ~np.repeat(kept, len(_TRIED), axis=0)
    pushed = (left & (force != 0.0)).any(axis=-1) | (left[:, None] & ~left[..., None] & (tangent != 0.0)).any((-1, -2))
    return np.asarray(~pushed.reshape(*shape, len(_TRIED)).any(axis=-1))


def _axes(topology: Topology, edges: list[Edge]) -> list[tuple[Array, int]]:
    """Axes of members and joints as rows, with the number of axes in front of the batch's."""
    out = [(group.local_axes, 1) for group in topology.groups]
    return out + [(np.swapaxes(edge.axes, -1, -2), 0) for edge in edges if edge.axes is not None]


def _vectors(topology: Topology, edges: list[Edge], loads: Loads) -> list[tuple[Array, int]]:
    """Loads, what strains members, given displacements and arms, (..., 6) in global axes, likewise."""
    out = [(loads.largest, 0)]
    for group in topology.groups:
        if group.strained:
            both = strain_forces(group, np.arange(len(group.pieces)))
            ends = rotated(np.swapaxes(group.local_axes, -1, -2), both)
            out += [(ends[..., :6], 1), (ends[..., 6:], 1)]
    for edge in edges:
        given = offsets(topology.frame, edge)
        six = np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in WHOLE)), axis=-1)
        if edge.axes is not None:
            parts = [(edge.axes @ part[..., None])[..., 0] for part in (six[..., :3], six[..., 3:])]
            six = np.concatenate(parts, axis=-1)
        out.append((six, 0))
        if edge.kind == "rigid":
            arm = topology.position(edge.second) - topology.position(edge.first)
            out.append((np.concatenate([arm, np.zeros_like(arm)], axis=-1), 0))
    arms = [each.arm for each in loads.offset_forces]
    return out + [(np.concatenate([arm, np.zeros_like(arm)], axis=-1), 0) for arm in arms]
