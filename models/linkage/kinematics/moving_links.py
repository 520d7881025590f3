"""What the formulas of a linkage are written about: links as bodies, and what each velocity coordinate moves."""

from __future__ import annotations

from dataclasses import dataclass

from .terms import Vector


@dataclass(frozen=True, eq=False)
class MovingLink:
    """A link as it is written down: its reference point and its axes, in the axes of the ground."""

    origin: Vector
    axes: list[Vector]


@dataclass(frozen=True, eq=False)
class Column:
    """Motion of a link relative to the one before it on the tree, per unit of one velocity.

    It turns with `angular` and moves with `linear` at `point`; `sign` is -1 where the tree runs from the joint's
    second link to its first. `carrier`, 0 or 1, is the link of the joint on which the axis is fixed.
    """

    sign: float
    angular: Vector
    linear: Vector
    point: Vector
    carrier: int
