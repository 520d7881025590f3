"""The cross-section of a round tube."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..framework.protocol import Array
from .cross_section import CrossSection
from .outer_fibre import outer_fibre_stress
from .parameters import Real, require


@dataclass(frozen=True, eq=False)
class Tube(CrossSection):
    """Round tube, thin or thick.

    With the inner diameter ``d = outer - 2 thickness``: ``A = pi t (D - t)``, ``Iy = Iz = A (D^2 + d^2) / 16``,
    ``J = 2 Iy``, and with m = d / D the shear coefficients ``6 (1 + m^2)^2 / (7 (1 + m^2)^2 + 20 m^2)`` (Cowper 1966,
    nu = 0): 6/7 of a solid circle, 1/2 of a thin tube.

    Parameters
    ----------
    outer : array_like
        Outer diameter, (...), length, above zero.
    thickness : array_like
        Thickness of the wall, (...), length, above zero and at most half of `outer`.

    Raises
    ------
    FrameError
        If a size is not a positive number, the wall is too thick, or the shapes do not broadcast.

    Examples
    --------
    >>> pipe = Tube(outer=0.1, thickness=0.01)
    >>> bool(abs(pipe.A - 2.8274333882308e-3) < 1e-15)
    True
    """

    outer: Real
    thickness: Real

    def _derive(self) -> dict[str, Real]:
        outer, thickness = np.asarray(self.outer), np.asarray(self.thickness)
        require("Tube", "thickness", thickness, 2.0 * thickness <= outer, "at most half of the outer diameter")
        inner = self._inner
        area = np.pi * self.thickness * (self.outer - self.thickness)
        inertia = area * (self.outer * self.outer + inner * inner) / 16.0
        ratio = (inner / self.outer) ** 2
        k = 6.0 * (1.0 + ratio) ** 2 / (7.0 * (1.0 + ratio) ** 2 + 20.0 * ratio)
        return {"A": area, "Iy": inertia, "Iz": inertia, "J": 2.0 * inertia, "ky": k, "kz": k}

    @property
    def _inner(self) -> Real:
        return self.outer - 2.0 * self.thickness

    def stress(self, forces: Array) -> Array:
        """Extreme stresses, which occur in the outer fibre.

        A shear force V gives the tangential stress ``p V sin(angle) / A`` with
        ``p = 4/3 (D^2 + D d + d^2) / (D^2 + d^2)``: Jourawski's formula at the neutral axis, which for a thin tube
        and for a solid circle holds along the whole outer fibre.

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
        Bending alone, ``M D / (2 I)``.

        >>> from linkframe.elements import Tube
        >>> pipe = Tube(outer=2.0, thickness=0.5)
        >>> pipe.stress([0.0, 0.0, 0.0, 0.0, pipe.Iy, 0.0]).round(12).tolist()
        [-1.0, 1.0, 1.0]
        """
        D, d = self.outer, self._inner
        peak = 4.0 / 3.0 * (D * D + D * d + d * d) / (D * D + d * d)
        return outer_fibre_stress(forces, self.A, self.Iy, 0.5 * D, peak)
