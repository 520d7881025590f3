"""Where everything of a linkage is, how fast it moves and how it accelerates."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array, vector
from ....framework.program.calculation import worth_compiling
from ..description.parts import GROUND
from ..kinematics.blocks import parts
from ..kinematics.terms import Value, combine, cross
from .assembled_poses import AssembledPoses


@dataclass(frozen=True, eq=False, repr=False)
class Kinematics(AssembledPoses):
    """Positions, velocities and accelerations of a linkage over a batch of poses; see `Motion`."""

    # -- points -----------------------------------------------------------------------------------------------------

    def position(self, point: str, link: str | None = None) -> Array:
        """Position of a point.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global coordinates x y z, (..., 3), length; NaN where the pose has none.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.

        Examples
        --------
        >>> import numpy as np
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.move(A=np.radians([0.0, 90.0])).position("B").round(12).tolist()
        [[2.0, 0.0, 0.0], [0.0, 2.0, 0.0]]
        """
        return self._position(*self._on(point, link))

    def velocity(self, point: str, link: str | None = None) -> Array:
        """Velocity of a point.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global components, (..., 3), length per time.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.

        Examples
        --------
        >>> from linkframe.models import Linkage
        >>> linkage = Linkage(A=(0, 0), B=(2, 0))
        >>> linkage.link("arm", "A", "B")
        >>> linkage.revolute("A", "ground", "arm", drive=True)
        >>> linkage.move(A=0.0, rates={"A": 3.0}).velocity("B").round(12).tolist()
        [0.0, 6.0, 0.0]
        """
        return self._velocity_at(*self._on(point, link))

    def acceleration(self, point: str, link: str | None = None) -> Array:
        """Acceleration of a point.

        Parameters
        ----------
        point
            Name of the point.
        link
            The link on which it is taken; the first that has it where None.

        Returns
        -------
        ndarray
            Global components, (..., 3), length per time squared.

        Raises
        ------
        FrameError
            If there is no such point or link, or the link has it not.
        """
        return self._acceleration_at(*self._on(point, link))

    def position_on(self, link: str, place: ArrayLike) -> Array:
        """Position of a place of a link, (..., 3).

        Parameters
        ----------
        link
            Name of the link.
        place
            The place in the reference configuration, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._position(link, vector(place, "place on a link", flat=True))

    def velocity_on(self, link: str, place: ArrayLike) -> Array:
        """Velocity of a place of a link, (..., 3).

        Parameters
        ----------
        link
            Name of the link.
        place
            The place in the reference configuration, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._velocity_at(link, vector(place, "place on a link", flat=True))

    def acceleration_on(self, link: str, place: ArrayLike) -> Array:
        """Acceleration of a place of a link, (..., 3).

        Parameters
        ----------
        link
            Name of the link.
        place
            The place in the reference configuration, (..., 2 or 3).

        Returns
        -------
        ndarray
            Global components, (..., 3).
        """
        return self._acceleration_at(link, vector(place, "place on a link", flat=True))

    # -- links ------------------------------------------------------------------------------------------------------

    def origin(self, link: str) -> Array:
        """Where the origin of the reference configuration is as a point of the link, (..., 3).

        A place x of the reference configuration is at ``origin + axes @ x``.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        ndarray
            Global coordinates, (..., 3).
        """
        return self._position(link, np.zeros(3))

    def axes(self, link: str) -> Array:
        """Orientation of a link: its axes as columns, the identity in the reference configuration.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        ndarray
            Rotation from the reference configuration, (..., 3, 3).
        """
        if link == GROUND:
            return np.broadcast_to(np.eye(3), (*self.shape, 3, 3))
        now = self._global_columns(self._pose(link)[1])
        return np.asarray(np.einsum("...ij,...kj->...ik", now, self.mechanism.bodies[link].reference_axes))

    def origins_and_axes(self) -> list[tuple[str, Array, Array]]:
        """Evaluate `origin` and `axes` of all links, which is quicker together than link by link.

        Returns
        -------
        list of tuple
            Each link, its origin (..., 3) and its axes (..., 3, 3), in the order of the links.
        """
        self.evaluate_links()
        return [(link, self.origin(link), self.axes(link)) for link in self.linkage.links]

    def angular_velocity(self, link: str) -> Array:
        """Angular velocity of a link.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        ndarray
            Global components, (..., 3), radians per time.
        """
        return self._global(self._rates(link)[0])

    def angular_acceleration(self, link: str) -> Array:
        """Angular acceleration of a link.

        Parameters
        ----------
        link
            Name of the link.

        Returns
        -------
        ndarray
            Global components, (..., 3), radians per time squared.
        """
        return self._global(self._rates(link)[2])

    def joint_axes(self, joint: str) -> Array:
        """Orientation of a joint: its axes x y z as columns.

        They move with the joint's first link; those of a universal joint have z on the first and x on the second.

        Parameters
        ----------
        joint
            Name of the joint.

        Returns
        -------
        ndarray
            Global components, (..., 3, 3).
        """
        pair = self.linkage.joint(joint)
        first = self.axes(pair.first) @ pair.axes
        if pair.kind.name != "universal":
            return np.asarray(first)
        z, x = first[..., 2], (self.axes(pair.second) @ pair.axes)[..., 0]
        return np.stack([x, np.cross(z, x), z], axis=-1)

    # -- in global axes ---------------------------------------------------------------------------------------------

    def _position(self, link: str, place: Array) -> Array:
        ground = self.mechanism.bodies[GROUND]
        if link == GROUND:
            return np.broadcast_to(place, (*np.broadcast_shapes(self.shape, place.shape[:-1]), 3))
        one_by_one = link in self._poses or place.ndim > 1 or self.linkage.shape or not self.shape
        if not one_by_one and (found := self._swept(link, place)) is not None:
            return found
        origin, axes = self._pose(link)
        there = [x + y for x, y in zip(origin, self._arm(link, axes, place), strict=True)]
        return np.asarray(self._global(there, self.mechanism.size) + ground.place)

    def _swept(self, link: str, place: Array) -> Array | None:
        """Positions of a long batch as machine code, part by part in the cache; None where that does not pay."""
        shape, mechanism = self.shape, self.mechanism
        if not worth_compiling(math.prod(shape)) or self._far:
            return None
        arm = [float(x) for x in mechanism.arm(link, place)]
        kept = tuple(k for k, x in enumerate(arm) if x)
        inputs = [*(arm[k] for k in kept), mechanism.size]
        work = mechanism.point_of(link, kept).calculation([self.assembly.state, mechanism.parameters, inputs], shape)
        if work is None:
            return None
        out, ground = np.empty((*shape, 3)), mechanism.bodies[GROUND]
        for block, axis, chosen in parts(shape):
            whole = out[block]
            made = [np.empty(work.of(work.program.masks[k], whole.shape[:-1])) for k in work.program.outputs]
            work.run(axis, chosen, made)
            for k, x in enumerate(made):
                whole[..., k] = x
            if not mechanism.upright:
                whole[...] = np.einsum("...ij,...j->...i", ground.reference_axes, whole)
            whole += ground.place
        if not self.assembly.all_closed:
            out[~np.broadcast_to(self.assembly.closed, shape)] = np.nan
        return out

    def _arm(self, link: str, axes: list[list[Value]], place: Array) -> list[Value]:
        """Vector from the link's reference point to a place, in the ground's axes."""
        return combine(axes, self.mechanism.arm(link, place))

    def _velocity_at(self, link: str, place: Array) -> Array:
        omega, v, _, _ = self._rates(link)
        if link == GROUND:
            return np.zeros((*self.shape, 3))
        arm = self._arm(link, self._pose(link)[1], place)
        return self._global([x + y for x, y in zip(v, cross(omega, arm), strict=True)], self.mechanism.size)

    def _acceleration_at(self, link: str, place: Array) -> Array:
        omega, _, alpha, a = self._rates(link)
        if link == GROUND:
            return np.zeros((*self.shape, 3))
        arm = self._arm(link, self._pose(link)[1], place)
        turning, inward = cross(alpha, arm), cross(omega, cross(omega, arm))
        return self._global([x + y + z for x, y, z in zip(a, turning, inward, strict=True)], self.mechanism.size)

    def _on(self, point: str, link: str | None) -> tuple[str, Array]:
        name, _ = self.linkage.end(point if link is None else (link, point), "the motion")
        return name, self.mechanism.place(name, point)
