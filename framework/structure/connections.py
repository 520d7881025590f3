"""Joints, ties and supports as what displacements are made of; of frames on supports alone, by what these hold."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from ..batch import ZERO
from .edge import Edge
from .forest import Branch
from .parts import Row
from .topology import Topology

TreeEdge: TypeAlias = Branch[Edge, int]


class Connections(NamedTuple):
    """What a joint tree is made of, and no number of the batch where supports hold nodes at zero and that is all.

    Attributes
    ----------
    edges
        Joints, rigid links, ties and supports.
    branches
        Those of the tree, parents before children.
    rows
        For each node on an edge: six rows over the unknowns and the right-hand-side parameters.
    springs
        Rows of the springs.
    """

    edges: list[Edge]
    branches: list[TreeEdge]
    rows: dict[int, list[Row]]
    springs: list[Row]


def of_supports(topology: Topology) -> tuple[object, ...] | None:
    """What the connections of a frame follow from that has members and supports at zero alone; None of other frames.

    Parameters
    ----------
    topology
        Its nodes and members.
    """
    frame, number = topology.frame, topology.number
    if frame.joints or frame.ties or frame.bodies:
        return None
    for given in frame.supports.values():
        for value in given.values():
            if value is not ZERO and value.any():
                return None
    supports = tuple((node, number[node], *given) for node, given in frame.supports.items())
    return len(number), topology.ends.tobytes(), supports
