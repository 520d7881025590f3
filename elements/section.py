"""Section given by its properties."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass, fields

import numpy as np

from ..framework.errors import FrameError
from ..framework.protocol import Array
from .cross_section import CrossSection, greatest, split, von_mises
from .parameters import Real, common_shape, positive

NOT_GIVEN = float("nan")


@dataclass(frozen=True, eq=False)
class Section(CrossSection):
    """Doubly symmetric section of any form, by its properties.

    Parameters
    ----------
    A : array_like
        Area, (...), above zero.
    Iy, Iz : array_like
        Second moments of area about local y and z, (...), above zero.
    J : array_like
        Saint-Venant torsion constant, (...), above zero.
    ky, kz : array_like, optional
        Shear coefficients, (...); needed by a beam with shear deformation, and for stress.
    cy, cz : array_like, optional
        Distances from the centroid to the extreme fibres along y and z, (...); needed for stress.
    Wt : array_like, optional
        Torque per greatest torsional shear stress, (...); needed for stress.

    Raises
    ------
    FrameError
        If a property is not a positive number, or the shapes do not broadcast.

    Examples
    --------
    >>> channel = Section(A=1.1e-3, Iy=1.06e-6, Iz=1.94e-7, J=2.8e-8)
    >>> channel.A
    0.0011
    """

    A: Real
    Iy: Real
    Iz: Real
    J: Real
    ky: Real = NOT_GIVEN
    kz: Real = NOT_GIVEN
    cy: Real = NOT_GIVEN
    cz: Real = NOT_GIVEN
    Wt: Real = NOT_GIVEN

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if value is not NOT_GIVEN:
                object.__setattr__(self, each.name, positive("Section", each.name, value))
        common_shape("Section", {name: np.shape(value) for name, value in self.sizes().items()})

    @property
    def form(self) -> Hashable:
        """Sections of which the same properties are given."""
        return type(self), tuple(self.sizes())

    def sizes(self) -> dict[str, Real]:
        """The properties that were given, by name.

        Returns
        -------
        dict
            Number or array, (...), by the name of the property.
        """
        # a number that is none is not equal to itself
        return {
            name: value
            for name, value in super().sizes().items()
            if (value == value if type(value) is float else not np.any(np.isnan(value)))
        }

    def _derive(self) -> dict[str, Real]:
        return {}

    def require(self, purpose: str, *names: str) -> None:
        """Refuse `purpose` if a property that it needs was not given.

        Parameters
        ----------
        purpose
            What for, as the error tells it.
        *names
            Names of the properties that it needs.

        Raises
        ------
        FrameError
            If one of them was not given.
        """
        missing = [name for name in names if name not in self.sizes()]
        if missing:
            raise FrameError(f"Section: {purpose} needs {', '.join(names)}; give {', '.join(missing)}")

    def stress(self, forces: Array) -> Array:
        """Extreme stresses, estimated upwards.

        Bounds, since the form is not known: the extreme fibres are taken to meet in corners, with the
        whole torsional stress there; and the mean shear ``V / (k A)`` of both directions and the torsional stress
        are added at the centroid.

        Parameters
        ----------
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz``, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area: none is less than
            in truth.

        Raises
        ------
        FrameError
            If one of ky, kz, cy, cz, Wt was not given.

        Examples
        --------
        >>> from linkframe.elements import Section
        >>> section = Section(A=2.0, Iy=1.0, Iz=1.0, J=1.0, ky=1.0, kz=1.0, cy=0.5, cz=0.5, Wt=1.0)
        >>> section.stress([2.0, 0.0, 0.0, 0.0, 0.0, 4.0]).tolist()
        [-1.0, 3.0, 3.0]
        """
        self.require("stress", "ky", "kz", "cy", "cz", "Wt")
        N, Vy, Vz, T, My, Mz = split(forces)
        axial, torsion = N / self.A, np.abs(T) / self.Wt
        bending = np.abs(Mz) * self.cy / self.Iz + np.abs(My) * self.cz / self.Iy
        shear = np.hypot(Vy / (self.ky * self.A), Vz / (self.kz * self.A))
        least, most = axial - bending, axial + bending
        worst = greatest(von_mises(np.abs(axial) + bending, torsion), von_mises(axial, shear + torsion))
        return np.stack(np.broadcast_arrays(least, most, worst), axis=-1)
