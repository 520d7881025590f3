"""How the position of a point depends on the dimensions of a linkage, its drives, and displacements in its joints."""

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
from ..poses.classified import ClassifiedPoses
from .virtual_work import VirtualWork

Place = tuple[str, str]


@dataclass(frozen=True, eq=False, repr=False)
class PositionSensitivity:
    """Derivatives of the position and orientation of a point by what the linkage is made of; by `Motion.sensitivity`.

    Drives are locked, links and joints rigid. The rows are ``ux uy uz rx ry rz``: displacement of the point, and
    rotation of its link. All are NaN where the pose is not assembled or is a dead point. Of an overconstrained linkage
    they are those of the position with the least gap, as `Linkage.move` has it.

    Attributes
    ----------
    motion
        Where the linkage is, (...).
    point, link
        The point, and the link on which it is taken.
    joints
        By joint: by a displacement and rotation of its second link relative to where the joint would have it, in the
        joint's axes about its point on the second link, (..., 6, 6); 0 in what the joint leaves free.
    """

    motion: ClassifiedPoses
    point: str
    link: str
    joints: dict[str, Array]

    def __repr__(self) -> str:
        return f"<Sensitivity of {self.point} on {self.link} to {', '.join(self.joints)}, shape {self.motion.shape}>"

    @property
    def rows(self) -> int:
        """Number of rows: six, and one for each redundant constraint that is looked at."""
        return next((value.shape[-2] for value in self.joints.values()), 6)

    @property
    def linkage(self) -> LinkageDescription:
        """The description."""
        return self.motion.linkage

    @cached_property
    def drives(self) -> dict[str, Array]:
        """By driven joint: by the values of its f driven coordinates, (..., 6, f).

        Of a ball by rotations about the joint's axes on its first link.
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
        """By link and point: by a shift of the point on that link alone, in the reference configuration, (..., 6, 3).

        Links are named with all of their points, ``"ground"`` with those of its joints.
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
        """By point: by a shift of it in the reference configuration, on all links that have it, (..., 6, 3).

        A link that was given its true length keeps it.
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
        """By link of two points: by its length, the second point moving away from the first, (..., 6)."""
        two = [(name, link.points) for name, link in self.linkage.links.items() if len(link.points) == 2]
        return {name: self.length(name, *points) for name, points in two}

    @cached_property
    def axes(self) -> dict[Place, Array]:
        """By link and joint: by a small rotation of the joint's axes on that link alone, (..., 6, 3).

        The rotation vector is in global axes in the reference configuration; the joint's point stays where it is. To
        turn the axes on both links, add both.
        """
        out = {}
        for pair in self.linkage.joints.values():
            by = self.joints[pair.name]
            here, there = (self.motion.position(pair.point, link) for link in (pair.first, pair.second))
            # Turned on the first link, the joint carries the second around the joint's point on the first.
            arm = np.cross(self._to_joint(pair, there - here)[..., None, :], by[..., :3])
            out[pair.first, pair.name] = (by[..., 3:] + arm) @ self._rotated(pair, pair.first)
            out[pair.second, pair.name] = -by[..., 3:] @ self._rotated(pair, pair.second)
        return out

    @cached_property
    def pitches(self) -> dict[str, Array]:
        """By screw: by its pitch, (..., 6)."""
        out = {}
        for name, pair in self.linkage.joints.items():
            if pair.pitch is not None:
                rotated = self.motion.assembly.state[self.motion.mechanism.states[name].start]
                turns = np.broadcast_to(rotated, self.motion.shape) / (2.0 * np.pi)
                out[name] = self.joints[name][..., 2] * turns[..., None]
        return out

    def length(self, link: str, start: str, end: str) -> Array:
        """Derivative by the distance of two points of a link, the second moving away from the first on that link alone.

        Parameters
        ----------
        link
            Name of the link, or ``"ground"``.
        start, end
            Names of two of its points.

        Returns
        -------
        ndarray
            ``ux uy uz rx ry rz`` by length, (..., 6).

        Raises
        ------
        FrameError
            If the link has not both points, or they coincide.

        Examples
        --------
        An arm that gets longer moves its end along itself.

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
        """From the reference configuration of a link to the axes of a joint, (..., 3, 3)."""
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
    """The same with a further row for each redundant constraint: what opens it; in the units of the first three.

    NaN where the pose is not regular: other constraints are redundant there.
    """
    work = VirtualWork(by.motion)
    if not work.redundant:
        return by
    units = np.array([1.0] * 3 + [work.mechanism.size] * 3)
    regular = work.regular[..., None, None]
    rows = {joint: np.where(regular, force * units, np.nan) for joint, force in work.self_stresses().items()}
    joints = {joint: np.concatenate([value, rows[joint]], axis=-2) for joint, value in by.joints.items()}
    return PositionSensitivity(by.motion, by.point, by.link, joints)


def by_units(work: VirtualWork, force: Array) -> Array:
    """Derivatives in the user's units, NaN where the pose is not regular, from forces (..., 6, 6) in units of size."""
    size = work.mechanism.size
    lengths, angles = np.array([size] * 3 + [1.0] * 3), np.array([1.0 / size] * 3 + [1.0] * 3)
    return np.where(work.regular[..., None, None], force * lengths[:, None] * angles, np.nan)


def sorted_as(motion: ClassifiedPoses, forces: dict[str, Array]) -> Iterator[str]:
    """Joints in the order of the description."""
    return (name for name in motion.linkage.joints if name in forces)
