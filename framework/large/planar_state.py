"""Where a frame in a plane is, and what one iteration knows of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .joint_law import ContactMultipliers


@dataclass
class PlanarState:
    """Displacements (2, nodes, m), angles (nodes, m), own displacements and angles of links (3, links, m), contacts."""

    displacements: Array
    rotations: Array
    own: Array
    contact_multipliers: ContactMultipliers

    def taken(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> PlanarState:
        """Some of the entries."""
        return PlanarState(
            self.displacements[..., kept],
            self.rotations[..., kept],
            self.own[..., kept],
            self.contact_multipliers.taken(kept),
        )

    def put(self, where: NDArray[np.bool_] | NDArray[np.int64], other: PlanarState) -> None:
        """Replace some of the entries."""
        self.displacements[..., where], self.rotations[..., where], self.own[..., where] = (
            other.displacements,
            other.rotations,
            other.own,
        )
        self.contact_multipliers.put(where, other.contact_multipliers)


@dataclass(frozen=True)
class PlanarLinearisation:
    """What one iteration knows; see `equations.Linear`."""

    forces: Array
    values: Array
    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]
    energy: Array
