"""Greatest von Mises stress along flanges and web of an I where its forces oppose each other."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
from numpy.typing import NDArray

from ..framework.protocol import Array
from .rectangle_sides import BLOCK, Side
from .wall import places

# Sample points of the web from mid-height to a flange.
_WEB = np.linspace(0.0, 1.0, 25)
_SIGNS = (1.0, -1.0)


@dataclass(frozen=True)
class SignedStresses:
    """Stresses of an I by each internal force, with their signs, (n,) each; local axes y along the flanges, z up.

    At the share s of half of a flange from its middle to its tip, on the side a = ±1 of y and c = ±1 of z, the normal
    stress is ``axial + a tip s + c top`` and the shear stress along y
    ``along (1 - s^2) + a c up (1 - s) - c flange g(s)``, g being the torsional stress along a strip; in the inner face,
    at which bending gives `root`, torsion acts the other way. In the web, at the share s of its height, they are
    ``axial + a web + c root s`` and ``middle - fall s^2 + a twist``.

    Attributes
    ----------
    axial, tip, top, root, web
        Normal stress by the axial force; by bending about z at the tips and in the faces of the web; by bending about y
        in the outer faces of the flanges and at the ends of the web.
    along, up, middle, fall
        Shear stress by Vy and by Vz in the middle of a flange, by Vz at mid-height of the web, and how much less that
        is at its ends.
    flange, twist
        Shear stress by torsion in the flanges and in the web.
    """

    axial: Array
    tip: Array
    top: Array
    root: Array
    web: Array
    along: Array
    up: Array
    middle: Array
    fall: Array
    flange: Array
    twist: Array

    def part(self, some: NDArray[np.int_]) -> SignedStresses:
        """The stresses at some of n entries, by their numbers."""
        return SignedStresses(**{name: each[some] for name, each in vars(self).items()})

    @property
    def alike(self) -> NDArray[np.bool_]:
        """Whether there are half of a flange and half of a web in which nothing opposes, (n,)."""
        flange = [
            _agree(self.axial, a * self.tip, c * self.top) & _agree(self.along, a * c * self.up, -c * self.flange)
            for a, c in product(_SIGNS, _SIGNS)
        ]
        web = [
            _agree(self.axial, a * self.web, c * self.root) & _agree(self.middle, a * self.twist)
            for a, c in product(_SIGNS, _SIGNS)
        ]
        found: NDArray[np.bool_] = np.logical_or.reduce(flange) & np.logical_or.reduce(web)
        return found

    def squares(self, side: Side, start: Array) -> Iterator[Array]:
        """Squares of the von Mises stress at all sample points, (n,) each; the flange is sampled from `start` on."""
        points = [(np.zeros(1), np.ones(1)), *zip(side.place, side.torsion, strict=True)]
        for a, c, (place, g) in product(_SIGNS, _SIGNS, points):
            s = np.maximum(place, start)
            shear = (1.0 - s) * (self.along * (1.0 + s) + a * c * self.up)
            for bent, torsion in ((self.top, -c * self.flange), (self.root, c * self.flange)):
                yield _square(self.axial + a * self.tip * s + c * bent, shear + torsion * g)
        for a, c, s in product(_SIGNS, _SIGNS, _WEB):
            yield _square(
                self.axial + a * self.web + c * self.root * s, self.middle - self.fall * s * s + a * self.twist
            )


def lowered_by_signs(worst: Array, stresses: SignedStresses, sure: Array, ratio: Array, start: Array) -> Array:
    """Greatest von Mises stress where forces oppose, from that which they would cause if they did not.

    Parameters
    ----------
    worst
        Greatest von Mises stress as if all stresses added up somewhere, (n,).
    stresses
        Stresses with their signs, (n,) each, divided by `worst`.
    sure
        Share of it that does occur, (n,).
    ratio, start
        Ratio of width to thickness of a flange, and share of its half at which the web ends, (n,).

    Returns
    -------
    ndarray
        Greatest von Mises stress, force per area, (n,).
    """
    opposed = np.flatnonzero(~stresses.alike)
    out = worst.copy()
    for first in range(0, opposed.size, BLOCK):
        some = opposed[first : first + BLOCK]
        square = sure[some] ** 2
        for each in stresses.part(some).squares(places(ratio[some]), start[some]):
            np.maximum(square, each, out=square)
        out[some] *= np.sqrt(square)
    return out


def _agree(*numbers: Array) -> NDArray[np.bool_]:
    """Whether no two of the numbers have opposite signs, (n,)."""
    signs = np.sign(np.stack(numbers))
    found: NDArray[np.bool_] = signs.max(axis=0) * signs.min(axis=0) >= 0.0
    return found


def _square(normal: Array, shear: Array) -> Array:
    return normal * normal + 3.0 * shear * shear
