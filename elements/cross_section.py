"""What every cross-section has in common."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, fields
from typing import Self

import numpy as np

from ..framework.protocol import Array
from .parameters import Real, common_shape, positive


@dataclass(frozen=True, eq=False)
class CrossSection(ABC):
    """A doubly symmetric cross-section in the local y, z axes of its member.

    A subclass is a frozen dataclass of sizes, each a positive number or an array, and gives the
    properties below. Normal stress is ``N / A - Mz y / Iz + My z / Iy``, tension positive.

    Attributes
    ----------
    A
        Area.
    Iy, Iz
        Second moments of area about local y and z: ``Iy`` goes with bending in the local xz
        plane, ``Iz`` with bending in the local xy plane.
    J
        Saint-Venant torsion constant.
    ky, kz
        Shear coefficients for shear forces along y and z: the shear areas are ``ky A``, ``kz A``.
        All shapes take Cowper's values at nu = 0 (G. R. Cowper, J. Appl. Mech. 33 (1966)
        335-340), so that a section knows nothing of its material; at nu = 0.3 his values are
        0.2 to 5 per cent higher.
    """

    def __post_init__(self) -> None:
        name = type(self).__name__
        for field in fields(self):
            object.__setattr__(self, field.name, positive(name, field.name, getattr(self, field.name)))
        common_shape(name, {field.name: np.shape(getattr(self, field.name)) for field in fields(self)})

    @property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of the sizes."""
        return np.broadcast_shapes(*(np.shape(getattr(self, field.name)) for field in fields(self)))

    def between(self, end: Self, fraction: Real) -> Self:
        """Section at `fraction` (...) of the way to `end`, sizes interpolated linearly."""
        return type(self)(
            **{
                field.name: (1.0 - fraction) * getattr(self, field.name) + fraction * getattr(end, field.name)
                for field in fields(self)
            }
        )

    @property
    @abstractmethod
    def A(self) -> Real:
        """Area, (...)."""

    @property
    @abstractmethod
    def Iy(self) -> Real:
        """Second moment of area about y, (...)."""

    @property
    @abstractmethod
    def Iz(self) -> Real:
        """Second moment of area about z, (...)."""

    @property
    @abstractmethod
    def J(self) -> Real:
        """Saint-Venant torsion constant, (...)."""

    @property
    @abstractmethod
    def ky(self) -> Real:
        """Shear coefficient along y, (...)."""

    @property
    @abstractmethod
    def kz(self) -> Real:
        """Shear coefficient along z, (...)."""

    @abstractmethod
    def stress(self, forces: Array) -> Array:
        """Least and greatest normal stress and greatest von Mises stress, (..., 3).

        Parameters
        ----------
        forces
            ``N Vy Vz T My Mz``, (..., 6).
        """


def von_mises(normal: Array, shear: Array) -> Array:
    """Von Mises stress of one normal and one shear stress, ``sqrt(s^2 + 3 t^2)``."""
    return np.asarray(np.hypot(normal, np.sqrt(3.0) * shear))
