"""Condition numbers of the stiffness of a loaded linkage: of the whole matrix, of the plane alone, and scaled."""

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
    """Condition numbers of a linkage under load, whatever its frame was made from."""

    @property
    @abstractmethod
    def shape(self) -> tuple[int, ...]:
        """Batch shape."""

    @property
    @abstractmethod
    def plane(self) -> tuple[int, int] | None:
        """The two global axes of the plane in which the linkage moves; None where it keeps to no such plane."""

    @property
    @abstractmethod
    def _loaded_frame(self) -> Frame:
        """The loaded frame."""

    @property
    @abstractmethod
    def _without_clearance(self) -> Solution:
        """It solved, its clearances closed."""

    def condition_number(self) -> Array:
        """2-norm condition number of the stiffness matrix as the accuracy paper assembles it.

        Every node has six displacements, and joints are springs between twin nodes.

        Returns
        -------
        ndarray
            Greatest over least singular value, (...).

        Raises
        ------
        FrameError
            If a joint is ideal in some directions only, or a link is rigid: then there is no such matrix.
        """
        return np.broadcast_to(self._without_clearance.condition_number(), self.shape)

    def planar_condition_number(self) -> Array:
        """2-norm condition number of the rows and columns in the plane alone, of every node.

        Those are the displacements along the axes of the plane in which the linkage moves, and the rotation about its
        normal: ``ux uy rz`` for a linkage in the plane of x and y.

        Returns
        -------
        ndarray
            Greatest over least singular value, (...).

        Raises
        ------
        FrameError
            As for `condition_number`, or if the linkage keeps to no plane of two global axes.
        """
        if self.plane is None:
            raise FrameError("planar_condition_number: the linkage is in no plane of two axes: use condition_number()")
        across = "xyz"[3 - sum(self.plane)]
        frame = self._loaded_frame.copy()
        for node in frame.nodes:
            frame.fix(node, f"u{across}", *(f"r{'xyz'[axis]}" for axis in self.plane))
        return np.broadcast_to(frame.solve(clearance=False).condition_number(), self.shape)

    def scaled_condition_number(self) -> Array:
        """Condition number in joint-relative coordinates, scaled node by node: what the solution feels in any axes.

        Returns
        -------
        ndarray
            Greatest over least singular value, (...); see `Solution.scaled_condition_number`.
        """
        return np.broadcast_to(self._without_clearance.scaled_condition_number(), self.shape)
