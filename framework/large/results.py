"""What contacts, and words about them, ask of a solution at large displacement."""

from __future__ import annotations

from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ..batch import Array, Shape
from ..description import Description
from .equations import EquilibriumEquations
from .model import Model
from .state import DisplacedState, SpatialLinearisation
from .trust import Trust


class LargeResults(Protocol):
    """A solution at large displacement, as `linkframe.framework.LargeSolution` is one."""

    model: Model

    @property
    def frame(self) -> Description:
        """The description as it was when solved."""
        ...

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        ...

    @property
    def converged(self) -> NDArray[np.bool_]:
        """Where an equilibrium was found, (...)."""
        ...

    @property
    def residual(self) -> Array:
        """Largest unbalanced force over the largest force, (...)."""
        ...

    def joint_global(self, joint: str, vectors: Array) -> Array:
        """Vectors in a joint's axes as global ones."""
        ...

    @property
    def displaced(self) -> DisplacedState:
        """Where everything is."""
        ...

    @property
    def equations(self) -> EquilibriumEquations:
        """Equilibrium of all entries under the whole load."""
        ...

    @property
    def linear(self) -> SpatialLinearisation:
        """Forces and stiffness there."""
        ...

    @property
    def trust(self) -> Trust:
        """What rounding leaves of them."""
        ...
