"""Indices of tension, torsion and the two planes of bending among the twelve end components of a beam."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..framework.protocol import Array
from .bending import Plane, Row
from .parameters import Real

BARS = (0, 3)


class BendingPlane(NamedTuple):
    """Indices and signs of one plane of bending among the twelve end components and six section forces.

    Attributes
    ----------
    deflection, rotation
        Indices of its displacement and rotation among the six of a point.
    sign
        Sign of the rotation in the plane: -1 in xz, where a positive ry makes uz decrease along x.
    shearing, bending
        Indices of its shear force and bending moment among the six section forces.
    dofs
        Indices of (v1, r1, v2, r2) among the twelve end components.
    signs
        Signs of these four in the plane.
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
    """Write the rows `pair` of deflection and rotation in one plane of bending into `rows`, (..., 6, 12)."""
    deflection, rotation = pair
    for dof, sign, m, t in zip(plane.dofs, plane.signs, deflection, rotation, strict=True):
        rows[..., plane.deflection, dof] = sign * m
        rows[..., plane.rotation, dof] = plane.sign * sign * t


def deformations(planes: Sequence[Plane], arm: Array) -> dict[tuple[int, int], Real]:
    """Deformation of each spring per unit end displacement, by (spring, end displacement); missing pairs are zero."""
    found: dict[tuple[int, int], Real] = {}
    for bar in BARS:
        found[bar, bar], found[bar, bar + 6] = -1.0, 1.0
    for direction, plane in zip(DIRECTIONS, planes, strict=True):
        deflection, rotation, sign = direction[:3]
        # the two parts add up to the length in its precision, so that a rigid rotation costs no energy
        before = plane.fraction * arm
        found[deflection, deflection], found[deflection, deflection + 6] = 1.0, -1.0
        found[deflection, rotation], found[deflection, rotation + 6] = sign * before, sign * (arm - before)
        found[rotation, rotation], found[rotation, rotation + 6] = -sign, sign
    return found
