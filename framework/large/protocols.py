"""What a search for equilibria has found."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol, Self

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .joint_law import ContactMultipliers

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]


class Place(Protocol):
    """Where a frame is at m entries, in space or in a plane; the batch comes last."""

    displacements: Array
    rotations: Array
    own: Array
    contact_multipliers: ContactMultipliers

    def taken(self, kept: Any) -> Self:
        """Some of the entries."""
        ...

    def put(self, where: Any, other: Any) -> None:
        """Replace some of the entries."""
        ...


class Linearisation(Protocol):
    """What one iteration knows, see `state.SpaceLinear`."""

    @property
    def forces(self) -> Array:
        """Unbalanced forces (size, m)."""
        ...

    @property
    def values(self) -> Array:
        """Tangent on its pattern (entries, m)."""
        ...

    @property
    def energy(self) -> Array:
        """Twice the strain energy (m,)."""
        ...


class Balance(Protocol):
    """Equations of some entries, see `equations.Equations`; its states and `Linearisation` are of one kind."""

    @property
    def lengths(self) -> Array:
        """Length that displacements are compared with (m,) or (1,)."""
        ...

    @property
    def scale(self) -> Array:
        """Makes steps of coordinates radians or lengths of the frame (size, m or 1); zero for multipliers."""
        ...

    @property
    def prescribed_values(self) -> Array:
        """Values of the prescribed coordinates (prescribed, m)."""
        ...

    def linearised(self, state: Any, stresses: list[Array] | None = None) -> Any:
        """Forces and tangent."""
        ...

    def prescribed_residual(self, state: Any) -> Array:
        """Difference of the prescribed coordinates from their values."""
        ...

    def advanced(self, state: Any, step: Array) -> Any:
        """The state after a step."""
        ...

    def stresses(self, state: Any) -> list[Array]:
        """By stack of members, the true forces on their deformations."""
        ...

    def step_stresses(self, at: Any, step: Array) -> list[Array]:
        """Stresses predicted for a step."""
        ...

    def energy(self, state: Any) -> Array:
        """Energy less the work of forces."""
        ...

    def moment_work(self, old: Any, new: Any) -> Array:
        """Work of moments."""
        ...


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

    state: Place
    converged: Mask
    stable: Mask
    neutral: Mask
    left: Mask
    iterations: Index

    @classmethod
    def nothing(cls, state: Place, *, copied: bool = True) -> FoundEquilibria:
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
        if which is not None:
            kept = np.flatnonzero(which)
            where = where[kept]
            other = FoundEquilibria(
                other.state.taken(kept),
                other.converged[kept],
                other.stable[kept],
                other.neutral[kept],
                other.left[kept],
                other.iterations[kept],
            )
        self.state.put(where, other.state)
        self.converged[where], self.stable[where] = other.converged, other.stable
        self.neutral[where] = other.neutral
        self.left[where] |= other.left
