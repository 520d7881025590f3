"""Condition numbers of the stiffness matrix of a loaded linkage: of the whole, of its planar part, and scaled."""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import TYPE_CHECKING

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError

if TYPE_CHECKING:
    from ....framework.frame import Frame
    from ....framework.solution import Solution


class ConditionNumbers(ABC):
    """Base class of results that have the condition numbers of a loaded linkage."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""

    @property
    @abstractmethod
    def plane(self) -> tuple[int, int] | None:
        """The two global axes of the plane in which the linkage moves; None if it does not move in such a plane."""

    @property
    @abstractmethod
    def _loaded_frame(self) -> Frame:
        """The loaded frame."""

    @property
    @abstractmethod
    def _without_clearance(self) -> Solution:
        """Solution of the loaded frame, without clearance."""

    def condition_number(self) -> Array:
        """2-norm condition number of the stiffness matrix as the accuracy paper assembles it.

        Every node has six displacements, and joints are springs between twin nodes.

        Returns
        -------
        ndarray
            Ratio of the largest to the smallest singular value, (...).

        Raises
        ------
        FrameError
            If a joint is ideal in some directions only, or a link is rigid: then there is no such matrix.
        """
        return np.broadcast_to(self._without_clearance.condition_number(), self.shape)

    def planar_condition_number(self) -> Array:
        """2-norm condition number of the planar part of the stiffness matrix.

        Each node has the displacements along the axes of the plane in which the linkage moves, and the rotation about
        its normal: ``ux uy rz`` for a linkage in the plane of x and y.

        Returns
        -------
        ndarray
            Ratio of the largest to the smallest singular value, (...).

        Raises
        ------
        FrameError
            As for `condition_number`, or if the linkage does not move in a plane of two global axes.
        """
        if self.plane is None:
            raise FrameError("planar_condition_number: the linkage is in no plane of two axes: use condition_number()")
        across = "xyz"[3 - sum(self.plane)]
        frame = self._loaded_frame.copy()
        for node in frame.nodes:
            frame.fix(node, f"u{across}", *(f"r{'xyz'[axis]}" for axis in self.plane))
        return np.broadcast_to(frame.solve(clearance=False).condition_number(), self.shape)

    def scaled_condition_number(self) -> Array:
        """Condition number in joint-relative coordinates, scaled node by node, which governs the solution's accuracy.

        Returns
        -------
        ndarray
            Ratio of the largest to the smallest singular value, (...); see `Solution.scaled_condition_number`.
        """
        return np.broadcast_to(self._without_clearance.scaled_condition_number(), self.shape)
