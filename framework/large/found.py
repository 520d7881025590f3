"""What a search for equilibria has found."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from .equations import Equations, SpaceLinear, State
from .planar import FlatEquations, FlatLinear, FlatState

Mask = NDArray[np.bool_]
Index = NDArray[np.int64]
Place = State | FlatState
Linear = SpaceLinear | FlatLinear
Balance = Equations | FlatEquations


@dataclass
class Found:
    """Results for m entries.

    Attributes
    ----------
    state
        Where they are.
    converged, stable
        Whether that is an equilibrium, and one at which the energy has a minimum.
    left
        Whether a saddle of the energy was left on the way.
    iterations
        Newton steps.
    """

    state: Place
    converged: Mask
    stable: Mask
    left: Mask
    iterations: Index

    @classmethod
    def nothing(cls, state: Place) -> Found:
        """Before the first iteration."""
        count = state.moved.shape[-1]
        no = np.zeros(count, dtype=bool)
        return cls(state.taken(np.arange(count)), no.copy(), no.copy(), no.copy(), np.zeros(count, dtype=np.int64))

    @property
    def good(self) -> Mask:
        """Entries that need no more."""
        return self.converged & self.stable

    def take(self, where: Index, other: Found, which: Mask | None = None) -> None:
        """Replace some of the entries by what was found later, those of it that `which` tells; iterations add up."""
        self.iterations[where] += other.iterations
        if which is not None:
            kept = np.flatnonzero(which)
            where = where[kept]
            other = Found(
                other.state.taken(kept),
                other.converged[kept],
                other.stable[kept],
                other.left[kept],
                other.iterations[kept],
            )
        self.state.put(where, other.state)  # type: ignore[arg-type]
        self.converged[where], self.stable[where] = other.converged, other.stable
        self.left[where] |= other.left
