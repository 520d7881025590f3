"""Where the six motions of a beam meet its twelve end components: two bars and two planes of bending."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from ..framework.protocol import Array
from .bending import Row
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


def _plain_deformations() -> dict[tuple[int, int], float]:
    found: dict[tuple[int, int], float] = {}
    for bar in BARS:
        found[bar, bar], found[bar, bar + 6] = -1.0, 1.0
    for deflection, rotation, sign, *_ in DIRECTIONS:
        found[deflection, deflection], found[deflection, deflection + 6] = 1.0, -1.0
        found[rotation, rotation], found[rotation, rotation + 6] = -sign, sign
    return found


# By spring and end displacement, how much it deforms, where that is the same for every beam.
PLAIN_DEFORMATIONS = _plain_deformations()


def deflections(fractions: Sequence[Real], arm: Array) -> dict[tuple[int, int], Real]:
    """By spring and rotation of an end, how much it deforms; `fractions` of the arm lie before the elastic centres."""
    found: dict[tuple[int, int], Real] = {}
    for direction, fraction in zip(DIRECTIONS, fractions, strict=True):
        # the parts add up to the length in its precision, so that a rigid turn costs no energy
        before = fraction * arm
        after = arm - before
        ends = (before, after) if direction.sign > 0.0 else (-before, -after)
        _, start, _, end = direction.dofs
        found[direction.deflection, start], found[direction.deflection, end] = ends
    return found
