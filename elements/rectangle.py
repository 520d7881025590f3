"""The solid rectangular cross-section."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..framework.protocol import Array
from .cross_section import CrossSection, greatest, split, von_mises
from .parameters import Real, as_real
from .rectangle_sides import CATALAN, raise_along

# Sum of 1 / n^5 over all n, Riemann's zeta function of five.
ZETA5 = 1.036927755143369926331365486457034168057


@dataclass(frozen=True, eq=False)
class Rectangle(CrossSection):
    """Solid rectangle of sizes `y` and `z` along the local axes of the same names.

    Bending in the local xy plane has ``Iz = z y^3 / 12``, in the xz plane ``Iy = y z^3 / 12``.
    Torsion constant and stresses are Saint-Venant's series (Timoshenko & Goodier, *Theory of
    Elasticity*, 3rd ed., art. 109), with their slow part ``tanh -> 1`` summed in closed form so
    that a dozen terms reach machine precision for every ratio of the sides. The shear
    coefficients are 5/6 (Cowper 1966, nu = 0).

    Parameters
    ----------
    y, z : array_like
        Sizes along local y and z, (...), length, above zero.

    Raises
    ------
    FrameError
        If a size is not a positive number, or the shapes do not broadcast.

    Examples
    --------
    >>> square = Rectangle(y=2.0, z=2.0)
    >>> round(square.J / 2.0**4, 4)
    0.1406
    """

    y: Real
    z: Real

    def _derive(self) -> dict[str, Real]:
        y, z = self.y, self.z
        return {
            "A": y * z,
            "Iy": y * (z * z * z) / 12.0,
            "Iz": z * (y * y * y) / 12.0,
            "J": _torsion_constant(y, z),
            "ky": 5.0 / 6.0,
            "kz": 5.0 / 6.0,
        }

    @cached_property
    def torsion_moduli(self) -> tuple[Array, Array]:
        """Torque over shear stress at mid-side, (...) each: of the sides ``y = const``, of the sides ``z = const``."""
        short, long = _sides(self.y, self.z)
        at_long = 1.0 - 8.0 / np.pi**2 * _series(long / short, 0.5, lambda n, e: 2.0 * e / (1.0 + e * e) / n**2)
        remainder = _series(long / short, 1.0, lambda n, e: (2.0 - n % 4.0) * 2.0 * e / (1.0 + e) / n**2)
        at_short = 8.0 / np.pi**2 * (CATALAN - remainder)
        of_long, of_short = self.J / (short * at_long), self.J / (short * at_short)
        upright = np.asarray(self.z) >= np.asarray(self.y)  # where the sides y = const are the long ones
        return np.where(upright, of_long, of_short), np.where(upright, of_short, of_long)

    def stress(self, forces: Array) -> Array:
        """Extreme stresses, along the four sides and in the centre.

        Normal stress is extreme in a corner. Von Mises stress is the greatest over the corners
        (no shear), the four sides (bending, torsion by Saint-Venant's series, and the parabola of the shear force along
        the side, 3/2 of the mean at its middle) and the centre. It is exact in corners, at mid-sides and in the centre.
        In between, the sides are sampled so closely that the greatest stress is underestimated by less than 0.1 %.
        Other points inside are not sampled: there two shear forces together with bending can give about 2 % more.

        Parameters
        ----------
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz``, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area.

        Examples
        --------
        Bending alone, ``6 M / (z y^2)``.

        >>> from linkframe.elements import Rectangle
        >>> Rectangle(y=2.0, z=1.0).stress([0.0, 0.0, 0.0, 0.0, 0.0, 1.0]).tolist()
        [-1.5, 1.5, 1.5]
        """
        N, Vy, Vz, T, My, Mz = split(forces)
        axial, by_y, by_z = N / self.A, -Mz * self.y / (2.0 * self.Iz), My * self.z / (2.0 * self.Iy)
        bending = np.abs(by_y) + np.abs(by_z)
        shear_y, shear_z = 1.5 * Vy / self.A, 1.5 * Vz / self.A
        twist_y, twist_z = (T / modulus for modulus in self.torsion_moduli)
        worst = greatest(
            np.abs(axial) + bending,
            von_mises(axial, np.hypot(shear_y, shear_z)),
            von_mises(axial + by_y, shear_z + twist_y),
            von_mises(axial - by_y, shear_z - twist_y),
            von_mises(axial + by_z, shear_y - twist_z),
            von_mises(axial - by_z, shear_y + twist_z),
        )
        worst = raise_along(worst, self.z / self.y, (axial, by_y, by_z), shear_z, twist_y)
        worst = raise_along(worst, self.y / self.z, (axial, by_z, by_y), shear_y, -twist_z)
        return np.stack(np.broadcast_arrays(axial - bending, axial + bending, worst), axis=-1)


def _torsion_constant(y: Real, z: Real) -> Real:
    """``b a^3 / 3 (1 - 192 a / (pi^5 b) sum_odd tanh(n pi b / 2a) / n^5)`` for the sides a <= b."""
    short, long = _sides(y, z)
    total = 31.0 / 32.0 * ZETA5 - _series(long / short, 1.0, lambda n, e: 2.0 * e / (1.0 + e) / n**5)
    return as_real(long * short**3 * (1.0 - 192.0 / np.pi**5 * short / long * total) / 3.0)


def _sides(y: Real, z: Real) -> tuple[Array, Array]:
    """Short and long side, (...) each."""
    return np.asarray(np.minimum(y, z)), np.asarray(np.maximum(y, z))


def _series(ratio: Array, rate: float, term: Callable[[float, Array], Array]) -> Array:
    """Sum over odd n of ``term(n, exp(-rate pi n ratio))``, (...), to double precision for ratio >= 1."""
    return np.asarray(sum(term(n, np.exp(-rate * np.pi * n * ratio)) for n in np.arange(1.0, 12.0 / rate, 2.0)))
