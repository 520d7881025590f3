"""Mass, centre of mass and inertia of links: as given, or of their beams."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ....elements import Beam, Material
from ....framework.batch import Array, block_diagonal
from ..description.linkage_description import LinkageDescription
from ..description.parts import LinkageLink
from ..description.places import place


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
    """Whether the link was given its inertia, so that its beams have none of their own."""
    return any(value is not None for value in (link.mass, link.centre, link.inertia))


def with_density(beam: Beam, density: float) -> Beam:
    """The same beam of another density."""
    stuff = beam.material
    return replace(beam, material=Material(E=stuff.E, G=stuff.G, density=density))


def inertia(linkage: LinkageDescription, name: str) -> Inertia:
    """Inertia of a link: what was given, and for the rest that of its beams.

    Where a mass was given alone, the beams tell where it is and how it is spread; where there are no beams it is a
    point mass in the middle of the link's points. It is found once, as long as the link and its points stay.
    """
    link = linkage.links[name]
    made_of = link, *(linkage.points[point] for point in link.points)
    kept = linkage.inertias.get(name)
    if kept is None or any(old is not new for old, new in zip(kept[0], made_of, strict=False)):
        kept = linkage.inertias[name] = made_of, _inertia(linkage, link)
    found: Inertia = kept[1]
    return found


def _inertia(linkage: LinkageDescription, link: LinkageLink) -> Inertia:
    own = _of_beams(linkage, link)
    mass = link.mass if link.mass is not None else own.mass if _massive(link) else np.zeros(())
    centre = own.centre if link.centre is None else link.centre
    if link.inertia is not None:
        return Inertia(mass, centre, link.inertia)
    share = mass / np.where(own.mass > 0.0, own.mass, np.inf)
    return Inertia(mass, centre, share[..., None, None] * own.tensor)


def cross_matrix(vector: Array) -> Array:
    """The matrix S with ``S x = vector x x``, (..., 3, 3)."""
    x, y, z = np.moveaxis(vector, -1, 0)
    zero = np.zeros_like(x)
    rows = ((zero, -z, y), (z, zero, -x), (-y, x, zero))
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def _of_beams(linkage: LinkageDescription, link: LinkageLink) -> Inertia:
    """Inertia of the beams moving as one body: their consistent mass on rigid motions, ``R^T M R``.

    Where they have no mass they are taken with a density of one, to tell where it would be.
    """
    places = [place(linkage, link.name, point) for point in link.points]
    if not link.beams:
        middle: Array = sum(places, np.zeros(3)) / len(places)
        return Inertia(np.zeros(()), middle, np.zeros((3, 3)))
    massive = _massive(link)
    total = np.zeros((6, 6))
    for pair, beam in link.beams.items():
        start, end = (place(linkage, link.name, point) for point in pair)
        total = total + _rigid_mass(beam if massive else with_density(beam, 1.0), start, end, places[0])
    mass = total[..., 0, 0]
    arm = np.stack([total[..., 5, 1], total[..., 3, 2], total[..., 4, 0]], axis=-1) / mass[..., None]
    turn = cross_matrix(arm)
    about = total[..., 3:, 3:] + mass[..., None, None] * (turn @ turn)
    tensor = 0.5 * (about + np.swapaxes(about, -1, -2))
    return Inertia(mass, places[0] + arm, tensor)


def _massive(link: LinkageLink) -> bool:
    return any(np.any(np.asarray(beam.material.density) > 0.0) for beam in link.beams.values())


def _rigid_mass(beam: Beam, start: Array, end: Array, about: Array) -> Array:
    """Mass matrix (..., 6, 6) of a beam that moves with the point `about`."""
    chord = end - start
    turn = beam.axes(chord)
    shape = np.broadcast_shapes(start.shape, end.shape, about.shape)[:-1]
    motion = np.zeros((*shape, 12, 6))
    for row, at in ((0, start), (6, end)):
        motion[..., row : row + 3, :3] = motion[..., row + 3 : row + 6, 3:] = np.eye(3)
        motion[..., row : row + 3, 3:] = -cross_matrix(at - about)
    local = block_diagonal([turn] * 4) @ motion
    mass = beam.mass_matrix(np.linalg.norm(chord, axis=-1))
    out: Array = np.swapaxes(local, -1, -2) @ mass @ local
    return out
