"""Frames that lie and are loaded in a coordinate plane: what leaves the plane stays zero and is not solved for."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..structure.parts import is_zero
from ..structure.topology import Topology
from ..structure.tree import Edge
from .joints import offsets
from .loading import Loads

# Displacement components in the planes across z, y and x: two translations and the rotation about the normal.
_PLANES = ((0, 1, 5), (0, 2, 4), (1, 2, 3))
WHOLE = (0, 1, 2, 3, 4, 5)


def plane(topology: Topology, edges: list[Edge], loads: Loads) -> tuple[int, ...]:
    """Components in which nodes move: three where frame, loads and given motions keep to a plane, else all six.

    A screw pushes across the plane in which it turns, or turns across that in which it is pushed.
    """
    if not all(is_zero(edge.pitch) for edge in edges):
        return WHOLE
    axes, vectors = _axes(topology, edges), _vectors(topology, edges, loads)
    chords = [group.level[..., 0, :] for group in topology.groups]
    for kept in _PLANES:
        normal = kept[2] - 3
        left = [k for k in WHOLE if k not in kept]
        lies = not any(chord[..., normal].any() for chord in chords)
        if lies and all(_keeps(rows, normal) for rows in axes) and not any(v[..., left].any() for v in vectors):
            return kept
    return WHOLE


def _keeps(rows: Array, normal: int) -> bool:
    """Whether each of the axes (..., 3, 3), the rows, lies either along the normal or across it."""
    across = np.delete(rows, normal, axis=-1)
    return not np.any((rows[..., normal] != 0.0) & (across != 0.0).any(axis=-1))


def _axes(topology: Topology, edges: list[Edge]) -> list[Array]:
    """Axes of members and joints as rows."""
    out = [group.level for group in topology.groups]
    return out + [np.swapaxes(edge.axes, -1, -2) for edge in edges if edge.axes is not None]


def _vectors(topology: Topology, edges: list[Edge], loads: Loads) -> list[Array]:
    """Loads, given displacements and arms, (..., 6) in global axes."""
    out = [loads.reach]
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
    return out + [np.concatenate([hung.arm, np.zeros_like(hung.arm)], axis=-1) for hung in loads.hung]
