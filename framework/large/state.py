"""Where a frame is in space, and what one iteration knows of it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .joint_law import ContactMultipliers
from .model import Model
from .response import Response


@dataclass
class StateOfEntries:
    """Where a frame is at m entries, the last axis of each array, and what its contacts carry."""

    displacements: Array
    rotations: Array
    own: Array
    contact_multipliers: ContactMultipliers

    def taken(self, kept: NDArray[np.bool_] | NDArray[np.int64]) -> Self:
        """Some of the entries."""
        index = np.flatnonzero(kept) if kept.dtype == np.bool_ else kept
        return type(self)(
            np.take(self.displacements, index, axis=-1),
            np.take(self.rotations, index, axis=-1),
            np.take(self.own, index, axis=-1),
            self.contact_multipliers.taken(kept),
        )

    def put(self, where: NDArray[np.bool_] | NDArray[np.int64], other: Self) -> None:
        """Replace some of the entries."""
        self.displacements[..., where] = other.displacements
        self.rotations[..., where] = other.rotations
        self.own[..., where] = other.own
        self.contact_multipliers.put(where, other.contact_multipliers)


@dataclass
class PlanarState(StateOfEntries):
    """Displacements (2, nodes, m), angles (nodes, m), own displacements and angles of links (3, links, m), contacts."""


@dataclass
class DisplacedState(StateOfEntries):
    """Where a frame is at m entries: displacements (3, nodes, m), quaternions (4, nodes, m), own displacements of the
    tree's links and then forces in the ideal components of loops (6, links + loops, m), rigid contacts."""

    @classmethod
    def start(cls, model: Model, count: int) -> DisplacedState:
        """At rest."""
        rotations = np.zeros((4, model.count, count))
        rotations[0] = 1.0
        own = np.zeros((6, len(model.joints) + len(model.loops), count))
        return cls(
            np.zeros((3, model.count, count)), rotations, own, ContactMultipliers.none(len(model.contacts), count)
        )


@dataclass(frozen=True)
class SpatialLinearisation:
    """What one iteration knows.

    Attributes
    ----------
    forces
        Unbalanced force on all coordinates, unknown and prescribed (size, m): inner less outer.
    values
        Tangent on the pattern of `Equations.pattern`.
    responses
        By stack, how the deformations follow the ends.
    stresses
        By stack, the true forces on the deformations.
    jacobians
        By node that is attached to others, its displacement and spin by the coordinates of its chain (6, chain, m).
    energy
        Twice the strain energy, in members and joints (m,).
    nodal
        Force that holds each node with all that is attached to it (6, nodes, m).
    own
        Force of members and loads on the links' own coordinates (6, links, m).
    """

    forces: Array
    values: Array
    responses: list[Response]
    stresses: list[Array]
    jacobians: dict[int, Array]
    energy: Array
    nodal: Array
    own: Array
