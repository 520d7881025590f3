"""Where the six motions of a beam meet its twelve end components: two bars and two planes of bending."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..framework.protocol import Array
from .bending import Plane, Row
from .parameters import Real

BARS = (0, 3)


class BendingPlane(NamedTuple):
    """A plane of bending in the twelve end components and six section forces.

    Attributes
    ----------
    deflection, rotation
        Components of an end that lie in it.
    sign
        Sense of the rotation in the plane: in xz a positive one lowers uz along x.
    shearing, bending
        Section forces that shear and that bend.
    dofs
        End components (v1, r1, v2, r2).
    signs
        Sense of these four in the plane.
    """

    deflection: int
    rotation: int
    sign: float
    shearing: int
    bending: int
    dofs: tuple[int, int, int, int]
    signs: tuple[float, float, float, float]


DIRECTIONS = (
    BendingPlane(1, 5, 1.0, 1, 5, (1, 5, 7, 11), (1.0, 1.0, 1.0, 1.0)),
    BendingPlane(2, 4, -1.0, 2, 4, (2, 4, 8, 10), (1.0, -1.0, 1.0, -1.0)),
)


def stamp_rows(rows: Array, plane: BendingPlane, pair: tuple[Row, Row]) -> None:
    """Write the rows of displacement and rotation of one plane of bending."""
    deflection, rotation = pair
    for dof, sign, m, t in zip(plane.dofs, plane.signs, deflection, rotation, strict=True):
        rows[..., plane.deflection, dof] = sign * m
        rows[..., plane.rotation, dof] = plane.sign * sign * t


def deformations(planes: Sequence[Plane], arm: Array) -> dict[tuple[int, int], Real]:
    """By spring and end displacement, how much it deforms; what is left out is zero."""
    found: dict[tuple[int, int], Real] = {}
    for bar in BARS:
        found[bar, bar], found[bar, bar + 6] = -1.0, 1.0
    for direction, plane in zip(DIRECTIONS, planes, strict=True):
        deflection, rotation, sign = direction[:3]
        # the parts add up to the length in its precision, so that a rigid turn costs no energy
        before = plane.fraction * arm
        found[deflection, deflection], found[deflection, deflection + 6] = 1.0, -1.0
        found[deflection, rotation], found[deflection, rotation + 6] = sign * before, sign * (arm - before)
        found[rotation, rotation], found[rotation, rotation + 6] = -sign, sign
    return found
