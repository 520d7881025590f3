"""Forces and energy of motions of the unknowns, from deformations, so that rigid motions cause no cancellation."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Protocol

import numpy as np

from .deformations import Springs, on_nodes
from .kinematic_edge import Real, extended
from .kinematics import FrameKinematics


class Stiff(Protocol):
    """Members and links of a frame as springs; `stiffness` is that of the links, (..., 6)."""

    @property
    def kinematics(self) -> FrameKinematics: ...

    @property
    def springs(self) -> list[Springs]: ...

    @property
    def stiffness(self) -> list[Real]: ...


def displaced(frame: Stiff, unknowns: Sequence[int], motions: Real) -> tuple[Real, Real]:
    """Coordinates and displacements of the nodes in motions (motions, ..., n), (motions, ..., nodes, 6)."""
    none: list[Real | None] = [None] * len(frame.kinematics.links)
    coordinates = frame.kinematics.coordinates(unknowns, motions, none)
    return coordinates, frame.kinematics.displacements(coordinates)


def resisted(frame: Stiff, unknowns: Sequence[int], motions: Real) -> Real:
    """Forces on the unknowns that balance motions (motions, ..., n): the stiffness times these motions."""
    kinematics = frame.kinematics
    coordinates, moved = displaced(frame, unknowns, motions)
    acting = ((each, each.forces(each.stiffness * each.of(moved, coordinates))) for each in frame.springs)
    inner = on_nodes(extended(np.zeros((kinematics.count, 6))), acting)
    generalised_forces = [
        k * each for k, each in zip(frame.stiffness, kinematics.relative_displacements(coordinates, moved), strict=True)
    ]
    return kinematics.reduced(unknowns, kinematics.generalised(inner, generalised_forces))


def weighted(frame: Stiff, unknowns: Sequence[int], motions: Real) -> Iterator[Real]:
    """Deformations in motions (motions, ..., n) times the root of their stiffness, (motions, ...): their squares add up
    to twice the energy."""
    coordinates, moved = displaced(frame, unknowns, motions)
    for each in frame.springs:
        yield np.sqrt(each.stiffness) * each.of(moved, coordinates)
    for k, relative_displacement in zip(
        frame.stiffness, frame.kinematics.relative_displacements(coordinates, moved), strict=True
    ):
        yield np.sqrt(k) * relative_displacement
