"""Points, axes and masses of a linkage in its reference configuration, in which files describe it."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..kinematics.extent import extent
from ..poses.coordinates import coordinate_of
from ..poses.kinematics import Kinematics
from ..statics.inertia import inertia

# Least moment of inertia of a body, as a share of its mass times the linkage's size squared, and mass of a body without
# one, as a share of the total mass: small enough for results to nine digits.
SLENDER = 1e-12
WEIGHTLESS = 1e-10
# Moment of inertia of a body without mass, as that share of its substitute mass.
ROUND = 1e-2
# Least mass and moment of inertia, twice the least that MuJoCo accepts.
LEAST = 2e-15


@dataclass(frozen=True, eq=False)
class BodyMass:
    """Mass, centre of mass (3,) and inertia about it (3, 3), in global axes.

    `is_own` is False for a small substitute of a mass that the description does not have.
    """

    mass: float
    centre: Array
    tensor: Array
    is_own: bool

    def part(self, count: int) -> BodyMass:
        """One of `count` equal parts, all with the same centre of mass."""
        return BodyMass(self.mass / count, self.centre, self.tensor / count, self.is_own)


class Placed:
    """A linkage in its reference configuration; assembled anew if links have a given length.

    Parameters
    ----------
    linkage
        The description, of a single linkage.

    Raises
    ------
    FrameError
        If the description has a batch, or cannot be assembled.
    """

    def __init__(self, linkage: LinkageDescription) -> None:
        if linkage.shape:
            raise FrameError(f"the linkage carries a batch of shape {linkage.shape}: describe one, as a file has one")
        self.linkage = linkage
        self.motion = None
        if any(link.length is not None for link in linkage.links.values()):
            self.motion = Kinematics.of(linkage, {}, {}, {})

    @cached_property
    def size(self) -> float:
        """Diagonal of the linkage's bounding box; 1 if all its points coincide."""
        return float(extent(self.linkage))

    def place(self, link: str, point: str) -> Array:
        """Position of a point of a link, (3,)."""
        if self.motion is None or link == GROUND:
            return self.linkage.points[point]
        return self.motion.position(point, link)

    def axes(self, pair: Pair) -> Array:
        """Axes of a joint on its first link as columns, (3, 3); x of a universal joint is on its second link."""
        if self.motion is None:
            return single(pair.axes, 2, f"axis of joint {pair.name!r}")
        first, second = (self.motion.axes(link) @ pair.axes for link in (pair.first, pair.second))
        return np.column_stack([second[:, 0], first[:, 1:]]) if pair.kind.name == "universal" else first

    def coordinates(self, pair: Pair) -> Array:
        """Coordinates of a joint, (f,)."""
        if self.motion is None:
            return single(pair.reference, 1, f"reference of joint {pair.name!r}")
        return coordinate_of(self.motion, pair)

    @cached_property
    def masses(self) -> dict[str, BodyMass]:
        """By link: its mass, or a small substitute."""
        given = {name: self._mass(name) for name in self.linkage.links}
        light = WEIGHTLESS * sum(each.mass for each in given.values()) or self._loaded or 1.0
        return {name: self._at_least(each, light) for name, each in given.items()}

    @property
    def _loaded(self) -> float:
        """Mass that the largest force on the linkage accelerates by ten, about as much as gravity in SI units."""
        forces = (np.linalg.norm(load.value[..., :3], axis=-1) for load in self.linkage.loads)
        return max((float(np.max(force)) for force in forces), default=0.0) / 10.0

    def _mass(self, link: str) -> BodyMass:
        found = inertia(self.linkage, link)
        mass = float(single(found.mass, 0, f"mass of link {link!r}"))
        centre = single(found.centre, 1, f"centre of link {link!r}")
        tensor = single(found.tensor, 2, f"inertia of link {link!r}")
        if self.motion is not None:
            axes = self.motion.axes(link)
            centre, tensor = self.motion.position_on(link, centre), axes @ tensor @ axes.T
        return BodyMass(mass, centre, tensor, mass > 0.0 or bool(tensor.any()))

    def _at_least(self, own: BodyMass, light: float) -> BodyMass:
        """The mass, raised to the least mass and inertia that programs of rigid-body dynamics accept.

        Principal moments below the least are raised, and the two smaller ones until no moment is above the sum of the
        others. A link with an inertia about z alone becomes a plate.
        """
        mass = max(own.mass or light, LEAST)
        moments, axes = np.linalg.eigh(own.tensor)
        least = np.maximum(moments, max((SLENDER if own.is_own else ROUND) * mass * self.size**2, LEAST))
        least[:2] += 0.5 * max(0.0, (1.0 + SLENDER) * least[2] - least[0] - least[1])
        if np.array_equal(least, moments):
            return BodyMass(mass, own.centre, own.tensor, own.is_own)
        return BodyMass(mass, own.centre, own.tensor + (axes * (least - moments)) @ axes.T, own.is_own)


def single(value: Array, trailing: int, what: str) -> Array:
    """A number with `trailing` axes of components, as an array.

    Raises
    ------
    FrameError
        If it has a batch.
    """
    given = np.asarray(value, dtype=np.float64)
    batch = given.shape[: given.ndim - trailing]
    if batch:
        raise FrameError(f"{what} carries a batch of shape {batch}: give one number, as a file has one linkage")
    return given
