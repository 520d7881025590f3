"""Size of each member of a linkage's batch."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription


def extent(linkage: LinkageDescription) -> Array:
    """Diagonal of the bounding box of each member of the linkage's batch, (...); 1 if all its points coincide."""
    points = list(linkage.points.values())
    if not points:
        return np.ones(linkage.shape)
    corners = np.stack(np.broadcast_arrays(*points) if linkage.shape else points)
    size: Array = np.linalg.norm(np.ptp(corners, axis=0), axis=-1)
    return np.broadcast_to(np.where(size > 0.0, size, 1.0), linkage.shape)
