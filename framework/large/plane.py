"""Frames that lie and are loaded in a coordinate plane: what leaves the plane stays zero and is not solved for."""

from __future__ import annotations

import numpy as np

from ..batch import Array, block_diagonal, rotated
from ..joint_protocol import JointElement
from ..protocol import is_proven
from ..structure.edge import Edge
from ..structure.member_loads import strain_forces
from ..structure.parts import is_zero
from ..structure.topology import Group, Topology
from .joints import offsets
from .loading import Loads

# Displacement components in the planes across z, y and x: two translations and the rotation about the normal.
_PLANES = ((0, 1, 5), (0, 2, 4), (1, 2, 3))
WHOLE = (0, 1, 2, 3, 4, 5)
# Coupling of two components, by the root of their stiffnesses, that is rounding; and displacements tried on a law.
_COUPLED = 1e-12
_TRIED = (1e-6, 1e-3, 0.1)


def plane(topology: Topology, edges: list[Edge], loads: Loads) -> tuple[int, ...]:
    """Components in which nodes move: three where frame, loads and given motions keep to a plane, else all six.

    A screw pushes across the plane in which it turns, or turns across that in which it is pushed.
    """
    if not all(is_zero(edge.pitch) for edge in edges):
        return WHOLE
    axes, vectors = _axes(topology, edges), _vectors(topology, edges, loads)
    chords = [group.local_axes[..., 0, :] for group in topology.groups]
    for kept in _PLANES:
        normal = kept[2] - 3
        left = [k for k in WHOLE if k not in kept]
        lies = not any(chord[..., normal].any() for chord in chords)
        if not lies or not all(_keeps(rows, normal) for rows in axes) or any(v[..., left].any() for v in vectors):
            continue
        if all(_uncoupled(group, kept) for group in topology.groups) and _laws_keep(topology, normal):
            return kept
    return WHOLE


def _keeps(rows: Array, normal: int) -> bool:
    """Whether each of the axes (..., 3, 3), the rows, lies either along the normal or across it."""
    across = np.delete(rows, normal, axis=-1)
    return not np.any((rows[..., normal] != 0.0) & (across != 0.0).any(axis=-1))


def _uncoupled(group: Group, kept: tuple[int, ...]) -> bool:
    """Whether the stiffness of members does not couple what moves in the plane with what does not."""
    if is_proven(group.element):
        return True
    inside = [6 * end + k for end in (0, 1) for k in kept]
    outside = [k for k in range(12) if k not in inside]
    turn = block_diagonal([group.local_axes] * 4)
    for local in (
        group.element.stiffness_matrix(group.length),
        group.element.geometric_matrix(group.length, np.ones(())),
    ):
        matrix = np.swapaxes(turn, -1, -2) @ local @ turn
        size = np.sqrt(np.abs(np.diagonal(matrix, axis1=-2, axis2=-1)))
        coupled = np.abs(matrix[..., inside, :][..., outside])
        if np.any(coupled > _COUPLED * size[..., inside, None] * size[..., None, outside]):
            return False
    return True


def _laws_keep(topology: Topology, normal: int) -> bool:
    """Whether no joint of a law of its own pushes across the plane where it is displaced in it."""
    return all(_law_keeps(joint.element, normal) for joint in topology.frame.joints.values() if joint.element.has_law)


def _law_keeps(element: JointElement, normal: int) -> bool:
    axes = np.eye(3) if element.axes is None else element.axes
    across = (axes[..., normal, :] == 0.0).reshape(-1, 3).all(axis=0)
    kept = [k for k in range(6) if across[k % 3] == (k < 3)]
    left = [k for k in range(6) if k not in kept]
    tried = np.zeros((len(_TRIED), 6))
    tried[:, kept] = np.array(_TRIED)[:, None] * (1.0, 0.7, -0.4)

    def pick(array: Array, trailing: int) -> Array:
        return array.reshape(-1, *array.shape[array.ndim - trailing :])[:1]

    _, force, tangent = element.resistance(tried, pick)
    return not (np.any(force[:, left]) or np.any(tangent[:, kept][:, :, left]))


def _axes(topology: Topology, edges: list[Edge]) -> list[Array]:
    """Axes of members and joints as rows."""
    out = [group.local_axes for group in topology.groups]
    return out + [np.swapaxes(edge.axes, -1, -2) for edge in edges if edge.axes is not None]


def _vectors(topology: Topology, edges: list[Edge], loads: Loads) -> list[Array]:
    """Loads, what strains members, given displacements and arms, (..., 6) in global axes."""
    out = [loads.largest]
    for group in topology.groups:
        if group.strained:
            both = strain_forces(group, np.arange(len(group.pieces)))
            ends = rotated(np.swapaxes(group.local_axes, -1, -2), both)
            out += [ends[..., :6], ends[..., 6:]]
    for edge in edges:
        given = offsets(topology.frame, edge)
        six = np.stack(np.broadcast_arrays(*(given.get(k, np.zeros(())) for k in WHOLE)), axis=-1)
        if edge.axes is not None:
            parts = [(edge.axes @ part[..., None])[..., 0] for part in (six[..., :3], six[..., 3:])]
            six = np.concatenate(parts, axis=-1)
        out.append(six)
        if edge.kind == "rigid":
            arm = topology.position(edge.second) - topology.position(edge.first)
            out.append(np.concatenate([arm, np.zeros_like(arm)], axis=-1))
    return out + [np.concatenate([each.arm, np.zeros_like(each.arm)], axis=-1) for each in loads.offset_forces]
