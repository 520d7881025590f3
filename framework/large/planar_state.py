"""Where a frame in a plane is, and what one iteration knows of it."""

from __future__ import annotations

from dataclasses import dataclass

from ..batch import Array
from .state import StateOfEntries


@dataclass
class PlanarState(StateOfEntries):
    """Displacements (2, nodes, m), angles (nodes, m), own displacements and angles of links (3, links, m), contacts."""


@dataclass(frozen=True)
class PlanarLinearisation:
    """What one iteration knows; see `equations.Linear`."""

    forces: Array
    values: Array
    changes: list[tuple[Array, Array, Array]]
    stresses: list[Array]
    transfers: list[Array]
    energy: Array
