"""Derivatives of the position of a point by a linkage's dimensions, its drives, and displacements in its joints."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.batch import Array
from ....framework.errors import FrameError
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, Pair
from ..description.sketch import place
from ..kinematics.dimensions import six_units
from ..poses.classified import ClassifiedPoses
from .virtual_work import VirtualWork

Place = tuple[str, str]


@dataclass(frozen=True, eq=False, repr=False)
class PositionSensitivity:
    """Derivatives of the position and orientation of a point by a linkage's dimensions; made by `Motion.sensitivity`.

    Drives are locked, links and joints rigid. The rows are ``ux uy uz rx ry rz``: displacement of the point, and
    rotation of its link. All are NaN where the pose is not assembled or is a dead point. For an overconstrained linkage
    they are those of the position with the least gap, which `Linkage.move` finds.

    Attributes
    ----------
    motion
        The motion of the linkage, (...).
    point, link
        The point, and the link on which it lies.
    joints
        By joint: derivatives by a displacement and rotation of its second link relative to its place in the ideal
        joint, in the joint's axes about its point on the second link, (..., 6, 6); 0 in the joint's free directions.
    """

    motion: ClassifiedPoses
    point: str
    link: str
    joints: dict[str, Array]

    def __repr__(self) -> str:
        return f"<Sensitivity of {self.point} on {self.link} to {', '.join(self.joints)}, shape {self.motion.shape}>"

    @property
    def rows(self) -> int:
        """Number of rows: six, and one for each redundant constraint in `with_redundant_rows`."""
        return next((value.shape[-2] for value in self.joints.values()), 6)

    @property
    def linkage(self) -> LinkageDescription:
        """Description of the linkage."""
        return self.motion.linkage

    @cached_property
    def drives(self) -> dict[str, Array]:
        """By driven joint: derivatives by the values of its f driven coordinates, (..., 6, f).

        For a spherical joint these are rotations about the joint's axes on its first link.
        """
        out = {}
        for name, components in self.linkage.drives.items():
            found = self.joints[name][..., [COMPONENTS.index(component) for component in components]]
            pitch = self.linkage.joint(name).pitch
            if pitch is not None:
                found = found + self.joints[name][..., [2]] * (pitch / (2.0 * np.pi))[..., None, None]
            out[name] = found
        return out

    @cached_property
    def places(self) -> dict[Place, Array]:
        """By link and point: derivatives by a shift of the point on that link alone, (..., 6, 3).

        The shift is in global axes in the reference configuration. Links have all of their points, ``"ground"`` those
        of its joints.
        """
        points = {(link, point): 0.0 for link, of in self.linkage.links.items() for point in of.points}
        out: dict[Place, Array | float] = dict(points)
        for pair in self.linkage.joints.values():
            for link, sign in ((pair.first, 1.0), (pair.second, -1.0)):
                by = sign * self.joints[pair.name][..., :3] @ self._rotated(pair, link)
                out[link, pair.point] = out.get((link, pair.point), 0.0) + by
        none = np.zeros((*self.motion.shape, self.rows, 3))
        own = (self.link, self.point)
        if own in out or self.link == GROUND:
            unit = none.copy()
            unit[..., :3, :] = self.motion.axes(self.link)
            out[own] = out.get(own, 0.0) + unit
        return {key: none + value for key, value in out.items()}

    @cached_property
    def points(self) -> dict[str, Array]:
        """By point: derivatives by a shift of it in the reference configuration, on all its links, (..., 6, 3).

        A link with a given length keeps it.
        """
        out = {point: np.zeros((*self.motion.shape, self.rows, 3)) for point in self.linkage.points}
        for (link, point), value in self.places.items():
            given = self.linkage.links.get(link)
            if given is None or given.length is None or point == given.points[0]:
                out[point] = out[point] + value
                continue
            start = given.points[0]
            along, drawn = self._chord(link, start, point)
            across = np.eye(3) - along[..., :, None] * along[..., None, :]
            across = across * (given.length / drawn)[..., None, None]
            out[point] = out[point] + value @ across
            out[start] = out[start] + value @ (np.eye(3) - across)
        return out

    @cached_property
    def lengths(self) -> dict[str, Array]:
        """By link of two points: derivatives by its length, the second point moving away from the first, (..., 6)."""
        two = [(name, link.points) for name, link in self.linkage.links.items() if len(link.points) == 2]
        return {name: self.length(name, *points) for name, points in two}

    @cached_property
    def axes(self) -> dict[Place, Array]:
        """By link and joint: derivatives by a small rotation of the joint's axes on that link alone, (..., 6, 3).

        The rotation vector is in global axes in the reference configuration; the joint's point does not move. For a
        rotation of the axes on both links, add both derivatives.
        """
        out = {}
        for pair in self.linkage.joints.values():
            by = self.joints[pair.name]
            here, there = (self.motion.position(pair.point, link) for link in (pair.first, pair.second))
            # a rotation on the first link moves the second link about the joint's point on the first
            arm = np.cross(self._to_joint(pair, there - here)[..., None, :], by[..., :3])
            out[pair.first, pair.name] = (by[..., 3:] + arm) @ self._rotated(pair, pair.first)
            out[pair.second, pair.name] = -by[..., 3:] @ self._rotated(pair, pair.second)
        return out

    @cached_property
    def pitches(self) -> dict[str, Array]:
        """By screw joint: derivatives by its pitch, (..., 6)."""
        out = {}
        for name, pair in self.linkage.joints.items():
            if pair.pitch is not None:
                rotated = self.motion.assembly.state[self.motion.mechanism.states[name].start]
                turns = np.broadcast_to(rotated, self.motion.shape) / (2.0 * np.pi)
                out[name] = self.joints[name][..., 2] * turns[..., None]
        return out

    def length(self, link: str, start: str, end: str) -> Array:
        """Derivative by the distance of two points of a link, of which the second moves, on that link alone.

        Parameters
        ----------
        link
            Name of the link, or ``"ground"``.
        start, end
            Names of two of its points.

        Returns
        -------
        ndarray
            Derivatives of ``ux uy uz rx ry rz`` by the length, (..., 6).

        Raises
        ------
        FrameError
            If the link does not have both points, or they coincide.

        Examples
        --------
        The end of an arm moves along the arm as it gets longer.

        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(3, 4))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.move().sensitivity("B").length("arm", "A", "B").round(12).tolist()
        [0.6, 0.8, 0.0, 0.0, 0.0, 0.0]
        """
        for point in (start, end):
            if (link, point) not in self.places:
                known = ", ".join(other for owner, other in self.places if owner == link) or "none"
                raise FrameError(f"link {link!r} has no point {point!r} here: choose of {known}")
        along, _ = self._chord(link, start, end)
        return np.asarray(np.sum(self.places[link, end] * along[..., None, :], axis=-1))

    def _chord(self, link: str, start: str, end: str) -> tuple[Array, Array]:
        """Unit vector (..., 3) from a point of a link to another in the reference configuration, and their distance."""
        chord = self.linkage.points[end] - self.linkage.points[start]
        if link != GROUND and self.linkage.links[link].length is None:
            chord = place(self.linkage, link, end) - place(self.linkage, link, start)
        distance = np.asarray(np.linalg.norm(chord, axis=-1))
        if np.any(distance == 0.0):
            raise FrameError(f"points {start!r} and {end!r} of link {link!r} coincide: name two that are apart")
        return chord / distance[..., None], distance

    def _rotated(self, pair: Pair, link: str) -> Array:
        """Rotation from global axes in the reference configuration of a link to a joint's present axes, (..., 3, 3)."""
        return np.asarray(np.swapaxes(self.motion.joint_axes(pair.name), -1, -2) @ self.motion.axes(link))

    def _to_joint(self, pair: Pair, vector: Array) -> Array:
        return np.asarray((vector[..., None, :] @ self.motion.joint_axes(pair.name))[..., 0, :])


def position_sensitivity(motion: ClassifiedPoses, point: str, link: str | None = None) -> PositionSensitivity:
    """Derivatives of the position of a point and of its link's orientation; see `Motion.sensitivity`."""
    name, _ = motion.linkage.end(point if link is None else (link, point), "the motion")
    work = VirtualWork(motion)
    if name == GROUND:
        none = {joint: np.zeros((*motion.shape, 6, 6)) for joint in motion.linkage.joints}
        return PositionSensitivity(motion, point, name, none)
    forces = work.joint_forces({name: work.at_point(motion.position(point, name))})
    return PositionSensitivity(
        motion, point, name, {joint: by_units(work, forces[joint]) for joint in sorted_as(motion, forces)}
    )


def with_redundant_rows(by: PositionSensitivity) -> PositionSensitivity:
    """Add a row for each redundant constraint: derivatives of the gap in it, a length.

    They are NaN where the pose is not regular, as other constraints are redundant there.
    """
    work = VirtualWork(by.motion)
    if not work.redundant:
        return by
    units = six_units(1.0, work.mechanism.size)[..., None, :]
    regular = work.regular[..., None, None]
    rows = {joint: np.where(regular, force * units, np.nan) for joint, force in work.self_stresses().items()}
    joints = {joint: np.concatenate([value, rows[joint]], axis=-2) for joint, value in by.joints.items()}
    return PositionSensitivity(by.motion, by.point, by.link, joints)


def by_units(work: VirtualWork, force: Array) -> Array:
    """Derivatives in the user's units, NaN where the pose is not regular.

    `force` (..., 6, 6) has them with lengths in units of the linkage's size.
    """
    size = work.mechanism.size
    lengths, angles = six_units(size, 1.0), six_units(1.0 / size, 1.0)
    return np.where(work.regular[..., None, None], force * lengths[..., :, None] * angles[..., None, :], np.nan)


def sorted_as(motion: ClassifiedPoses, forces: dict[str, Array]) -> Iterator[str]:
    """Joints in the order of the description."""
    return (name for name in motion.linkage.joints if name in forces)
