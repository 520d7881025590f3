"""Where the six motions of a beam meet its twelve end components: two bars and two planes of bending."""

from __future__ import annotations

from typing import NamedTuple

from ..framework.protocol import Array
from .bending import Row

BARS = (0, 3)


class Direction(NamedTuple):
    """A plane of bending in the twelve end components and six section forces."""

    moved: int
    turned: int
    sign: float

    @property
    def dofs(self) -> tuple[int, int, int, int]:
        """End components (v1, r1, v2, r2)."""
        return self.moved, self.turned, self.moved + 6, self.turned + 6

    @property
    def signs(self) -> tuple[float, float, float, float]:
        """Sense of the four in the plane: in xz a positive rotation lowers uz along x."""
        return 1.0, self.sign, 1.0, self.sign

    @property
    def shearing(self) -> int:
        """Section force that shears."""
        return self.moved

    @property
    def bending(self) -> int:
        """Section force that bends."""
        return self.turned


DIRECTIONS = (Direction(1, 5, 1.0), Direction(2, 4, -1.0))


def stamp_rows(rows: Array, way: Direction, pair: tuple[Row, Row]) -> None:
    """Write the rows of displacement and rotation of one plane of bending."""
    moved, turned = pair
    for dof, sign, m, t in zip(way.dofs, way.signs, moved, turned, strict=True):
        rows[..., way.moved, dof] = sign * m
        rows[..., way.turned, dof] = way.sign * sign * t
