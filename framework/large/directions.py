"""Which way the axes of members and joints point at large displacement, where they turn with what they are on."""

from __future__ import annotations

from abc import abstractmethod

import numpy as np
from numpy.typing import ArrayLike

from .. import rotation
from ..batch import Array, aligned, rotated
from ..clearances.clearance import joints_with_clearance
from ..results.base import Results, checked_fractions
from .model import Model
from .state import DisplacedState
from .stations import Stations


class TurnedDirections(Results):
    """Results whose axes follow the displacement."""

    model: Model

    @property
    @abstractmethod
    def displaced(self) -> DisplacedState:
        """Where everything is."""

    @property
    @abstractmethod
    def _recovery(self) -> Stations: ...

    @property
    def journals(self) -> list[str]:
        """Names of the joints whose clearance is taken into account."""
        return joints_with_clearance(self.frame) if self.model.clearance else []

    def section_axes_at(self, fractions: ArrayLike) -> Array:
        """Find the axes in which `forces_at` tells forces: those that follow the chords of the pieces.

        Parameters
        ----------
        fractions
            Shares of the length from the start, 0 to 1, (k,).

        Returns
        -------
        ndarray
            The axes as rows in global components, (..., members, k, 3, 3).
        """
        at = checked_fractions(fractions)
        rows = self._each(lambda name, x: self._masked(self._recovery.axes_along(name, x)), at, 9)
        return rows.reshape(*rows.shape[:-1], 3, 3)

    def joint_global(self, joint: str, vectors: Array) -> Array:
        """Turn vectors in a joint's axes, which turn with its first node, into global ones.

        Parameters
        ----------
        joint
            Name of the joint.
        vectors
            Vectors (..., 3), or pairs of these (..., 6).

        Returns
        -------
        ndarray
            The same in global axes, (..., 3) or (..., 6).
        """
        frame, link = self.frame, self.frame.joints[joint]
        axes = link.element.axes
        start = vectors if axes is None else rotated(aligned(axes, len(frame.shape), 2), vectors)
        turn = rotation.matrix(self.displaced.rotations[:, self.model.topology.number[link.first]])
        return rotated(np.moveaxis(turn, -1, 0).reshape(*frame.shape, 3, 3), start)
