"""Greatest von Mises stress along a flat wall of an open section, of bending, shear flow and torsion together."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..framework.protocol import Array
from .parameters import Real
from .rectangle_sides import BLOCK, PARABOLA, Side, side_of

# Number of intervals into which a wall without torsion is divided for sampling.
PLACES = 24


@dataclass(frozen=True)
class Wall:
    """Magnitudes of the stresses along a wall, from its middle, s = 0, to its end, s = 1.

    Normal stress is ``level + rise s``, shear stress ``constant + linear (1 - s) + parabola (1 - s^2) + twist g(s)``,
    where g is the torsional stress along a side of a rectangle over that at mid-side, zero at the end.

    Attributes
    ----------
    level, rise, constant, linear, parabola, twist
        Coefficients, force per area, zero or above, (...).
    """

    level: Real
    rise: Real
    constant: Real = 0.0
    linear: Real = 0.0
    parabola: Real = 0.0
    twist: Real = 0.0

    def of(self, kept: NDArray[np.bool_]) -> list[Array]:
        """The six coefficients at the n batch entries where the mask `kept` (...) is True, (n,) each."""
        every = self.level, self.rise, self.constant, self.linear, self.parabola, self.twist
        return [np.broadcast_to(np.asarray(each), kept.shape)[kept] for each in every]


def raise_along_wall(worst: Array, wall: Wall, ratio: Real = 1.0, start: Real = 0.0) -> Array:
    """Greatest von Mises stress along a wall, or `worst` where that is greater.

    Parameters
    ----------
    worst
        Greatest von Mises stress so far, which includes both ends of the wall, (...).
    wall
        Stresses along the wall.
    ratio
        Ratio of the length of the face to its width, (...).
    start
        Coordinate s from which on the wall is sampled, (...).

    Returns
    -------
    ndarray
        Greatest von Mises stress, force per area, (...).
    """
    # At the distance d = 1 - s from the end, the square of the normal stress is lower than at the end by at least
    # falls d, and three times the square of the shear stress is higher by at most rises d.
    falls = wall.rise * (2.0 * np.asarray(wall.level) + wall.rise)
    steepest = np.sqrt(1.42 + 0.78 * np.asarray(ratio))
    steep = np.sqrt(PARABOLA) * np.asarray(wall.parabola) + wall.linear + steepest * wall.twist
    rises = 3.0 * (steep**2 + 2.0 * wall.constant * (2.0 * np.asarray(wall.parabola) + wall.linear))
    kept = np.broadcast_to((falls > 0.0) & (rises > falls), worst.shape) & np.isfinite(worst)
    if not kept.any():
        return worst
    so_far, raised = worst[kept], worst.copy()
    # Stresses are divided by the greatest so far, so that squares do not overflow.
    numbers = [each / so_far for each in wall.of(kept)]
    lengths, starts = (np.broadcast_to(np.asarray(each, dtype=float), worst.shape)[kept] for each in (ratio, start))
    twisted = bool(numbers[-1].any())
    for first in range(0, so_far.size, BLOCK):
        some = slice(first, first + BLOCK)
        side = places(lengths[some]) if twisted else _EVEN
        so_far[some] *= np.sqrt(_highest(side, starts[some], [each[some] for each in numbers]))
    raised[kept] = so_far
    return raised


def _highest(side: Side, start: Array, numbers: list[Array]) -> Array:
    """Greatest square of the von Mises stress over the sample points, at least one, (n,)."""
    level, rise, constant, linear, parabola, twist = numbers
    found = np.ones_like(level)
    for place, g in zip(side.place, side.torsion, strict=True):
        s = np.maximum(place, start)
        normal = level + rise * s
        shear = constant + (1.0 - s) * (linear + parabola * (1.0 + s)) + twist * g
        np.maximum(found, normal * normal + 3.0 * shear * shear, out=found)
    return found


def places(ratio: Array) -> Side:
    """Sample points of a side for ratios (n,), (k, n); (k, 1) where all ratios are equal.

    Parameters
    ----------
    ratio
        Ratio of the length of the side to that of the other, (n,).

    Returns
    -------
    Side
        Sample points and torsional stress there.
    """
    alike = ratio.size > 0 and bool(np.all(ratio == ratio.flat[0]))
    return side_of(ratio[:1] if alike else ratio)


_EVEN = Side(*(each[:, None] for each in (np.arange(1.0, PLACES) / PLACES, np.zeros(PLACES - 1))))
