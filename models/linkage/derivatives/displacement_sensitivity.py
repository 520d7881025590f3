"""How the displacement of a loaded linkage depends on its dimensions: by the frame, and by the loop closure."""

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
from ..poses.classified import ClassifiedPoses
from .position_sensitivity import Place, PositionSensitivity
from .virtual_work import VirtualWork


@dataclass(frozen=True, eq=False, repr=False)
class DisplacementSensitivity(PositionSensitivity):
    """Derivatives of the displacement by compliance, without clearance; made by `PointAccuracy.sensitivity`.

    Rows are the components that were asked for, in place of ``ux .. rz``. Each has one adjoint, for all inputs: what a
    dimension changes in the frame is told by the forces and displacements under the unit load; what it changes
    in the pose of the links, by the moments that turn them, which the loop closure passes on to its joints.

    Attributes
    ----------
    motion
        Where the linkage is, (...).
    point, link
        Empty: no point is moved by itself.
    joints
        By joint: by a displacement and rotation of its second link relative to where the joint would have it, by which
        the pose changes, in the joint's axes, (..., k, 6).
    components
        Components of the displacement, the rows.
    frame
        By component, derivatives by what the frame is made of: loads, members, sections, moduli, stiffness of joints.
    nodes
        By link and point: what the place of the point changes in the frame, (..., k, 3).
    """

    components: tuple[str, ...]
    frame: dict[str, Sensitivity]
    nodes: Mapping[Place, Array]

    def __repr__(self) -> str:
        of = ", ".join(self.components)
        return f"<Sensitivity of the displacement {of} to {', '.join(self.joints)}, shape {self.motion.shape}>"

    @cached_property
    def places(self) -> dict[Place, Array]:
        """By link and point: by a shift of the point on that link alone in the reference configuration, (..., k, 3)."""
        through_loops = super().places
        return {key: value + self.nodes.get(key, 0.0) for key, value in through_loops.items()}

    @cached_property
    def pitches(self) -> dict[str, Array]:
        """By screw: by its pitch, (..., k)."""
        out = super().pitches
        for name, value in out.items():
            none = np.zeros(value.shape[:-1])
            out[name] = value + np.stack([each.pitches.get(name, none) for each in self.frame.values()], axis=-1)
        return out

    @cached_property
    def axes(self) -> dict[Place, Array]:
        """Not known of a displacement, (..., k, 3) of a position.

        Raises
        ------
        FrameError
            Always.
        """
        raise FrameError(
            "the sensitivity of a displacement to the axes of joints is not offered: turn them by a little"
        )


def displacement_sensitivity(
    motion: ClassifiedPoses, solution: Solution, nodes: Mapping[Place, str], node: str, components: Sequence[str]
) -> DisplacementSensitivity:
    """Derivatives of components of the displacement of a node.

    Parameters
    ----------
    motion
        The motion.
    solution
        The loaded frame, its clearances closed.
    nodes
        Names of the frame's nodes by link and point.
    node
        The node that is displaced.
    components
        Such as ``uy``.
    """
    check(motion.linkage)
    found = {component: solution.sensitivity(node, component) for component in components}
    return through_loops(motion, nodes, found)


def through_loops(
    motion: ClassifiedPoses, nodes: Mapping[Place, str], found: Mapping[str, Sensitivity]
) -> DisplacementSensitivity:
    """Derivatives of results by name from those of the frame: what turns its links, the loop closure passes on.

    Parameters
    ----------
    motion
        The motion.
    nodes
        Names of the frame's nodes by link and point.
    found
        Derivatives of each result by what the frame is made of.
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
    units = np.array([1.0 / work.mechanism.size] * 3 + [1.0] * 3)
    joints = {name: np.where(good, forces[name] * units, np.nan) for name in motion.linkage.joints}
    by_node = {
        place: np.stack([each.nodes[name] for each in found.values()], axis=-2)
        for place, name in nodes.items()
        if place[0] != GROUND
    }
    return DisplacementSensitivity(motion, "", "", joints, tuple(found), dict(found), by_node)


def _by_joint_axes(motion: ClassifiedPoses, link: str, found: Sensitivity) -> Array:
    """By a small rotation of a link, which turns the axes of the joints that it carries, (..., 3).

    The cross of a universal joint turns about z of the first link with the second, whose axis x is, and else with the
    first.
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
    """Refuse what also depends on the pose: springs, loads that turn, masses beside their points, sliders on beams."""
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
