"""The cross-section that is given by its properties, `Section`."""

from __future__ import annotations

import warnings
from collections.abc import Hashable
from dataclasses import dataclass, field, fields
from typing import Self

import numpy as np

from ..framework.batch import numbers
from ..framework.errors import FrameError
from ..framework.lazily import cached_property
from ..framework.protocol import Array
from .analysed_section import properties_of
from .cross_section import CrossSection, greatest, split, von_mises
from .parameters import Real, common_shape, positive, shape_of

NOT_GIVEN = float("nan")
# Size of an array of fibres times batch entries that still stays in the processor's cache.
BLOCK = 200_000


@dataclass(frozen=True, eq=False)
class Section(CrossSection):
    """Section of any form, given by its properties in principal axes, its shear centre being the centroid.

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
        Torsional section modulus: torque over greatest torsional shear stress, (...), length cubed; needed for stress.
    fibres : array_like, optional
        Points at which stress is evaluated, (n, 8): coordinates y and z, the shear stress along y by unit forces Vy, Vz
        and a unit torque T, and likewise that along z. With them stress is the greatest over these points, and none of
        the other properties is needed for it.

    Raises
    ------
    FrameError
        If a property is not a positive number, the fibres are not rows of eight numbers, or the shapes do not
        broadcast.

    Examples
    --------
    >>> profile = Section(A=1.1e-3, Iy=1.06e-6, Iz=1.94e-7, J=2.8e-8)
    >>> profile.A
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
    fibres: Array | None = field(default=None, repr=False)

    @classmethod
    def from_sectionproperties(cls, analysed: object, *, unit: float = 1.0, principal: bool = False) -> Self:
        """Section of any form as the package sectionproperties has analysed it (extra ``sections``).

        Its x and y become local y and z, its shear coefficients are those at nu = 0, and stress is evaluated at all
        nodes of its mesh. At a re-entrant corner stress grows as the mesh is refined. ::

            from sectionproperties.pre.library import channel_section
            geometry = channel_section(d=100, b=50, t_f=8, t_w=5, r=6, n_r=8).create_mesh([10.0])
            channel = Section.from_sectionproperties(geometry, unit=1e-3)

        Parameters
        ----------
        analysed
            A section with geometric and warping properties, or a geometry with a mesh, which is then analysed. It must
            not have materials of its own.
        unit
            Its unit of length in units of the frame: 1e-3 for a drawing in millimetres and a frame in metres.
        principal
            Whether to take its first and second principal axis as local y and z. Rotate the beam accordingly by
            ``up=``.

        Returns
        -------
        Section
            Section with all properties and with fibres.

        Raises
        ------
        FrameError
            If it is not analysed, has materials, or has a product of inertia where `principal` is False.

        Warns
        -----
        UserWarning
            If the shear centre lies off the centroid: the twist of the member under transverse forces is neglected.
        """
        if not (np.ndim(unit) == 0 and np.isfinite(unit) and unit > 0.0):
            raise FrameError(f"Section.from_sectionproperties: unit = {unit!r} must be a positive number of lengths")
        given, left_out = properties_of(analysed, float(unit), bool(principal))
        if left_out:
            warnings.warn(f"Section.from_sectionproperties: {left_out}", UserWarning, stacklevel=2)
        return cls(**given)

    def __post_init__(self) -> None:
        for each in fields(self):
            value = getattr(self, each.name)
            if each.name != "fibres" and value is not NOT_GIVEN:
                object.__setattr__(self, each.name, positive("Section", each.name, value))
        if self.fibres is not None:
            object.__setattr__(self, "fibres", _checked(self.fibres))
        common_shape("Section", {name: np.shape(value) for name, value in self.sizes().items()})

    @cached_property
    def shape(self) -> tuple[int, ...]:
        """Batch shape: the broadcast of the properties."""
        return shape_of(*super().sizes().values()) if self.fibres is None else super().shape

    @property
    def form(self) -> Hashable:
        """Key that is equal for sections of which the same properties are given; with fibres, the section itself."""
        return (type(self), self._given) if self.fibres is None else self

    @cached_property
    def _given(self) -> tuple[str, ...]:
        """Names of the properties that were given."""
        # properties that were not given are NaN, which is not equal to itself
        return tuple(
            name
            for name, value in super().sizes().items()
            if name != "fibres" and (value == value if type(value) is float else not np.any(np.isnan(value)))
        )

    def sizes(self) -> dict[str, Real]:
        """The properties that were given, by name.

        Returns
        -------
        dict
            Number or array, (...), by the name of the property.
        """
        return {name: getattr(self, name) for name in self._given}

    def _derive(self) -> dict[str, Real]:
        return {}

    def require(self, purpose: str, *names: str) -> None:
        """Raise an error if a property that is needed for a purpose was not given.

        Parameters
        ----------
        purpose
            Purpose, for the error message.
        *names
            Names of the properties that are needed.

        Raises
        ------
        FrameError
            If one of them was not given.
        """
        missing = [name for name in names if name not in self.sizes()]
        if missing:
            raise FrameError(f"Section: {purpose} needs {', '.join(names)}; give {', '.join(missing)}")

    def stress(self, forces: Array) -> Array:
        """Extreme stresses: the greatest at the fibres, or else an estimate from the properties.

        Without fibres the form is unknown, and bending with torsion is bounded from above: the extreme fibres are
        assumed to meet in a corner that carries the whole torsional stress. Shear is only estimated: ``V / (k A)`` of
        both directions and the torsional stress are added at the centroid; for a rectangle the true shear stress there
        is a quarter higher. Give fibres where shear governs.

        Parameters
        ----------
        forces
            Internal forces ``N Vy Vz`` and moments ``T My Mz``, (..., 6).

        Returns
        -------
        ndarray
            Least and greatest normal stress and greatest von Mises stress, (..., 3), force per area.

        Raises
        ------
        FrameError
            If neither the fibres were given nor all of ky, kz, cy, cz, Wt.

        Examples
        --------
        >>> from linkframe.elements import Section
        >>> section = Section(A=2.0, Iy=1.0, Iz=1.0, J=1.0, ky=1.0, kz=1.0, cy=0.5, cz=0.5, Wt=1.0)
        >>> section.stress([2.0, 0.0, 0.0, 0.0, 0.0, 4.0]).tolist()
        [-1.0, 3.0, 3.0]
        """
        if self.fibres is not None:
            return _at_fibres(self, self.fibres, forces)
        self.require("stress", "ky", "kz", "cy", "cz", "Wt")
        N, Vy, Vz, T, My, Mz = split(forces)
        axial, torsion = N / self.A, np.abs(T) / self.Wt
        bending = np.abs(Mz) * self.cy / self.Iz + np.abs(My) * self.cz / self.Iy
        shear = np.hypot(Vy / (self.ky * self.A), Vz / (self.kz * self.A))
        least, most = axial - bending, axial + bending
        worst = greatest(von_mises(np.abs(axial) + bending, torsion), von_mises(axial, shear + torsion))
        return np.stack(np.broadcast_arrays(least, most, worst), axis=-1)


def _checked(fibres: object) -> Array:
    array = numbers(fibres, "Section: fibres")  # type: ignore[arg-type]
    if array.ndim != 2 or array.shape[1] != 8 or not len(array) or not np.isfinite(array).all():
        raise FrameError(f"Section: fibres of shape {array.shape} must be rows of eight finite numbers, (n, 8)")
    return array


def _at_fibres(section: Section, fibres: Array, forces: Array) -> Array:
    """Least and greatest normal stress and greatest von Mises stress of all fibres, (..., 3)."""
    names = ("A", "Iy", "Iz")
    shape = np.broadcast_shapes(np.shape(forces)[:-1], section.shape)
    N, Vy, Vz, T, My, Mz = (np.broadcast_to(part, shape).reshape(-1, 1) for part in split(forces))
    A, Iy, Iz = (np.broadcast_to(getattr(section, name), shape).reshape(-1, 1) for name in names)
    by_place = np.concatenate([N / A, -Mz / Iz, My / Iy], axis=-1)
    shearing = np.concatenate([Vy, Vz, T], axis=-1)
    places = np.stack([np.ones(len(fibres)), fibres[:, 0], fibres[:, 1]])
    out = np.empty((len(by_place), 3))
    step = max(1, BLOCK // len(fibres))
    for start in range(0, len(out), step):
        some = slice(start, start + step)
        normal = by_place[some] @ places
        shear = np.hypot(shearing[some] @ fibres[:, 2:5].T, shearing[some] @ fibres[:, 5:].T)
        out[some] = np.stack([normal.min(axis=-1), normal.max(axis=-1), von_mises(normal, shear).max(axis=-1)], axis=-1)
    return out.reshape(*shape, 3)
