"""The connections of a frame by joints, ties and supports, cached for frames that have supports alone."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

from ..batch import ZERO
from .edge import Edge
from .forest import Branch
from .parts import Row
from .topology import Topology

TreeEdge: TypeAlias = Branch[Edge, int]


class Connections(NamedTuple):
    """The parts of a joint tree; free of numbers of the batch if the frame has only supports at zero.

    Attributes
    ----------
    edges
        Joints, rigid links, ties and supports.
    branches
        Edges of the tree, parents before children.
    rows
        For each node on an edge: the rows of its six displacements over unknowns and right-hand-side parameters.
    springs
        Rows of the joint springs.
    """

    edges: list[Edge]
    branches: list[TreeEdge]
    rows: dict[int, list[Row]]
    springs: list[Row]


def of_supports(topology: Topology) -> tuple[object, ...] | None:
    """Key of the connections of a frame that has only members and supports at zero; None for other frames.

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
