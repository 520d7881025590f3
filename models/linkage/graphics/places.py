"""Positions and axes of a linkage in one figure: in its reference configuration, or at a pose of a motion."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape, one_entry
from ....framework.errors import FrameError
from ....framework.graphics.scene import FLAT, LoadArrow, beside
from ....framework.protocol import LineElement
from ..description.linkage_description import LinkageDescription

# Ratio to the largest speed of a point below which a point counts as at rest.
MOVES = 1e-6
FREE_TEXT = "arrows: free motion, drives locked"


class DrawnPlaces(Protocol):
    """Positions, joint axes and rotations of a linkage in one figure."""

    @property
    def linkage(self) -> LinkageDescription:
        """Description of the linkage."""

    def position(self, point: str, link: str | None = None) -> Array:
        """Position of a point of a link, (3,)."""

    def axes(self, joint: str) -> Array:
        """Axes of a joint as columns, (3, 3)."""

    def rotated(self, link: str, vector: Array) -> Array:
        """A vector (..., 3) that is fixed to a link and given in the reference configuration, (3,)."""

    def value(self, array: Array, trailing: int) -> Array:
        """Entry of an array that may vary over the batch; its last `trailing` axes remain."""


def beam_axes(places: DrawnPlaces, ends: tuple[str, str], beam: LineElement) -> Array:
    """Axes of a beam between two points in the reference configuration, as rows, (3, 3)."""
    drawn = places.linkage.points
    return places.value(np.asarray(beam.axes(drawn[ends[1]] - drawn[ends[0]]), dtype=float), 2)


class PosesInRow(Protocol):
    """A batch of poses, of which some may not be assembled."""

    @property
    def shape(self) -> Shape:
        """Batch shape."""

    @property
    def is_assembled(self) -> NDArray[np.bool_]:
        """Which poses are assembled, (...)."""

    @property
    def closure_status(self) -> NDArray[np.str_]:
        """Why the others are not assembled, (...)."""


class DrawnPoses(PosesInRow, Protocol):
    """The part of a batch of poses that figures need; `ClassifiedPoses` has more."""

    @property
    def linkage(self) -> LinkageDescription:
        """Description of the linkage."""

    def position(self, point: str, link: str | None = None) -> Array:
        """Position of a point of a link, (..., 3)."""

    def joint_axes(self, joint: str) -> Array:
        """Axes of a joint as columns, (..., 3, 3)."""

    def axes(self, link: str) -> Array:
        """Rotation of a link from the reference configuration, (..., 3, 3)."""

    def origin(self, link: str) -> Array:
        """Position of the link's point that is at the global origin in the reference configuration, (..., 3)."""

    def free_velocity(self, point: str, link: str | None = None) -> Array:
        """Velocity of a point in the free motion with locked drives, (..., 3); zero if there is none."""


@dataclass(frozen=True, eq=False)
class ReferencePoses:
    """Linkages of a batch as poses, each in its reference configuration, whether singular or not."""

    linkage: LinkageDescription

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.linkage.shape

    @property
    def is_assembled(self) -> NDArray[np.bool_]:
        """True for all, (...)."""
        return np.ones(self.shape, dtype=bool)

    @property
    def closure_status(self) -> NDArray[np.str_]:
        """``"regular"`` for all, (...)."""
        return np.full(self.shape, "regular")

    def position(self, point: str, link: str | None = None) -> Array:
        """See `DrawnPoses`; in the reference configuration a point has one position for all its links."""
        if point not in self.linkage.points:
            known = ", ".join(self.linkage.points)
            raise FrameError(f"the linkage has no point {point!r}: choose one of {known}")
        return np.broadcast_to(self.linkage.points[point], (*self.shape, 3))

    def joint_axes(self, joint: str) -> Array:
        """See `DrawnPoses`."""
        return self.linkage.joints[joint].axes

    def axes(self, link: str) -> Array:
        """See `DrawnPoses`."""
        return np.broadcast_to(np.eye(3), (*self.shape, 3, 3))

    def origin(self, link: str) -> Array:
        """See `DrawnPoses`."""
        return np.zeros((*self.shape, 3))

    def free_velocity(self, point: str, link: str | None = None) -> Array:
        """See `DrawnPoses`; zero, as it is not computed here."""
        return np.zeros((*self.shape, 3))


@dataclass(frozen=True, eq=False)
class ReferencePlaces:
    """The reference configuration of a linkage, at one entry of its batch by flat index."""

    linkage: LinkageDescription
    entry: int = 0

    def position(self, point: str, link: str | None = None) -> Array:
        """See `DrawnPlaces`; in the reference configuration a point has one position for all its links."""
        return self.value(self.linkage.points[point], 1)

    def axes(self, joint: str) -> Array:
        """See `DrawnPlaces`."""
        return self.value(self.linkage.joints[joint].axes, 2)

    def rotated(self, link: str, vector: Array) -> Array:
        """See `DrawnPlaces`."""
        return self.value(vector, 1)

    def value(self, array: Array, trailing: int) -> Array:
        """See `DrawnPlaces`."""
        return at_entry(array, self.linkage.shape, self.entry, trailing)

    @property
    def flat(self) -> tuple[int, int] | None:
        """The plane in which the linkage lies and to which its pins are perpendicular; None if there is none."""
        points = np.array([self.position(point) for point in self.linkage.points]).reshape(-1, 3)
        size = float(np.ptp(points, axis=0).max(initial=0.0)) or 1.0
        turning = [j for j in self.linkage.joints.values() if j.kind.name in ("revolute", "planar")]
        for across in (2, 1, 0):
            leaning = [abs(abs(self.axes(joint.name)[across, 2]) - 1.0) for joint in turning]
            if np.ptp(points[:, across], axis=None) <= FLAT * size and max(leaning, default=0.0) <= FLAT:
                return beside(across)
        return None


@dataclass(frozen=True, eq=False)
class PosePlaces:
    """A pose of a motion, by its flat index."""

    motion: DrawnPoses
    entry: int

    @property
    def linkage(self) -> LinkageDescription:
        """Description of the linkage."""
        return self.motion.linkage

    def position(self, point: str, link: str | None = None) -> Array:
        """See `DrawnPlaces`."""
        return self.value(self.motion.position(point, link), 1)

    def axes(self, joint: str) -> Array:
        """See `DrawnPlaces`."""
        return self.value(self.motion.joint_axes(joint), 2)

    def rotated(self, link: str, vector: Array) -> Array:
        """See `DrawnPlaces`."""
        return np.asarray(self.value(self.motion.axes(link), 2) @ self.value(vector, 1))

    def value(self, array: Array, trailing: int) -> Array:
        """See `DrawnPlaces`."""
        return at_entry(array, self.motion.shape, self.entry, trailing)


def at_entry(array: Array, shape: Shape, entry: int, trailing: int) -> Array:
    """Entry of an array, by its flat index in the batch `shape`; the first along axes that the batch does not have."""
    batch, own = array.shape[: array.ndim - trailing], array.shape[array.ndim - trailing :]
    full = np.broadcast_shapes(shape, batch)
    index = np.unravel_index(entry, shape) if shape else ()
    chosen = [0] * (len(full) - len(shape)) + [int(k) for k in index]
    inside = tuple(k if k < n else 0 for k, n in zip(chosen, full, strict=True))
    return np.asarray(np.broadcast_to(array, (*full, *own))[inside])


def free_arrows(motion: DrawnPoses, entry: int) -> list[LoadArrow]:
    """Arrows of the free motion with locked drives at a pose, by its flat index; none if there is no free motion."""
    places = PosePlaces(motion, entry)
    found = []
    for link in motion.linkage.links.values():
        for point in link.points:
            way = places.value(motion.free_velocity(point, link.name), 1)
            found.append(LoadArrow(places.position(point, link.name), np.nan_to_num(way), ""))
    most = max((float(np.linalg.norm(each.force)) for each in found), default=0.0)
    moving = [each for each in found if np.linalg.norm(each.force) > MOVES * most]
    seen = {tuple(np.round([*each.at, *(each.force / most)], 6)): each for each in moving}
    return [LoadArrow(each.at, each.force / most, "") for each in seen.values()]


def assembled_of(motion: PosesInRow, series: Sequence[int]) -> list[int]:
    """The assembled poses among `series`, by flat index."""
    there = np.broadcast_to(motion.is_assembled, motion.shape).reshape(-1)
    return [number for number in series if there[number]]


def rows_of(motion: PosesInRow, values: Array) -> Array:
    """Values (..., k) of all poses with one batch axis, (poses, k)."""
    return np.broadcast_to(values, (*motion.shape, values.shape[-1])).reshape(-1, values.shape[-1])


def series_of(motion: PosesInRow, pose: int | tuple[int, ...] | None) -> tuple[list[int], int]:
    """Flat indices of the poses along the longest batch axis, and of the one that is drawn.

    Parameters
    ----------
    motion
        The motion.
    pose
        Index of the pose drawn; the first assembled one of the series if None.

    Raises
    ------
    FrameError
        If there is no such pose, or it or all poses are not assembled.
    """
    shape = motion.shape
    numbers = np.arange(int(np.prod(shape))).reshape(shape)
    there = np.broadcast_to(motion.is_assembled, shape)
    if not there.any():
        raise FrameError("no pose of the motion is assembled, so there is nothing to draw: motion.status says why")
    if not shape:
        return [0], 0
    axis = int(np.argmax(shape))
    given = None if pose is None else one_entry(shape, pose, "the figure of the motion")
    others = [0] * len(shape) if given is None else list(given)
    row = numbers[tuple(slice(None) if k == axis else others[k] for k in range(len(shape)))]
    if given is not None and not there[given]:
        raise FrameError(f"pose {pose} cannot be drawn, it is {np.broadcast_to(motion.closure_status, shape)[given]}")
    if given is not None:
        return row.tolist(), int(numbers[given])
    found = np.flatnonzero(there.reshape(-1)[row])
    return row.tolist(), int(row[found[0]] if len(found) else numbers.reshape(-1)[np.flatnonzero(there)[0]])
