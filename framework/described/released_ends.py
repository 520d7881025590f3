"""Released ends of members as joints, as what they are where members rotate: at large displacement, and in buckling."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array
from ..description import Description
from ..joint_protocol import JointElement
from ..protocol import LineElement
from .parts import JointLink

_NONE = np.zeros(())


@dataclass(frozen=True, eq=False)
class ReleasedEnd(JointElement):
    """A released end as what it is where members rotate: an ideal joint from a node of the member's own.

    Its axes are the local ones of the member and follow its end, so that what is released is free in the end's own
    section, however far that turns. What linear mechanics condenses in the member's matrix is no more than a hinge
    whose axis is the member's mean one, which is off as soon as both ends turn.

    Attributes
    ----------
    stiffness
        0 where it is released, else inf, (6,).
    axes
        The member's local axes as columns in global components, (..., 3, 3).
    """

    stiffness: Array
    axes: Array

    clearance = _NONE
    clearance_directions = ()
    pitch = _NONE

    @property
    def shape(self) -> tuple[int, ...]:
        return self.axes.shape[:-2]

    def matrix(self) -> Array:
        return self.springs_matrix()

    def typical(self) -> ReleasedEnd:
        return self


def with_hinges(frame: Description) -> Description:
    """A frame in which released ends are nodes of their own on ideal joints; the same where there are none.

    Nodes and joints that are added come after all others. As they are, members stay that know no `unreleased` element.
    """
    released = {
        name: whole
        for name, (element, *_) in frame.members.items()
        if element.releases and not _bar(element) and (whole := element.unreleased()) is not None
    }
    if not released:
        return frame
    clone = frame.copy()
    for name, whole in released.items():
        member = frame.members[name]
        axes = np.swapaxes(member.element.axes(frame.chord(name)), -1, -2)
        body = frame.nodes[member.start].body
        if body is not None and body == frame.nodes[member.end].body:
            axes = frame.bodies[body].axes @ axes
        ends = [member.start, member.end]
        for end in sorted({end for end, _ in member.element.releases}):
            free = [k for side, k in member.element.releases if side == end]
            stiffness = np.where(np.isin(np.arange(6), free), 0.0, np.inf)
            node, ends[end] = ends[end], f"{name}\n{end}"  # no name that a user gives
            clone.nodes[ends[end]] = frame.nodes[node]
            clone.joints[ends[end]] = JointLink(ReleasedEnd(stiffness, axes), ends[end], node)
        clone.members[name] = member._replace(element=whole, start=ends[0], end=ends[1])
    return clone


def _bar(element: LineElement) -> bool:
    """Whether a member is hinged about one axis at both ends and not cut: a truss's bar, straight across that axis.

    Between joints its one piece would bend and, too stiff by a fifth, buckle.
    """
    return element.segments == 1 and any({(0, k), (1, k)} <= set(element.releases) for k in (4, 5))
