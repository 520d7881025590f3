"""What the programs of a linkage are written about: links as bodies, and what each velocity coordinate moves."""

from __future__ import annotations

from dataclasses import dataclass

from ....framework.batch import Array
from .terms import Vector


@dataclass(frozen=True, eq=False)
class MovingLink:
    """A link as it is written down: its reference point and its axes, `reference_axes` before it moves.

    `place` is the reference point in the reference configuration. Vectors are in the axes of the ground.
    """

    origin: Vector
    axes: list[Vector]
    place: Array
    reference_axes: Array


@dataclass(frozen=True, eq=False)
class Column:
    """Motion of a link relative to the one before it on the tree, per unit of one velocity.

    It turns with `angular` and moves with `linear` at `point`; `sign` is -1 where the tree runs from the joint's
    second link to its first. `carrier`, 0 or 1, is the link of the joint on which the axis is fixed.
    """

    joint: str
    component: str
    sign: float
    angular: Vector
    linear: Vector
    point: Vector
    carrier: int
