"""Size of each member of a linkage's batch."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from .dimensions import diagonals


def extent(linkage: LinkageDescription) -> Array:
    """Diagonal of the bounding box of each member of the linkage's batch, (...); 1 if all its points coincide."""
    return np.broadcast_to(diagonals([*linkage.points.values()]), linkage.shape)
