"""Links and velocity coordinates as the formulas of a linkage have them: recorded positions and directions."""

from __future__ import annotations

from dataclasses import dataclass

from .terms import Vector


@dataclass(frozen=True, eq=False)
class MovingLink:
    """A link: its reference point and its axes, in the axes of the ground."""

    origin: Vector
    axes: list[Vector]


@dataclass(frozen=True, eq=False)
class Column:
    """Motion of a link relative to its parent in the tree, per unit of one velocity coordinate.

    `angular` is its angular velocity, `linear` its velocity at `point`; `sign` is -1 where the tree runs from the
    joint's second link to its first. `carrier`, 0 or 1, is the link of the joint to which the axis is fixed.
    """

    sign: float
    angular: Vector
    linear: Vector
    point: Vector
    carrier: int
