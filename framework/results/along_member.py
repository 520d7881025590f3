"""Results at stations along a member, which may lie on any of the pieces into which it is divided.

Here the axis of the k stations comes first, (k, ...), before the batch axes.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array, Shape, aligned, finite, joined
from ..errors import FrameError
from ..structure.topology import Group, Topology

# A function of a piece's number and of distances (k, ...) from its start that returns a field there.
Field = Callable[[int, Array], Array]


class GroupedPieces:
    """The group of each piece, and its position there.

    Parameters
    ----------
    topology
        The numbered frame.
    """

    def __init__(self, topology: Topology) -> None:
        self.topology = topology

    def group(self, piece: int) -> tuple[Group, int]:
        """The group of a piece, and its position in that."""
        number, position = self.placed[piece]
        return self.topology.groups[number], position

    @cached_property
    def placed(self) -> dict[int, tuple[int, int]]:
        """For each piece the number of its group, and its position in that."""
        groups = enumerate(self.topology.groups)
        return {piece: (k, position) for k, group in groups for position, piece in enumerate(group.pieces.tolist())}


class AlongMembers(GroupedPieces, ABC):
    """Forces, stress and displacement along members, from those in their pieces.

    Parameters
    ----------
    topology
        The numbered frame.
    """

    @abstractmethod
    def internal(self, piece: int, x: Array) -> Array:
        """Internal forces at stations of a piece, (k, ..., 6)."""

    @abstractmethod
    def moved(self, piece: int, x: Array) -> Array:
        """Displacement at stations of a piece in global axes, (k, ..., 6)."""

    def forces(self, member: str, at: Array) -> Array:
        """Internal forces at stations, (..., k, 6)."""
        return self.along(member, at, self.internal)

    def stress(self, member: str, at: Array) -> Array:
        """Extreme stresses at stations, (..., k, 3)."""

        def stress(piece: int, x: Array) -> Array:
            group, position = self.group(piece)
            return group.of(position).stress(x / group.length[position], self.internal(piece, x))

        return self.along(member, at, stress)

    def displacement_along(self, member: str, at: Array) -> Array:
        """Displacement at stations in global axes, (..., k, 6)."""
        return self.along(member, at, self.moved)

    def along(self, member: str, at: Array, field: Field) -> Array:
        """A field at stations (..., k) on a member, (..., k, n)."""
        pieces, shape = self.topology.pieces_of[member], self.topology.frame.shape
        whole = self.topology.frame.length(member)
        check_stations(member, at, whole, shape)
        # Where lengths vary over the batch, the piece on which a station lies may vary as well.
        fraction = aligned(at / whole[..., None], len(shape), 1)
        which = np.moveaxis(np.minimum((fraction * len(pieces)).astype(int), len(pieces) - 1), -1, 0)
        stations = np.moveaxis(np.broadcast_to(at, fraction.shape), -1, 0)

        def inside(index: int) -> Array:
            group, position = self.group(pieces[index])
            length = group.length[position]
            return field(pieces[index], np.clip(stations - index * length, 0.0, length))

        first, *others = np.unique(which).tolist() or [0]
        out = inside(first)
        for index in others:
            out = np.where((which == index)[..., None], inside(index), out)
        full: Array = np.broadcast_to(out, (len(stations), *shape, out.shape[-1]))
        return np.array(np.moveaxis(full, 0, -2))


def check_stations(member: str, at: ArrayLike, length: Array, batch: Shape) -> None:
    """Refuse stations (..., k) that are not on a member of a length (...), or do not broadcast with the batch."""
    what = f"at of member {member!r}"
    stations = finite(at, what)
    if not stations.size:
        raise FrameError(f"{what} is empty: give one distance from its start at least")
    if joined(what, stations.shape[:-1], {"the frame": batch}) != batch:
        raise FrameError(
            f"{what} has batch shape {stations.shape[:-1]}, but that of the frame is {batch}: give (..., k)"
        )
    if np.any(stations < 0.0) or np.any(stations > length[..., None] * (1.0 + 1e-9)):
        text = f"give distances from 0 to its length {float(length.min()):.6g}"
        raise FrameError(f"stations {stations.tolist()} on member {member!r}: {text}")
