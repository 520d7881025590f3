"""A plan restricted to some entries of its batch: its nodes, members, masses and loads there."""

from __future__ import annotations

import copy

from ..batch import Shape
from ..batched.plan import Plan
from ..described.at_entries import members_at
from ..entries import Change
from ..structure.topology import Topology


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
    own.frame = members_at(plan.frame, change, shape)
    own.topology = Topology(own.frame, whole.number, whole.bodies, whole.counts, whole.ends)
    return own
