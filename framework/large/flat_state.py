"""Where a frame in a plane is, and what one iteration knows of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .law import Grip


@dataclass
class FlatState:
    """Displacements (2, nodes, m), angles (nodes, m), own displacements and angles of links (3, links, m), contacts."""

    moved: Array
    turned: Array
    own: Array
    grip: Grip

    def taken(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> FlatState:
        """Some of the entries."""
        return FlatState(self.moved[..., kept], self.turned[..., kept], self.own[..., kept], self.grip.taken(kept))

    def put(self, where: NDArray[np.bool_] | NDArray[np.int64], other: FlatState) -> None:
        """Replace some of the entries."""
        self.moved[..., where], self.turned[..., where], self.own[..., where] = other.moved, other.turned, other.own
        self.grip.put(where, other.grip)


@dataclass(frozen=True)
class FlatLinear:
    """What one iteration knows; see `equations.Linear`."""

    forces: Array
    values: Array
    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]
    energy: Array
