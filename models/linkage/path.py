"""The way that the drives take, from the drawing through all given values."""

from __future__ import annotations

import numpy as np

from ...framework.batch import Array
from .loops import Loops


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
        self.loops, self.values = loops, values
        steps = np.linalg.norm(np.diff(values, axis=0), axis=1) if len(values) > 1 else np.zeros(0)
        self.corners = np.concatenate([[0.0], np.cumsum(steps)])
        self._slopes = np.diff(values, axis=0) / np.where(steps > 0.0, steps, 1.0)[:, None]

    @property
    def length(self) -> float:
        """Length of the way."""
        return float(self.corners[-1])

    def _piece(self, s: float) -> int:
        return int(min(max(np.searchsorted(self.corners, s, side="right") - 1, 0), max(len(self.corners) - 2, 0)))

    def place(self, state: list[float], s: float) -> list[float]:
        """`state` with the driven entries as they are at `s`."""
        out = list(state)
        if len(self.corners) > 1:
            k = self._piece(s)
            values = self.values[k] + (s - self.corners[k]) * self._slopes[k]
            for place, value in zip(self.loops.driven_states, values.tolist(), strict=True):
                out[place] = value
            for place in self.loops.driven_balls:
                norm = sum(x * x for x in out[place : place + 4]) ** 0.5
                out[place : place + 4] = [x / norm for x in out[place : place + 4]]
        return out

    def rates(self, state: list[float], s: float) -> tuple[list[float], Array]:
        """Derivative by s of the driven states, and of the driven velocity coordinates, at `s`.

        At a corner, the mean of its two sides.
        """
        if len(self.corners) < 2:
            return [], np.zeros(len(self.loops.mechanism.driven))
        k = self._piece(s)
        slope = self._slopes[k]
        if s == self.corners[k] and k > 0:
            slope = 0.5 * (slope + self._slopes[k - 1])
        return slope.tolist(), np.array(self.loops.drive_velocities(state, slope.tolist()))
