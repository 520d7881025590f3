"""Mass, centre of mass and inertia of links: as given, or of their beams."""

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

# Consistent mass of an even line of unit mass and length.
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
        Inertia about the centre of mass, in global axes then, (..., 3, 3).
    """

    mass: Array
    centre: Array
    tensor: Array


def is_given(link: LinkageLink) -> bool:
    """Whether the link was given where its mass is, so that its beams have none of their own.

    A mass alone is spread as that of the beams is; see `beams_with_mass`.
    """
    placed = link.centre is not None or link.inertia is not None
    return placed or (link.mass is not None and not _is_spread(link))


def _is_spread(link: LinkageLink) -> bool:
    """Whether the beams carry a mass that was given alone."""
    return bool(link.beams) and all(isinstance(beam, Beam) for beam in link.beams.values())


def beams_with_mass(linkage: LinkageDescription, link: LinkageLink) -> Mapping[tuple[str, str], LineElement]:
    """The beams of a link in the frame: without mass where that was placed, with all of it where it was given alone."""
    if is_given(link):
        return {pair: without_mass(beam) for pair, beam in link.beams.items()}
    if link.mass is None:
        return link.beams
    own = _of_beams(linkage, link).mass
    share = link.mass / np.where(own > 0.0, own, np.inf)
    return {pair: _of_density(beam, share * density) for pair, beam, density in _spread_over(link)}


def _spread_over(link: LinkageLink) -> Iterator[tuple[tuple[str, str], Beam, Array]]:
    """Beams over which a mass is spread, and their densities; where none has one, alike."""
    massive = _massive(link)
    for pair, beam in link.beams.items():
        assert isinstance(beam, Beam)
        yield pair, beam, np.asarray(beam.material.density if massive else 1.0)


@dataclass(frozen=True, eq=False)
class Massless(Composed):
    """An element without its mass."""

    def mass_matrix(self, length: Array) -> Array:
        """None, (..., 12, 12)."""
        return np.zeros((*np.shape(length), 12, 12))

    def section_inertia(self, fraction: Array) -> Array:
        """None, (..., 6)."""
        return np.zeros((*np.shape(fraction), 6))

    def mass_per_length(self, fraction: Array) -> Array:
        """None, (...)."""
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
    """What tells where a link's mass would be: its beams of a density of one; without any, even lines, None."""
    beams = {pair: _of_density(each, 1.0) for pair, each in link.beams.items() if isinstance(each, Beam)}
    return beams or dict.fromkeys(link.beams)


def inertia(linkage: LinkageDescription, name: str) -> Inertia:
    """Inertia of a link: what was given, and for the rest that of its beams.

    Where a mass was given alone, the beams tell where it is and how it is spread; where there are no beams it is a
    point mass in the middle of the link's points. It is found once, as long as the link and its points stay.
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
    """Inertia of the beams moving as one body: their consistent mass on rigid motions, ``R^T M R``.

    Where they have no mass they are taken with a density of one, to tell where it would be.
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
    """Mass matrix (..., 6, 6) of a beam, or of an even line of unit mass, that moves with the point `about`."""
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
