"""Newton-Euler equations of all links: their columns are what each joint can transmit."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from ....framework.arm import transferred
from ....framework.batch import Array, Shape
from ..continuation.driven import free_motions
from ..description.joints import COMPONENTS
from ..description.parts import Pair
from ..poses.kinematics import Kinematics
from .actions import applied, centre_of, inertia_force, rotated_tensor, weight, whole_shape
from .inertia import inertia


@dataclass(frozen=True, eq=False)
class Transmitted:
    """Unit forces and moments that a joint exerts on its second link.

    Attributes
    ----------
    joint
        The joint.
    names
        Component that each belongs to: what the joint holds, then what is driven.
    place
        Where it acts, global, (..., 3): the joint's point on the second link.
    wrenches
        Forces and moments about `place`, global, (..., 6, n).
    """

    joint: Pair
    names: tuple[str, ...]
    place: Array
    wrenches: Array

    @classmethod
    def of(cls, motion: Kinematics, joint: Pair) -> Transmitted:
        """What does no work on the motion that the joint lets go, and, if it is driven, what works on that motion.

        Forces and moments along the joint's axes; a screw pushes and turns at once, ``m_z = -f_z pitch / 2 pi``.
        """
        axes = motion.joint_axes(joint.name)
        names = (*joint.kind.constrained, *motion.linkage.drives.get(joint.name, ()))
        wrenches = np.zeros((*axes.shape[:-2], 6, len(names)))
        for column, name in enumerate(names):
            part, k = divmod(COMPONENTS.index(name), 3)
            wrenches[..., 3 * part : 3 * part + 3, column] = axes[..., k]
            if joint.pitch is not None and name == "uz":
                lead = np.asarray(joint.pitch) / (2.0 * np.pi)
                wrenches[..., 3:, column] = -lead[..., None] * axes[..., 2]
        return cls(joint, names, motion.position(joint.point, joint.second), wrenches)


class Equilibrium:
    """Equations of equilibrium of all links at every pose.

    For each link, about its centre of mass: forces and moments of its joints, of what is applied, of its weight and of
    its inertia, Eq. (3) and (4) of the accuracy paper, add up to zero. Moments are divided by the linkage's size, so
    that all coefficients are near one.

    Parameters
    ----------
    motion
        The motion, (...).

    Raises
    ------
    FrameError
        If masses, beams, loads, springs or gravity do not broadcast with the motion.
    """

    def __init__(self, motion: Kinematics) -> None:
        whole_shape(motion)
        self.motion = motion
        self.links = list(motion.linkage.links)
        self.joints = [Transmitted.of(motion, joint) for joint in motion.linkage.joints.values()]

    @cached_property
    def size(self) -> Array:
        """Length by which moments are divided: half of what the linkage spans, (...)."""
        points = np.stack(np.broadcast_arrays(*self.motion.linkage.points.values()))
        span = 0.5 * np.ptp(points, axis=0).max(axis=-1)
        return np.where(span > 0.0, span, 1.0)

    @cached_property
    def centres(self) -> dict[str, Array]:
        """Centre of mass of each link, (..., 3)."""
        return {link: centre_of(self.motion, link) for link in self.links}

    @property
    def unknowns(self) -> int:
        """Number of forces and moments that the joints can transmit."""
        return sum(len(joint.names) for joint in self.joints)

    @cached_property
    def parts(self) -> list[tuple[slice, slice, Array]]:
        """Rows, columns and coefficients (..., 6, n) of what each joint does to each of its links."""
        parts, start = [], 0
        for joint in self.joints:
            columns = slice(start, start := start + len(joint.names))
            for link, sign in ((joint.joint.second, 1.0), (joint.joint.first, -1.0)):
                if link in self.centres:
                    arm = (joint.place - self.centres[link])[..., None, :]
                    each = transferred(np.swapaxes(joint.wrenches, -1, -2), arm)
                    each = np.swapaxes(self.scaled(each, self.size[..., None]), -1, -2)
                    row = 6 * self.links.index(link)
                    parts.append((slice(row, row + 6), columns, sign * each * self.units(joint)[..., None, :]))
        return parts

    @property
    def matrix(self) -> Array:
        """Coefficients of the unknowns, (..., 6 links, unknowns)."""
        shape = np.broadcast_shapes(self.motion.shape, *(part.shape[:-2] for _, _, part in self.parts))
        matrix = np.zeros((*shape, 6 * len(self.links), self.unknowns))
        for rows, columns, part in self.parts:
            matrix[..., rows, columns] = part
        return matrix

    def matrices(self, shape: Shape, entries: NDArray[np.int64]) -> Array:
        """Coefficients at some entries of the flattened batch of that shape, (k, 6 links, unknowns)."""
        matrix = np.zeros((len(entries), 6 * len(self.links), self.unknowns))
        whole = shape or (1,)
        where = np.unravel_index(entries, whole)
        for rows, columns, part in self.parts:
            matrix[:, rows, columns] = np.broadcast_to(part, (*whole, *part.shape[-2:]))[where]
        return matrix

    @cached_property
    def side(self) -> Array:
        """What the joints must balance, (..., 6 links)."""
        loads: dict[str, Array] = {}
        actions = [act(self.motion, link) for link in self.links for act in (weight, inertia_force)]
        for action in (*actions, *applied(self.motion)):
            about = self.scaled(action.about(self.centres[action.link]), self.size)
            loads[action.link] = loads.get(action.link, np.zeros(6)) - about
        shape = np.broadcast_shapes(self.motion.shape, *(load.shape[:-1] for load in loads.values()))
        return np.concatenate([np.broadcast_to(loads[link], (*shape, 6)) for link in self.links], axis=-1)

    @cached_property
    def inertia(self) -> Array:
        """Mass matrices of all links, (..., 6 links, 6 links), in the units of the equations."""
        every = [inertia(self.motion.linkage, link) for link in self.links]
        shapes = [shape for own in every for shape in (own.mass.shape, own.tensor.shape[:-2])]
        shape = np.broadcast_shapes(self.motion.shape, self.size.shape, *shapes)
        matrix, square = np.zeros((*shape, 6 * len(self.links), 6 * len(self.links))), self.size[..., None, None] ** 2
        for row, (link, own) in enumerate(zip(self.links, every, strict=True)):
            at, turn = slice(6 * row, 6 * row + 3), slice(6 * row + 3, 6 * row + 6)
            matrix[..., at, at] = own.mass[..., None, None] * np.eye(3)
            matrix[..., turn, turn] = rotated_tensor(self.motion.axes(link), own.tensor) / square
        return matrix

    @property
    def idle(self) -> int:
        """Number of freedoms that nothing drives."""
        return free_motions(self.motion.assembly.loops)

    @staticmethod
    def scaled(wrench: Array, size: Array) -> Array:
        """Forces and moments (..., 6), the moments divided by a size (...)."""
        moments = wrench[..., 3:] / size[..., None]
        forces = np.broadcast_to(wrench[..., :3], moments.shape)
        return np.concatenate([forces, moments], axis=-1)

    def units(self, joint: Transmitted) -> Array:
        """Size of the unknowns of a joint: one for forces, the length for moments, (..., n)."""
        turns = np.array([name.startswith("r") for name in joint.names], dtype=bool)
        return np.where(turns, self.size[..., None], 1.0)
