"""Newton-Euler equations of all links, whose unknowns are the forces and moments that joints and drives transmit."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.batch import Array, Shape
from ....framework.errors import FrameError
from ...newton_euler import NewtonEuler, Transmitted
from ..continuation.driven import free_motions
from ..description.joints import COMPONENTS
from ..description.linkage_description import LinkageDescription
from ..description.parts import Pair
from ..poses.kinematics import Kinematics
from .actions import applied, centre_of, inertia_force, rotated_tensor, weight, whole_shape
from .coefficients import Coefficients
from .inertia import inertia


class Equilibrium(NewtonEuler):
    """Equations of equilibrium of all links at every pose.

    Equations of moments are divided by the linkage's size, and unknown moments count in multiples of it, so that all
    coefficients are dimensionless.

    Parameters
    ----------
    motion
        The motion, (...).

    Attributes
    ----------
    names
        By joint: components of its unknowns, first those that the joint constrains, then those that are driven.

    Raises
    ------
    FrameError
        If there are no links, or masses, beams, loads, springs or gravity do not broadcast with the motion.
    """

    def __init__(self, motion: Kinematics) -> None:
        if not motion.linkage.links:
            raise FrameError("the linkage has no links that could be in equilibrium: describe them with link()")
        whole_shape(motion)
        self.motion, linkage = motion, motion.linkage
        self.names = {
            name: (*joint.kind.constrained, *linkage.drives.get(name, ())) for name, joint in linkage.joints.items()
        }
        self.size = _size(linkage)
        motion.evaluate_links(rates=True)
        centres = {link: centre_of(motion, link) for link in linkage.links}
        super().__init__(centres, [self._transmitted(joint) for joint in linkage.joints.values()], self.size)

    def coefficients(self, shape: Shape, entries: NDArray[np.int64]) -> Coefficients:
        """Coefficients of the unknowns at n entries of the flattened batch of shape `shape`."""
        count = 6 * len(self.centres), self.unknowns
        return Coefficients(*self.places, self.numbers(shape, entries), count)

    @cached_property
    def side(self) -> Array:
        """Right-hand side: weights, inertia forces and loads that the joints balance, (..., 6 links)."""
        actions = [act(self.motion, link, at) for link, at in self.centres.items() for act in (weight, inertia_force)]
        return self.balanced([*actions, *(action for _, action in applied(self.motion))])

    @cached_property
    def inertia(self) -> Array:
        """Mass matrices of all links, (..., 6 links, 6 links), in the units of the equations."""
        every = {link: inertia(self.motion.linkage, link) for link in self.centres}
        shapes = [shape for own in every.values() for shape in (own.mass.shape, own.tensor.shape[:-2])]
        shape = np.broadcast_shapes(self.motion.shape, self.size.shape, *shapes)
        matrix, square = np.zeros((*shape, *2 * (6 * len(every),))), self.size[..., None, None] ** 2
        for link, own in every.items():
            row = self.rows[link].start
            at, turn = slice(row, row + 3), slice(row + 3, row + 6)
            matrix[..., at, at] = own.mass[..., None, None] * np.eye(3)
            matrix[..., turn, turn] = rotated_tensor(self.motion.axes(link), own.tensor) / square
        return matrix

    @property
    def idle(self) -> int:
        """Number of degrees of freedom without a drive."""
        return free_motions(self.motion.assembly.loops)

    def units_of(self, joint: str) -> Array:
        """Units of the unknowns of a joint, (..., n)."""
        return np.where(np.array([name[0] == "r" for name in self.names[joint]], dtype=bool), self.size[..., None], 1.0)

    def _transmitted(self, joint: Pair) -> Transmitted:
        """Unit forces and moments of a joint: its constraint forces, which do no work, and those of its drives.

        They act along the joint's axes; in a screw, force and moment are coupled by ``m_z = -f_z pitch / 2 pi``.
        """
        axes, names = self.motion.joint_axes(joint.name), self.names[joint.name]
        wrenches = np.zeros((*axes.shape[:-2], len(names), 6))
        for row, name in enumerate(names):
            part, k = divmod(COMPONENTS.index(name), 3)
            wrenches[..., row, 3 * part : 3 * part + 3] = axes[..., k]
            if joint.pitch is not None and name == "uz":
                lead = np.asarray(joint.pitch) / (2.0 * np.pi)
                wrenches[..., row, 3:] = -lead[..., None] * axes[..., 2]
        place = self.motion.position(joint.point, joint.second)
        return Transmitted(joint.first, joint.second, place, self.units_of(joint.name)[..., None] * wrenches)


def _size(linkage: LinkageDescription) -> Array:
    """Half of the linkage's largest extent along an axis, (...); 1 if its points coincide."""
    points = np.stack(np.broadcast_arrays(*linkage.points.values()))
    span = 0.5 * np.ptp(points, axis=0).max(axis=-1)
    return np.where(span > 0.0, span, 1.0)
