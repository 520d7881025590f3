"""Where a frame is at some entries of a batch, in space or in a plane, and what a search for equilibria found there.

The entries come last on the axes of all arrays.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import prod
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from .. import rotation
from ..batch import Array
from .model import Model

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]


@dataclass
class StateOfEntries:
    """Where a frame is at m entries, the last axis of each array.

    Attributes
    ----------
    displacements, rotations
        Of the nodes.
    own
        Coordinates of the links of the tree.
    contact_force
        Guesses of the forces in rigid contacts (6, contacts, m).
    contact_stiffness
        Stiffnesses by which these are corrected (contacts, m); they bear on the way only.
    """

    displacements: Array
    rotations: Array
    own: Array
    contact_force: Array
    contact_stiffness: Array

    @property
    def arrays(self) -> tuple[Array, ...]:
        """All of these, in order."""
        return self.displacements, self.rotations, self.own, self.contact_force, self.contact_stiffness

    def taken(self, kept: Mask | Index) -> Self:
        """Some of the entries."""
        index = np.flatnonzero(kept) if kept.dtype == np.bool_ else kept
        return type(self)(*(np.take(each, index, axis=-1) for each in self.arrays))

    def put(self, where: Mask | Index, other: StateOfEntries) -> None:
        """Replace some of the entries."""
        for mine, others in zip(self.arrays, other.arrays, strict=True):
            mine[..., where] = others

    def flat(self) -> NDArray[Any]:
        """All numbers, one after the other (n, m)."""
        return np.concatenate([each.reshape(prod(each.shape[:-1]), each.shape[-1]) for each in self.arrays])

    def like(self, flat: NDArray[Any]) -> Self:
        """A state of the same kind with these numbers (n, m), as `flat` has them."""
        sizes = [prod(each.shape[:-1]) for each in self.arrays]
        parts = np.split(flat, np.cumsum(sizes[:-1]))
        shapes = [(*each.shape[:-1], flat.shape[-1]) for each in self.arrays]
        return type(self)(*(part.reshape(shape) for part, shape in zip(parts, shapes, strict=True)))

    def contact(self, place: int | None) -> tuple[Array, Array] | None:
        """Force (6, m) and stiffness (m,) of a rigid contact; None for none."""
        return None if place is None else (self.contact_force[:, place], self.contact_stiffness[place])


@dataclass
class PlanarState(StateOfEntries):
    """In a plane: displacements (2, nodes, m), angles (nodes, m), translations and angles of links (3, links, m)."""

    @classmethod
    def start(cls, model: Model, count: int) -> PlanarState:
        """At rest."""
        displacements, angles = np.zeros((2, model.count, count)), np.zeros((model.count, count))
        return cls(displacements, angles, np.zeros((3, len(model.joints), count)), *_unpressed(model, count))


@dataclass
class DisplacedState(StateOfEntries):
    """In space: displacements (3, nodes, m), quaternions (4, nodes, m), coordinates of the tree's links and then forces
    in the ideal components of loops (6, links + loops, m)."""

    @classmethod
    def start(cls, model: Model, count: int) -> DisplacedState:
        """At rest."""
        rotations = np.zeros((4, model.count, count))
        rotations[0] = 1.0
        own = np.zeros((6, len(model.edges), count))
        return cls(np.zeros((3, model.count, count)), rotations, own, *_unpressed(model, count))

    def moved(self, node: int) -> Array:
        """Displacement and rotation vector of a node (6, m)."""
        return np.concatenate([self.displacements[:, node], rotation.logarithm(self.rotations[:, node])])


def _unpressed(model: Model, count: int) -> tuple[Array, Array]:
    """No forces in rigid contacts, and stiffnesses by which they would be corrected."""
    return np.zeros((6, len(model.contacts), count)), np.ones((len(model.contacts), count))


@dataclass
class FoundEquilibria:
    """Results for m entries.

    Attributes
    ----------
    state
        Where they are.
    converged, stable
        Whether that is an equilibrium, and one at which the energy has a minimum.
    neutral
        Whether no stiffness beyond rounding resists some motion there.
    left
        Whether a saddle of the energy was left on the way.
    iterations
        Newton steps.
    """

    state: StateOfEntries
    converged: Mask
    stable: Mask
    neutral: Mask
    left: Mask
    iterations: Index

    @classmethod
    def nothing(cls, state: StateOfEntries, *, copied: bool = True) -> FoundEquilibria:
        """Before the first iteration; what is found is put into the state, or a copy of it."""
        count = state.displacements.shape[-1]
        no = np.zeros(count, dtype=bool)
        place = state.taken(np.arange(count)) if copied else state
        return cls(place, no.copy(), no.copy(), no.copy(), no.copy(), np.zeros(count, dtype=np.int64))

    @property
    def good(self) -> Mask:
        """Entries that need no more."""
        return self.converged & self.stable

    def improve(self, where: Index, other: FoundEquilibria) -> None:
        """As `take`, of what is stable, or an equilibrium where there was none."""
        self.take(where, other, other.good | (other.converged & ~self.converged[where]))

    def take(self, where: Index, other: FoundEquilibria, which: Mask | None = None) -> None:
        """Replace some of the entries by what was found later, those of it that `which` tells; iterations add up."""
        self.iterations[where] += other.iterations
        if which is None:
            kept, state = np.arange(len(where)), other.state
        else:
            kept = np.flatnonzero(which)
            where, state = where[kept], other.state.taken(kept)
        self.state.put(where, state)
        self.converged[where], self.stable[where] = other.converged[kept], other.stable[kept]
        self.neutral[where] = other.neutral[kept]
        self.left[where] |= other.left[kept]
