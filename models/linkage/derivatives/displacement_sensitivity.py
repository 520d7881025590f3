"""Derivatives of the displacement of a loaded linkage by its dimensions, in its frame and through the loop closure."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ....framework.batch import Array
from ....framework.error_bounds.sensitivity import Sensitivity
from ....framework.errors import FrameError
from ....framework.solution import Solution
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, about_first
from ..kinematics.dimensions import six_units
from ..poses.classified import ClassifiedPoses
from .position_sensitivity import Place, PositionSensitivity
from .virtual_work import VirtualWork


@dataclass(frozen=True, eq=False, repr=False)
class DisplacementSensitivity(PositionSensitivity):
    """Derivatives of the displacement by compliance, without clearance; made by `PointAccuracy.sensitivity`.

    Rows are the k requested components instead of ``ux .. rz``. One adjoint solution for each gives the derivatives by
    all inputs: the forces and displacements under a unit load give the effect of a dimension on the frame; the moments
    that act on rotations of the links, transferred to the joints by the loop closure, its effect on the pose.

    Attributes
    ----------
    motion
        The motion of the linkage, (...).
    point, link
        Empty, as no position of a point enters here.
    joints
        By joint: derivatives by a displacement and rotation of its second link relative to its place in the ideal
        joint, through the pose, in the joint's axes, (..., k, 6).
    components
        Components of the displacement, one for each row.
    frame
        By component: derivatives by loads, members, sections, moduli and joint stiffnesses of the frame.
    nodes
        By link and point: derivatives by the position of the point in the frame at a fixed pose, (..., k, 3).
    """

    components: tuple[str, ...]
    frame: dict[str, Sensitivity]
    nodes: Mapping[Place, Array]

    def __repr__(self) -> str:
        of = ", ".join(self.components)
        return f"<Sensitivity of the displacement {of} to {', '.join(self.joints)}, shape {self.motion.shape}>"

    @cached_property
    def places(self) -> dict[Place, Array]:
        """By link and point: derivatives by a shift of the point on that link alone, (..., k, 3)."""
        through_loops = super().places
        return {key: value + self.nodes.get(key, 0.0) for key, value in through_loops.items()}

    @cached_property
    def pitches(self) -> dict[str, Array]:
        """By screw joint: derivatives by its pitch, (..., k)."""
        out = super().pitches
        for name, value in out.items():
            none = np.zeros(value.shape[:-1])
            out[name] = value + np.stack([each.pitches.get(name, none) for each in self.frame.values()], axis=-1)
        return out

    @cached_property
    def axes(self) -> dict[Place, Array]:
        """Not available for a displacement; for a position they are (..., 6, 3) by link and joint.

        Raises
        ------
        FrameError
            Always.
        """
        raise FrameError(
            "the sensitivity of a displacement to the axes of joints is not offered: turn the axes by a small angle "
            "and compare"
        )


def displacement_sensitivity(
    motion: ClassifiedPoses, solution: Solution, nodes: Mapping[Place, str], node: str, components: Sequence[str]
) -> DisplacementSensitivity:
    """Derivatives of displacement components of a node.

    Parameters
    ----------
    motion
        The motion.
    solution
        Solution of the loaded frame, without clearance.
    nodes
        Names of the frame's nodes by link and point.
    node
        Name of the node.
    components
        Components of its displacement, such as ``uy``.
    """
    check(motion.linkage)
    found = {component: solution.sensitivity(node, component) for component in components}
    return through_loops(motion, nodes, found)


def through_loops(
    motion: ClassifiedPoses, nodes: Mapping[Place, str], found: Mapping[str, Sensitivity]
) -> DisplacementSensitivity:
    """Derivatives of results by the linkage's dimensions from those by its frame, through the loop closure.

    Parameters
    ----------
    motion
        The motion.
    nodes
        Names of the frame's nodes by link and point.
    found
        By result: its derivatives by the quantities of the frame.
    """
    moments: dict[str, Array] = {}
    for link in motion.linkage.links:
        rows = [each.bodies[link] + _by_joint_axes(motion, link, each) for each in found.values()]
        turn = np.stack(rows, axis=-2)
        moments[link] = np.concatenate([np.zeros_like(turn), turn], axis=-1)
    work = VirtualWork(motion)
    if moments and next(iter(moments.values())).shape[:-2] != motion.shape:
        raise FrameError(
            "sensitivity of a displacement: loads or beams vary over more than the motion does: give the drives values "
            "of that shape"
        )
    good = work.regular[..., None, None]
    forces = work.joint_forces({link: np.where(good, value, 0.0) for link, value in moments.items()})
    units = six_units(1.0 / work.mechanism.size, 1.0)[..., None, :]
    joints = {name: np.where(good, forces[name] * units, np.nan) for name in motion.linkage.joints}
    by_node = {
        place: np.stack([each.nodes[name] for each in found.values()], axis=-2)
        for place, name in nodes.items()
        if place[0] != GROUND
    }
    return DisplacementSensitivity(motion, "", "", joints, tuple(found), dict(found), by_node)


def _by_joint_axes(motion: ClassifiedPoses, link: str, found: Sensitivity) -> Array:
    """Derivatives by a small rotation of a link through the axes of its joints, (..., 3).

    The axes of most joints rotate with their first link. The cross of a universal joint rotates about its z axis with
    the second link, which carries x, and about other axes with the first.
    """
    total = np.zeros(3)
    for pair in motion.linkage.joints.values():
        if link not in (pair.first, pair.second):
            continue
        turned = found.joint_axes[pair.name]
        if pair.kind.name != "universal":
            total = total + turned if link == pair.first else total
            continue
        turned, z = turned + found.joint_axes[about_first(pair)], motion.joint_axes(pair.name)[..., 2]
        about = np.sum(turned * z, axis=-1, keepdims=True) * z
        total = total + (turned - about if link == pair.first else about)
    return total


def check(linkage: LinkageDescription) -> None:
    """Refuse forces that depend on the pose, which have no derivatives here, and sliders on beams.

    Such forces come from springs, follower loads and the weight of given masses.
    """
    what = "sensitivity of a displacement to dimensions"
    if linkage.springs:
        raise FrameError(f"{what}: the linkage has springs, whose forces change with its pose: it is not offered")
    if any(load.follower for load in linkage.loads):
        raise FrameError(f"{what}: a load turns with its link: give its components in global axes")
    if np.any(linkage.weight) and any(link.mass is not None for link in linkage.links.values()):
        raise FrameError(f"{what}: the weight of a given mass turns its link with the pose: give its beams a density")
    for pair in linkage.joints.values():
        if pair.kind.slides and pair.first != GROUND and linkage.links[pair.first].beams:
            raise FrameError(f"{what}: joint {pair.name!r} slides along a beam of {pair.first!r}: it is not offered")
