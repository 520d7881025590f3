"""The solid circular cross-section."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..framework.protocol import Array
from .cross_section import CrossSection
from .outer_fibre import outer_fibre_stress
from .parameters import Real


@dataclass(frozen=True, eq=False)
class Circle(CrossSection):
    """Solid circle.

    ``A = pi d^2 / 4``, ``Iy = Iz = pi d^4 / 64``, ``J = pi d^4 / 32``; shear coefficients 6/7
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

    def _derive(self) -> dict[str, Real]:
        area = np.pi / 4.0 * self.diameter * self.diameter
        inertia = area * self.diameter * self.diameter / 16.0
        return {"A": area, "Iy": inertia, "Iz": inertia, "J": 2.0 * inertia, "ky": 6.0 / 7.0, "kz": 6.0 / 7.0}

    def stress(self, forces: Array) -> Array:
        """Extreme stresses, which occur in the outer fibre.

        A shear force gives the tangential stress ``4/3 V sin(angle) / A`` in the outer fibre (Timoshenko,
        *Strength of Materials* I, on beams of circular section).

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
        Torsion alone, ``sqrt(3) 16 T / (pi d^3)``.

        >>> from linkframe.elements import Circle
        >>> Circle(diameter=2.0).stress([0.0, 0.0, 0.0, 1.0, 0.0, 0.0]).round(6).tolist()
        [0.0, 0.0, 1.102658]
        """
        return outer_fibre_stress(forces, self.A, self.Iy, 0.5 * self.diameter, 4.0 / 3.0)
