"""The path that the drives take to a pose: the straight line from their reference values."""

from __future__ import annotations

from collections.abc import Sequence

from ..kinematics.loops import Loops


class Ray:
    """Drives along a straight line, over its length.

    Angles count in radians, displacements in units of the mechanism's size.

    Parameters
    ----------
    loops
        The mechanism's loops.
    origin
        Driven states where it begins.
    direction
        Their change per unit of length.
    """

    def __init__(self, loops: Loops, origin: Sequence[float], direction: Sequence[float]) -> None:
        self.loops, self.origin, self.direction = loops, list(origin), list(direction)

    def place(self, state: list[float], s: float) -> list[float]:
        """`state` with the driven entries as they are at `s`, and balls of unit Euler parameters."""
        out = list(state)
        for place, value, slope in zip(self.loops.driven_states, self.origin, self.direction, strict=True):
            out[place] = value + s * slope
        return self.loops.unit(out)  # type: ignore[arg-type, return-value]
