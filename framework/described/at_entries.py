"""A frame at some entries of its batch."""

from __future__ import annotations

import copy
from dataclasses import dataclass, replace

import numpy as np

from ..batch import Array, Shape, distinct
from ..description import Description
from ..entries import Change
from ..joint_protocol import JointElement
from ..protocol import PointElement
from ..stacking import changed


class _MassAt(PointElement):
    """A mass at some entries of its batch."""

    def __init__(self, element: PointElement, change: Change) -> None:
        self.matrix = change(element.mass_matrix(), 2)

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.matrix.shape[:-2]

    def mass_matrix(self) -> Array:
        """Mass matrix in global axes, (..., 6, 6)."""
        return self.matrix


@dataclass(frozen=True, eq=False)
class _JointAt(JointElement):
    """The springs and the clearance of a joint at some entries of its batch."""

    stiffness: Array
    axes: Array | None
    clearance: Array
    clearance_directions: tuple[int, ...]
    pitch: Array

    @property
    def shape(self) -> Shape:
        """Batch shape: the broadcast of stiffness, clearance, axes and pitch."""
        axes = () if self.axes is None else self.axes.shape[:-2]
        return np.broadcast_shapes(self.stiffness.shape[:-1], self.clearance.shape, axes, self.pitch.shape)

    def matrix(self) -> Array:
        """Stiffness of the two nodes, (..., 12, 12)."""
        return self.springs_matrix()

    def typical(self) -> JointElement:
        """The same joint with the stiffest springs of these entries, and without clearance."""
        stiffest = self.stiffness.reshape(-1, 6).max(axis=0)
        return replace(self, stiffness=stiffest, clearance=np.zeros(()), clearance_directions=())


def members_at(frame: Description, change: Change, shape: Shape) -> Description:
    """Nodes, members, masses and loads of a frame at some entries of its batch; its joints and supports as they are.

    Parameters
    ----------
    frame
        The frame.
    change
        Function of an array and its number of trailing axes, which takes these entries out of it.
    shape
        Their batch shape.
    """
    at = _where_varying(change)
    own = [member.element for member in frame.members.values()]
    leaders, which = distinct(own)
    cut = [own[k].cut(at) if own[k].shape else own[k] for k in leaders]
    clone = copy.copy(frame)
    clone.shape = shape
    clone.bodies = {
        name: replace(body, origin=at(body.origin, 1), axes=at(body.axes, 2)) for name, body in frame.bodies.items()
    }
    clone.nodes = {name: node._replace(coordinates=at(node.coordinates, 1)) for name, node in frame.nodes.items()}
    clone.members = {
        name: member._replace(element=cut[k])
        for (name, member), k in zip(frame.members.items(), which.tolist(), strict=True)
    }
    clone.masses = {name: mass._replace(element=_MassAt(mass.element, at)) for name, mass in frame.masses.items()}
    clone.loads = {node: [(k, at(value, 0)) for k, value in given] for node, given in frame.loads.items()}
    clone.member_loads = {member: [changed(load, at) for load in given] for member, given in frame.member_loads.items()}
    clone.weight = None if frame.weight is None else at(frame.weight, 1)
    return clone


def frame_at(frame: Description, change: Change, shape: Shape) -> Description:
    """A frame at some entries of its batch, with its size as it is over the whole batch.

    Parameters
    ----------
    frame, change, shape
        As for `members_at`.
    """
    at, clone = _where_varying(change), members_at(frame, change, shape)
    clone.joints = {name: joint._replace(element=_joint_at(joint.element, at)) for name, joint in frame.joints.items()}
    clone.supports = {node: {k: at(value, 0) for k, value in given.items()} for node, given in frame.supports.items()}
    clone.offsets = {joint: {k: at(value, 0) for k, value in given.items()} for joint, given in frame.offsets.items()}
    clone.absent = None if frame.absent is None else at(frame.absent, 0)
    clone.made_from, clone._shapes = None, {shape: "entries of the batch"}
    return clone


def _joint_at(joint: JointElement, at: Change) -> JointElement:
    if not joint.shape:
        return joint
    axes = None if joint.axes is None else at(joint.axes, 2)
    return _JointAt(
        at(joint.stiffness, 1), axes, at(joint.clearance, 0), joint.clearance_directions, at(joint.pitch, 0)
    )


def _where_varying(change: Change) -> Change:
    """The same change, of arrays with batch axes alone."""

    def at(array: Array, trailing: int) -> Array:
        return array if array.ndim == trailing else change(array, trailing)

    return at
