"""Stress along a flat wall of an open section: bending along it, shear flow and torsion together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..framework.protocol import Array
from .parameters import Real
from .rectangle_sides import BLOCK, PARABOLA, Side, side_of

# Even places at which a wall without torsion at its end is looked at.
PLACES = 24


@dataclass(frozen=True)
class Wall:
    """Stresses along a wall, none below zero, from its middle, s = 0, to its end, s = 1; each (...).

    Normal stress is ``level + rise s``, shear stress ``constant + linear (1 - s) + parabola (1 - s^2) + twist g(s)``, g
    being the torsional stress along one side of a rectangle, which is nothing at its end.

    Attributes
    ----------
    level, rise, constant, linear, parabola, twist
        Force per area.
    """

    level: Real
    rise: Real
    constant: Real = 0.0
    linear: Real = 0.0
    parabola: Real = 0.0
    twist: Real = 0.0

    def of(self, kept: NDArray[np.bool_]) -> list[Array]:
        """The numbers, in their order, at some entries (n,) of the batch."""
        every = self.level, self.rise, self.constant, self.linear, self.parabola, self.twist
        return [np.broadcast_to(np.asarray(each), kept.shape)[kept] for each in every]


def raise_along_wall(worst: Array, wall: Wall, ratio: Real = 1.0, start: Real = 0.0) -> Array:
    """Greatest von Mises stress along a wall, or `worst` where that is greater.

    Parameters
    ----------
    worst
        Greatest von Mises stress so far, both ends of the wall among it, (...).
    wall
        Its stresses.
    ratio
        Length of the face over that across it, (...).
    start
        Share s of the wall from which on it is looked at, (...).

    Returns
    -------
    ndarray
        Force per area, (...).
    """
    # By what a share d of the wall takes off at its end, the square of the normal stress falls by no less than this
    # times d; and three times that of the shear stress rises by no more than this times d.
    falls = wall.rise * (2.0 * np.asarray(wall.level) + wall.rise)
    steepest = np.sqrt(1.42 + 0.78 * np.asarray(ratio))
    steep = np.sqrt(PARABOLA) * np.asarray(wall.parabola) + wall.linear + steepest * wall.twist
    rises = 3.0 * (steep**2 + 2.0 * wall.constant * (2.0 * np.asarray(wall.parabola) + wall.linear))
    kept = np.broadcast_to((falls > 0.0) & (rises > falls), worst.shape) & np.isfinite(worst)
    if not kept.any():
        return worst
    so_far, raised = worst[kept], worst.copy()
    # Stresses over the greatest so far, whose squares stay in range.
    numbers = [each / so_far for each in wall.of(kept)]
    lengths, starts = (np.broadcast_to(np.asarray(each, dtype=float), worst.shape)[kept] for each in (ratio, start))
    twisted = bool(numbers[-1].any())
    for first in range(0, so_far.size, BLOCK):
        some = slice(first, first + BLOCK)
        side = _places(lengths[some]) if twisted else _EVEN
        so_far[some] *= np.sqrt(_highest(side, starts[some], [each[some] for each in numbers]))
    raised[kept] = so_far
    return raised


def _highest(side: Side, start: Array, numbers: list[Array]) -> Array:
    """Greatest square of von Mises stress, not below one."""
    level, rise, constant, linear, parabola, twist = numbers
    found = np.ones_like(level)
    for place, g in zip(side.place, side.torsion, strict=True):
        s = np.maximum(place, start)
        normal = level + rise * s
        shear = constant + (1.0 - s) * (linear + parabola * (1.0 + s)) + twist * g
        np.maximum(found, normal * normal + 3.0 * shear * shear, out=found)
    return found


def _places(ratio: Array) -> Side:
    """Places of sides, those of one where all are alike."""
    alike = ratio.size > 0 and bool(np.all(ratio == ratio.flat[0]))
    return side_of(ratio[:1] if alike else ratio)


_EVEN = Side(*(each[:, None] for each in (np.arange(1.0, PLACES) / PLACES, np.zeros(PLACES - 1))))
