"""Tree members: one end carries the other, so that the deformation of a stiff and short member is a coordinate."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ..batched.plan import Plan
from ..structure.edge import GROUND, Edge
from .deformations import Springs
from .kinematic_edge import KinematicEdge

MEMBER = "member"


def tree_members(plan: Plan, springs: list[Springs]) -> tuple[list[Springs], list[KinematicEdge]]:
    """Springs with the tree members marked, and the links of these; stiffest members are taken first.

    An end can be carried if no other node carries it yet and it does not carry the other end. Frames with moving bodies
    or with coordinates that constraints determine are left unchanged; so are members whose rigid motion is resisted.
    """
    topology = plan.topology
    if plan.tree.elimination.rows or plan.frame.bodies:
        return springs, []
    parents = {branch.child: branch.parent for branch in plan.tree.branches}
    stiff = [
        (float(np.max(each.stiffness[..., at, 1:3], initial=0.0)), number, at)
        for number, each in enumerate(springs)
        if each.balanced
        for at, piece in enumerate(each.pieces)
        if topology.pieces[piece].count == 1
    ]
    determinate = [each.determinate.copy() for each in springs]
    links = []
    for _, number, at in sorted(stiff, key=lambda one: -one[0]):
        start, end = (int(node) for node in springs[number].nodes[at])
        for parent, child, sign in ((start, end, 1), (end, start, -1)):
            if child not in parents and _root(parents, parent) != child:
                parents[child] = parent
                determinate[number][at] = sign
                arm = springs[number].local_axes[..., at, 0, :] * springs[number].length[..., at, None]
                links.append(KinematicEdge(_edge(parent, child), parent, child, 1.0, None, sign * arm))
                break
    return [replace(each, determinate=own) for each, own in zip(springs, determinate, strict=True)], links


def _root(parents: dict[int, int], node: int) -> int:
    while node in parents and node != GROUND:
        node = parents[node]
    return node


def _edge(parent: int, child: int) -> Edge:
    return Edge(None, MEMBER, parent, child, (), (0.0,) * 6, None, ({}, {}, {}, {}, {}, {}))
