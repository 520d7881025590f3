"""The way that the drives take, from the drawing through all given values."""

from __future__ import annotations

from bisect import bisect_right

import numpy as np

from ....framework.batch import Array
from ..kinematics.loops import Loops

# A corner is sharp where the cosine between its two sides is below this.
STRAIGHT = 0.98


class Path:
    """Drives along a way of straight pieces, over its length.

    Angles count in radians, displacements in units of the mechanism's size.

    Parameters
    ----------
    loops
        The mechanism's loops.
    values
        Driven states at the corners, (corners, driven states), the drawing first.
    """

    def __init__(self, loops: Loops, values: Array) -> None:
        self.loops = loops
        steps = np.linalg.norm(np.diff(values, axis=0), axis=1) if len(values) > 1 else np.zeros(0)
        self.corners: list[float] = np.concatenate([[0.0], np.cumsum(steps)]).tolist()
        self._slopes = (np.diff(values, axis=0) / np.where(steps > 0.0, steps, 1.0)[:, None]).tolist()
        self._values = values.tolist()

    @property
    def length(self) -> float:
        """Length of the way."""
        return self.corners[-1]

    def _piece(self, s: float) -> int:
        return min(max(bisect_right(self.corners, s) - 1, 0), len(self.corners) - 2)

    def place(self, state: list[float], s: float) -> list[float]:
        """`state` with the driven entries as they are at `s`, and balls of unit Euler parameters."""
        out = list(state)
        if len(self.corners) > 1:
            k = self._piece(s)
            h = s - self.corners[k]
            for place, value, slope in zip(self.loops.driven_states, self._values[k], self._slopes[k], strict=True):
                out[place] = value + h * slope
        return self.loops.unit(out)  # type: ignore[arg-type, return-value]

    def rates(self, state: list[float], s: float) -> tuple[list[float], list[float]]:
        """Derivative by s of the driven states, and of the driven velocity coordinates, at `s`.

        At a corner, the mean of its two sides.
        """
        if len(self.corners) < 2:
            return [], [0.0] * len(self.loops.mechanism.driven)
        k = self._piece(s)
        slope: list[float] = self._slopes[k]
        if s == self.corners[k] and k > 0:
            slope = [0.5 * (x + y) for x, y in zip(slope, self._slopes[k - 1], strict=True)]
        return slope, self.loops.drive_velocities(state, slope)

    def stop(self, s: float, target: float) -> float:
        """The target, or the first sharp corner before it."""
        k = bisect_right(self.corners, s)
        while k < len(self.corners) - 1 and self.corners[k] < target:
            if sum(x * y for x, y in zip(self._slopes[k - 1], self._slopes[k], strict=True)) < STRAIGHT:
                return self.corners[k]
            k += 1
        return target
