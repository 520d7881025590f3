"""The frame of a linkage at one pose made from its frame at another: only places and axes change."""

from __future__ import annotations

from ....elements import Joint
from ....framework.batch import Array, rotated
from ....framework.described.parts import Body
from ....framework.frame import Frame
from ..description.parts import GROUND, UNTURNED, about_first
from ..poses.classified import ClassifiedPoses
from .inertia import is_given


def differs_in_place_only(motion: ClassifiedPoses, spins: object) -> bool:
    """Whether frames of single poses differ only in the positions of their bodies and the axes of their joints.

    They differ in more if the linkage has sliders, springs, links with given masses, or rods that spin between two
    spherical joints (`spins`).
    """
    linkage = motion.linkage
    if motion.shape or linkage.shape or spins or linkage.springs or not motion.is_assembled:
        return False
    if any(pair.kind.slides for pair in linkage.joints.values()):
        return False
    return not any(is_given(link) for link in linkage.links.values())


def at_another_pose(frame: Frame, motion: ClassifiedPoses) -> Frame:
    """Copy of `frame` moved to the pose of `motion`, a single pose for which `differs_in_place_only` holds."""
    clone = frame.copy()
    clone.made_from, clone.tolerance = motion, motion.tolerance
    axes = {GROUND: UNTURNED}
    for name, origin, turned in motion.origins_and_axes():
        axes[name] = _read_only(turned)
        clone.bodies[name] = Body(_read_only(origin), axes[name])
    for name, pair in motion.linkage.joints.items():
        cross = pair.kind.name == "universal"
        if cross:
            along = _read_only(motion.joint_axes(name))
        else:
            along = axes[pair.first] if pair.is_unturned else _read_only(axes[pair.first] @ pair.axes)
        for own in (name, about_first(pair)) if cross else (name,):
            joint = clone.joints[own]
            assert isinstance(joint.element, Joint)
            clone.joints[own] = type(joint)(joint.element.along(along), joint.first, joint.second)
    clone.size = 0.0
    for node in clone.nodes.values():
        place = node.coordinates
        if node.body is not None:
            body = clone.bodies[node.body]
            place = body.origin + rotated(body.axes, place)
        clone.size = max(clone.size, *map(abs, place.tolist()))
    return clone


def _read_only(values: Array) -> Array:
    values.setflags(write=False)
    return values
