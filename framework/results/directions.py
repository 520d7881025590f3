"""Which way the axes of members and joints point in a linear solution, where all keep their directions."""

from __future__ import annotations

import numpy as np

from ..batch import Array
from ..structure.topology import Topology


def member_axes(topology: Topology) -> Array:
    """Axes of all members as rows in global components, (..., members, 1, 3, 3), with the batch axes that they need."""
    first = [topology.pieces_of[name][0] for name in topology.frame.members]
    member = np.full(sum(len(group.pieces) for group in topology.groups), -1)
    member[first] = np.arange(len(first))
    found = []
    for group in topology.groups:
        own = member[group.pieces]
        found.append((own[own >= 0], np.moveaxis(group.local_axes[own >= 0], 0, -3)))
    batch = np.broadcast_shapes(*(rows.shape[:-3] for _, rows in found))
    out = np.zeros((*batch, len(first), 1, 3, 3))
    for own, rows in found:
        out[..., own, 0, :, :] = rows
    return out
