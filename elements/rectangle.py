"""Solid rectangle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy.special import zeta

from ..framework.protocol import Array
from .cross_section import CrossSection, von_mises
from .parameters import Real

CATALAN = 0.915965594177219015054603514932384110774


@dataclass(frozen=True, eq=False)
class Rectangle(CrossSection):
    """Solid rectangle of sizes `y` and `z` along the local axes of the same names.

    Bending in the local xy plane has ``Iz = z y^3 / 12``, in the xz plane ``Iy = y z^3 / 12``.
    The torsion constant and stresses are Saint-Venant's series (Timoshenko & Goodier, *Theory of
    Elasticity*, 3rd ed., art. 109) with the slowly converging part summed in closed form, so
    that the dozen terms kept reach machine precision for every ratio of the sides. The shear
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

    @cached_property
    def A(self) -> Real:
        return self.y * self.z

    @cached_property
    def Iy(self) -> Real:
        return self.y * self.z * self.z * self.z / 12.0

    @cached_property
    def Iz(self) -> Real:
        return self.z * self.y * self.y * self.y / 12.0

    @cached_property
    def J(self) -> Real:
        short, long = _sides(self.y, self.z)
        n, decay = _terms(long / short, 1.0)
        tail = 31.0 / 32.0 * zeta(5) - np.sum(2.0 * decay / (1.0 + decay) / n**5, axis=-1)
        J = long * short**3 * (1.0 - 192.0 / np.pi**5 * short / long * tail) / 3.0
        return float(J) if J.ndim == 0 else J

    @property
    def ky(self) -> Real:
        return 5.0 / 6.0

    @property
    def kz(self) -> Real:
        return 5.0 / 6.0

    @cached_property
    def torsion_moduli(self) -> tuple[Array, Array]:
        """Torque per shear stress at mid-side, (...) each: sides ``y = const``, sides ``z = const``."""
        short, long = _sides(self.y, self.z)
        n, decay = _terms(long / short, 0.5)
        at_long = 1.0 - 8.0 / np.pi**2 * np.sum(2.0 * decay / (1.0 + decay**2) / n**2, axis=-1)
        n, decay = _terms(long / short, 1.0)
        sign = 1.0 - (n - 1.0) % 4.0
        at_short = 8.0 / np.pi**2 * (CATALAN - np.sum(sign * 2.0 * decay / (1.0 + decay) / n**2, axis=-1))
        of_long, of_short = self.J / (short * at_long), self.J / (short * at_short)
        # the sides y = const are the long ones where z is the greater size
        upright = np.asarray(self.z) >= np.asarray(self.y)
        return np.where(upright, of_long, of_short), np.where(upright, of_short, of_long)

    def stress(self, forces: Array) -> Array:
        """Least and greatest normal stress and greatest von Mises stress, (..., 3).

        Normal stress is extreme in a corner. Von Mises stress is the greatest over the corners
        (no shear), the four mid-sides (torsion, and 3/2 of the mean shear along the side) and the centre.

        Parameters
        ----------
        forces
            ``N Vy Vz T My Mz``, (..., 6).
        """
        N, Vy, Vz, T, My, Mz = np.moveaxis(np.asarray(forces, dtype=np.float64), -1, 0)
        axial, by_y, by_z = N / self.A, np.abs(Mz) * self.y / 2.0 / self.Iz, np.abs(My) * self.z / 2.0 / self.Iy
        least, greatest = axial - by_y - by_z, axial + by_y + by_z
        shear_y, shear_z = 1.5 * Vy / self.A, 1.5 * Vz / self.A
        modulus_y, modulus_z = self.torsion_moduli
        bend_y, bend_z = -Mz * self.y / 2.0 / self.Iz, My * self.z / 2.0 / self.Iy
        points = [np.abs(least), np.abs(greatest), von_mises(axial, np.hypot(shear_y, shear_z))]
        for side in (1.0, -1.0):
            points.append(von_mises(axial + side * bend_y, shear_z + side * T / modulus_y))
            points.append(von_mises(axial + side * bend_z, shear_y - side * T / modulus_z))
        return np.stack([least, greatest, np.max(points, axis=0)], axis=-1)


def _sides(y: Real, z: Real) -> tuple[Array, Array]:
    """Short and long side."""
    return np.asarray(np.minimum(y, z)), np.asarray(np.maximum(y, z))


def _terms(ratio: Array, rate: float) -> tuple[Array, Array]:
    """Odd n and exp(-rate pi n ratio) on a trailing axis, to machine precision for ratio >= 1."""
    n = np.arange(1.0, 12.0 / rate, 2.0)
    return n, np.exp(-rate * np.pi * n * ratio[..., None])
