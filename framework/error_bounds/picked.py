"""The equations in extended precision at some entries of a batch alone: what they hold is that of these entries."""

from __future__ import annotations

import copy
from dataclasses import replace

from ..batch import Array, Shape, distinct
from ..batched.plan import Plan
from ..description import Description
from ..protocol import PointElement
from ..solvers.evaluation import Picked
from ..stacking import changed
from ..structure.topology import Topology
from .applied import AppliedLoads
from .deformations import springs
from .equilibrium import Statics, imposed_on, six
from .kinematics import FrameKinematics


class PickedStatics(Statics):
    """A frame at some entries of its batch in extended precision.

    Parameters
    ----------
    plan
        The compiled frame.
    kinematics
        Its kinematics, at the whole batch.
    picked
        The entries (m,).
    """

    def __init__(self, plan: Plan, kinematics: FrameKinematics, picked: Picked) -> None:
        own = plan_at(plan, picked)
        self.plan = plan
        self.kinematics = kinematics.mapped(picked.of_array)
        self.springs = springs(own)
        self.loads = AppliedLoads.of(own, self.springs)
        links, ndim = kinematics.links, len(plan.frame.shape)
        self.stiffness = [picked.of_array(six(link.edge.stiffness, ndim), 1) for link in links]
        imposed = [imposed_on(plan, link) for link in links]
        self.imposed = [None if each is None else picked.of_array(each, 1) for each in imposed]


class _PickedMass(PointElement):
    """A mass at some entries of its batch."""

    def __init__(self, element: PointElement, picked: Picked) -> None:
        self.matrix = picked.of_array(element.mass_matrix(), 2)

    @property
    def shape(self) -> Shape:
        """Batch shape."""
        return self.matrix.shape[:-2]

    def mass_matrix(self) -> Array:
        """Mass in global axes, (..., 6, 6)."""
        return self.matrix


def plan_at(plan: Plan, picked: Picked) -> Plan:
    """The nodes and members of a plan at some entries of its batch, and what acts on them."""
    own, whole = copy.copy(plan), plan.topology
    own.frame = frame_at(plan.frame, picked)
    own.topology = Topology(own.frame, whole.number, whole.bodies, whole.counts, whole.ends)
    return own


def frame_at(frame: Description, picked: Picked) -> Description:
    """Nodes, members, masses and loads of a frame at some entries of its batch; its joints and supports as they are."""

    def at(array: Array, trailing: int) -> Array:
        return array if array.ndim == trailing else picked.of_array(array, trailing)

    own = [member.element for member in frame.members.values()]
    leaders, which = distinct(own)
    cut = [own[k].cut(at) if own[k].shape else own[k] for k in leaders]
    clone = copy.copy(frame)
    clone._shape = picked.index[0].shape
    clone.bodies = {
        name: replace(body, origin=at(body.origin, 1), axes=at(body.axes, 2)) for name, body in frame.bodies.items()
    }
    clone.nodes = {name: node._replace(coordinates=at(node.coordinates, 1)) for name, node in frame.nodes.items()}
    clone.members = {
        name: member._replace(element=cut[k])
        for (name, member), k in zip(frame.members.items(), which.tolist(), strict=True)
    }
    clone.masses = {
        name: mass._replace(element=_PickedMass(mass.element, picked)) for name, mass in frame.masses.items()
    }
    clone.loads = {node: [(k, at(value, 0)) for k, value in given] for node, given in frame.loads.items()}
    clone.member_loads = {member: [changed(load, at) for load in given] for member, given in frame.member_loads.items()}
    clone.weight = None if frame.weight is None else at(frame.weight, 1)
    return clone
