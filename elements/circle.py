"""Solid circle."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..framework.protocol import Array
from .cross_section import CrossSection
from .parameters import Real
from .rim import rim_stress


@dataclass(frozen=True, eq=False)
class Circle(CrossSection):
    """Solid circle.

    ``A = pi d^2 / 4``, ``Iy = Iz = pi d^4 / 64``, ``J = pi d^4 / 32``, shear coefficients 6/7
    (Cowper 1966, nu = 0).

    Parameters
    ----------
    diameter : array_like
        Diameter, (...), length, above zero.

    Raises
    ------
    FrameError
        If the diameter is not a positive number.

    Examples
    --------
    >>> Circle(diameter=2.0).A
    3.141592653589793
    """

    diameter: Real

    @cached_property
    def A(self) -> Real:
        return np.pi / 4.0 * self.diameter**2

    @cached_property
    def Iy(self) -> Real:
        return np.pi / 64.0 * self.diameter**4

    @property
    def Iz(self) -> Real:
        return self.Iy

    @cached_property
    def J(self) -> Real:
        return 2.0 * self.Iy

    @property
    def ky(self) -> Real:
        return 6.0 / 7.0

    @property
    def kz(self) -> Real:
        return 6.0 / 7.0

    def stress(self, forces: Array) -> Array:
        """Least and greatest normal stress and greatest von Mises stress on the rim, (..., 3).

        The shear force gives the tangential stress ``4/3 V sin(angle) / A`` on the rim (Timoshenko,
        *Strength of Materials* I, 3rd ed., art. 26).

        Parameters
        ----------
        forces
            ``N Vy Vz T My Mz``, (..., 6).
        """
        return rim_stress(forces, self.A, self.Iy, self.diameter / 2.0, 4.0 / 3.0)
