"""Mass, centre of mass and inertia of links, as given or computed from their beams."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np

from ....elements import Beam, Material
from ....framework.arm import carrying, cross_matrix
from ....framework.batch import Array, block_diagonal
from ....framework.cache import INERTIAS, alike
from ....framework.composed import Composed
from ....framework.orientation import default_axes
from ....framework.protocol import LineElement
from ..description.linkage_description import LinkageDescription
from ..description.parts import LinkageLink
from ..description.sketch import places

# Consistent mass matrix of a uniform line of unit mass and length.
_LINE = np.kron([[2.0, 1.0], [1.0, 2.0]], np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])) / 6.0


@dataclass(frozen=True, eq=False)
class Inertia:
    """Inertia of a rigid link.

    Attributes
    ----------
    mass
        Mass, (...).
    centre
        Centre of mass in the reference configuration, (..., 3).
    tensor
        Inertia about the centre of mass in the reference configuration, in global axes, (..., 3, 3).
    """

    mass: Array
    centre: Array
    tensor: Array


def is_given(link: LinkageLink) -> bool:
    """Whether the link's mass is a point mass in the frame, so that its beams have none.

    That is so if its centre of mass or inertia is given, or its mass without beams to carry it. A mass given alone is
    distributed over the beams; see `beams_with_mass`.
    """
    placed = link.centre is not None or link.inertia is not None
    return placed or (link.mass is not None and not _is_spread(link))


def _is_spread(link: LinkageLink) -> bool:
    """Whether a mass given alone can be distributed over the link's beams."""
    return bool(link.beams) and all(isinstance(beam, Beam) for beam in link.beams.values())


def beams_with_mass(linkage: LinkageDescription, link: LinkageLink) -> Mapping[tuple[str, str], LineElement]:
    """The beams of a link in the frame: massless if `is_given`, scaled to the link's mass if that was given alone."""
    if is_given(link):
        return {pair: without_mass(beam) for pair, beam in link.beams.items()}
    if link.mass is None:
        return link.beams
    own = _of_beams(linkage, link).mass
    share = link.mass / np.where(own > 0.0, own, np.inf)
    return {pair: _of_density(beam, share * density) for pair, beam, density in _spread_over(link)}


def _spread_over(link: LinkageLink) -> Iterator[tuple[tuple[str, str], Beam, Array]]:
    """Beams over which a mass is distributed, with their densities, or all with density 1 if none has mass."""
    massive = _massive(link)
    for pair, beam in link.beams.items():
        assert isinstance(beam, Beam)
        yield pair, beam, np.asarray(beam.material.density if massive else 1.0)


@dataclass(frozen=True, eq=False)
class Massless(Composed):
    """An element without its mass."""

    def mass_matrix(self, length: Array) -> Array:
        """Zeros, (..., 12, 12)."""
        return np.zeros((*np.shape(length), 12, 12))

    def section_inertia(self, fraction: Array) -> Array:
        """Zeros, (..., 6)."""
        return np.zeros((*np.shape(fraction), 6))

    def mass_per_length(self, fraction: Array) -> Array:
        """Zeros, (...)."""
        return np.zeros(np.shape(fraction))


def without_mass(element: LineElement) -> LineElement:
    """The same element without its mass."""
    return _of_density(element, 0.0) if isinstance(element, Beam) else Massless(element)


def is_massive(element: LineElement) -> bool:
    """Whether an element has mass of its own."""
    if isinstance(element, Beam):
        return bool(np.any(np.asarray(element.material.density) > 0.0))
    return bool(np.any(element.mass_per_length(np.asarray(0.5)) > 0.0))


def _of_density(beam: Beam, density: Array | float) -> Beam:
    stuff = beam.material
    return replace(beam, material=Material(E=stuff.E, G=stuff.G, density=density))


def _of_density_one(link: LinkageLink) -> Mapping[tuple[str, str], LineElement | None]:
    """A massless link's beams with density 1, to place its centre of mass; without any `Beam`, None for each line."""
    beams = {pair: _of_density(each, 1.0) for pair, each in link.beams.items() if isinstance(each, Beam)}
    return beams or dict.fromkeys(link.beams)


def inertia(linkage: LinkageDescription, name: str) -> Inertia:
    """Inertia of a link: as far as given, otherwise that of its beams.

    A mass given alone is distributed as the beams are; without beams it is a point mass at the mean of the link's
    points. The result is cached until the link or its points change.
    """
    link = linkage.links[name]
    made_of = link, *(linkage.points[point] for point in link.points)
    known: dict[str, tuple[object, Inertia]] = INERTIAS.get(linkage) or {}
    if name not in known or not alike(known[name][0], made_of):
        known = known | {name: (made_of, _inertia(linkage, link))}
        INERTIAS.put(linkage, known)
    return known[name][1]


def _inertia(linkage: LinkageDescription, link: LinkageLink) -> Inertia:
    own = _of_beams(linkage, link)
    mass = link.mass if link.mass is not None else own.mass if _massive(link) else np.zeros(())
    centre = own.centre if link.centre is None else link.centre
    if link.inertia is not None:
        return Inertia(mass, centre, link.inertia)
    share = mass / np.where(own.mass > 0.0, own.mass, np.inf)
    return Inertia(mass, centre, share[..., None, None] * own.tensor)


def _of_beams(linkage: LinkageDescription, link: LinkageLink) -> Inertia:
    """Inertia of the beams as one rigid body: their consistent mass matrices in rigid motions, ``R^T M R``.

    Beams without mass are taken with density 1, which places the centre of mass.
    """
    at = places(linkage, link.name)
    if not link.beams:
        middle: Array = sum(at.values(), np.zeros(3)) / len(at)
        return Inertia(np.zeros(()), middle, np.zeros((3, 3)))
    elements = link.beams if _massive(link) else _of_density_one(link)
    total, first = np.zeros((6, 6)), at[link.points[0]]
    for pair, beam in elements.items():
        total = total + _rigid_mass(beam, at[pair[0]], at[pair[1]], first)
    mass = total[..., 0, 0]
    arm = np.stack([total[..., 5, 1], total[..., 3, 2], total[..., 4, 0]], axis=-1) / mass[..., None]
    turn = cross_matrix(arm)
    about = total[..., 3:, 3:] + mass[..., None, None] * (turn @ turn)
    tensor = 0.5 * (about + np.swapaxes(about, -1, -2))
    return Inertia(mass, first + arm, tensor)


def _massive(link: LinkageLink) -> bool:
    return any(map(is_massive, link.beams.values()))


def _rigid_mass(beam: LineElement | None, start: Array, end: Array, about: Array) -> Array:
    """Mass matrix (..., 6, 6) about the point `about` of a rigid beam, or of a uniform line of unit mass per length."""
    chord = end - start
    turn = default_axes(chord) if beam is None else beam.axes(chord)
    shape = np.broadcast_shapes(start.shape, end.shape, about.shape)[:-1]
    motion = np.zeros((*shape, 12, 6))
    for row, at in ((0, start), (6, end)):
        motion[..., row : row + 6, :] = carrying(at - about)
    local = block_diagonal([turn] * 4) @ motion
    length = np.linalg.norm(chord, axis=-1)
    mass = length[..., None, None] * _LINE if beam is None else beam.mass_matrix(length)
    out: Array = np.swapaxes(local, -1, -2) @ mass @ local
    return out
