"""The base class of cross-sections, `CrossSection`, and the stress formulas that they share."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Hashable
from dataclasses import dataclass, field, fields
from functools import cache
from typing import Self

import numpy as np

from ..framework.lazily import cached_property
from ..framework.protocol import Array
from .parameters import Real, common_shape, derived_numbers, given_state, positive, shape_of


@cache
def _sizes_of(kind: type) -> tuple[str, ...]:
    """Names of the parameters of a class of sections."""
    return tuple(each.name for each in fields(kind) if each.init)


@dataclass(frozen=True, eq=False)
class CrossSection(ABC):
    """A cross-section in its principal axes, the local y, z axes of its member; its shear centre is the centroid.

    A subclass is a frozen dataclass of sizes, positive numbers or arrays of them, from which it derives the properties
    below. Normal stress is ``N / A - Mz y / Iz + My z / Iy`` (Timoshenko, *Strength of Materials* I), tension positive.

    Attributes
    ----------
    A
        Area, (...).
    Iy, Iz
        Second moments of area about local y and z, (...): ``Iy`` goes with bending in the local
        xz plane, ``Iz`` with bending in the local xy plane.
    J
        Saint-Venant torsion constant, (...).
    ky, kz
        Shear coefficients for shear forces along y and z, (...): the shear areas are ``ky A``, ``kz A``.
        All shapes take Cowper's values at nu = 0 (G. R. Cowper, J. Appl. Mech. 33 (1966) 335-340),
        so that a section does not depend on its material; his values at nu = 0.3 are 2 (rectangle)
        to 6 (thin tube) per cent greater. `Section` takes any other.
    """

    A: Real = field(init=False, repr=False)
    Iy: Real = field(init=False, repr=False)
    Iz: Real = field(init=False, repr=False)
    J: Real = field(init=False, repr=False)
    ky: Real = field(init=False, repr=False)
    kz: Real = field(init=False, repr=False)

    def __post_init__(self) -> None:
        name = type(self).__name__
        for size, value in self.sizes().items():
            object.__setattr__(self, size, positive(name, size, value))
        common_shape(name, {size: np.shape(value) for size, value in self.sizes().items()})
        try:
            with np.errstate(all="ignore"):
                derived = self._derive()
        except ArithmeticError:
            derived = {"A": np.inf}
        vars(self).update(derived_numbers(name, derived))

    def __getstate__(self) -> dict[str, object]:
        return given_state(self)

    def sizes(self) -> dict[str, Real]:
        """The parameters from which the section was made, by name.

        Returns
        -------
        dict
            Number or array (...), length, by the name of the parameter.

        Examples
        --------
        >>> from linkframe.elements import Rectangle
        >>> Rectangle(y=0.02, z=0.01).sizes()
        {'y': 0.02, 'z': 0.01}
        """
        return {name: getattr(self, name) for name in _sizes_of(type(self))}

    @property
    def form(self) -> Hashable:
        """Key that is equal for sections that can be evaluated together, as one section with arrays of sizes.

        It is the class for linkframe's own shapes, else the section itself.
        """
        return type(self) if type(self).__module__.startswith(__name__.rpartition(".")[0]) else self

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of the sizes."""
        return shape_of(*self.sizes().values())

    def between(self, end: Self, fraction: Real, rest: Real | None = None) -> Self:
        """Section between this one and another of its type, by linear interpolation of the sizes.

        Parameters
        ----------
        end
            Section at the fraction 1.
        fraction
            0 for this section to 1 for `end`, (...).
        rest
            What is left of 1, (...), where that is known to more digits than ``1 - fraction`` has; None for that.

        Returns
        -------
        same type
            The interpolated section; its batch shape is the broadcast of both sections' and the fraction's.

        Examples
        --------
        >>> from linkframe.elements import Circle
        >>> Circle(diameter=0.02).between(Circle(diameter=0.04), 0.25).diameter
        0.025
        """
        here, there = self.sizes(), end.sizes()
        share = 1.0 - fraction if rest is None else rest
        return type(self)(**{name: share * here[name] + fraction * there[name] for name in here if name in there})

    @abstractmethod
    def _derive(self) -> dict[str, Real]:
        """Those of A, Iy, Iz, J, ky and kz that are not parameters themselves, by name, (...) each."""

    @abstractmethod
    def stress(self, forces: Array) -> Array:
        """Extreme stresses over the section.

        Parameters
        ----------
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz``, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area.
        """


def split(forces: Array) -> tuple[Array, ...]:
    """The components N, Vy, Vz, T, My, Mz of internal forces (..., 6), (...) each."""
    return tuple(np.moveaxis(np.asarray(forces, dtype=np.float64), -1, 0))


def von_mises(normal: Real, shear: Real) -> Array:
    """Von Mises stress of one normal and one shear stress, ``sqrt(s^2 + 3 t^2)``."""
    return np.asarray(np.hypot(normal, np.sqrt(3.0) * shear))


def greatest(*stresses: Real) -> Array:
    """Greatest of several stresses, (...), the broadcast of their batch shapes."""
    return np.asarray(np.max(np.stack(np.broadcast_arrays(*stresses)), axis=0))
