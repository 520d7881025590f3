"""A plan restricted to some entries of its batch: its nodes, members, masses and loads there."""

from __future__ import annotations

import copy
from dataclasses import replace

from ..batch import Array, Shape, distinct
from ..batched.plan import Plan
from ..description import Description
from ..entries import Change
from ..protocol import PointElement
from ..stacking import changed
from ..structure.topology import Topology


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


def plan_at(plan: Plan, change: Change, shape: Shape) -> Plan:
    """A plan restricted to some entries of its batch: nodes, members and loads there; the joint tree stays whole.

    Parameters
    ----------
    plan
        The compiled frame.
    change
        Function of an array and its number of trailing axes, which takes these entries out of it.
    shape
        Their batch shape.
    """
    own, whole = copy.copy(plan), plan.topology
    own.frame = frame_at(plan.frame, change, shape)
    own.topology = Topology(own.frame, whole.number, whole.bodies, whole.counts, whole.ends)
    return own


def frame_at(frame: Description, change: Change, shape: Shape) -> Description:
    """Nodes, members, masses and loads of a frame at some entries of its batch; its joints and supports as they are."""

    def at(array: Array, trailing: int) -> Array:
        return array if array.ndim == trailing else change(array, trailing)

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
