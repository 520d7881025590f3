"""The frame of a linkage at one pose from that at another: bodies are elsewhere, joints lie along other axes."""

from __future__ import annotations

import numpy as np

from ....elements import Joint
from ....framework.batch import Array, rotated
from ....framework.described.parts import Body
from ....framework.frame import Frame
from ..description.parts import GROUND, about_first
from ..poses.classified import ClassifiedPoses
from .inertia import is_given


def differs_in_place_only(motion: ClassifiedPoses, spins: object) -> bool:
    """Whether all that the frame of a single pose has from the pose is the place of its bodies and axes of joints.

    That is not so of where a slider stands, of the pull of a spring, of a mass, which has no axes of its own, and of a
    rod that spins.
    """
    linkage = motion.linkage
    if motion.shape or linkage.shape or spins or linkage.springs or not motion.is_assembled:
        return False
    if any(pair.kind.slides for pair in linkage.joints.values()):
        return False
    return not any(is_given(link) for link in linkage.links.values())


def at_another_pose(frame: Frame, motion: ClassifiedPoses) -> Frame:
    """A frame of the same linkage at a single pose of which `differs_in_place_only` holds, as at that of `frame`."""
    clone = frame.copy()
    clone.made_from, clone.tolerance = motion, motion.tolerance
    axes = {GROUND: np.eye(3)}
    for name, origin, turned in motion.origins_and_axes():
        axes[name] = _own(turned)
        clone.bodies[name] = Body(_own(origin), axes[name])
    for name, pair in motion.linkage.joints.items():
        cross = pair.kind.name == "universal"
        along = _own(motion.joint_axes(name) if cross else axes[pair.first] @ pair.axes)
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
        clone.size = max(clone.size, float(np.abs(place).max()))
    return clone


def _own(values: Array) -> Array:
    """The values as the description keeps them: its own, not to be written to."""
    out = np.array(values)
    out.setflags(write=False)
    return out
