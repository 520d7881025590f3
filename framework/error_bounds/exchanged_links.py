"""Links for edges that are in the tree of some batch entries only, and the coordinates that follow from others.

Such an edge becomes a link of the tree to an extra end with coordinates of its own, so that its displacement is never
the difference of two larger ones. A closure, an ideal link without springs, ties that end to the node where it belongs:
at some entries it determines the coordinates of the end, at the others those of the edge that this one replaces.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from typing import TypeAlias

import numpy as np

from ..structure.edge import Edge
from ..structure.parts import Row, Value
from ..structure.tree import JointTree
from .kinematic_edge import KinematicEdge, Real

CLOSURE = "closure"
_SIX = range(6)
# By coordinate: its row over the unknowns, and by (number of the link, component) the factor of its correction.
Dependents: TypeAlias = dict[int, tuple[dict[int, Real], dict[tuple[int, int], Real]]]


def exchanged_links(count: int, links: Iterable[KinematicEdge]) -> tuple[list[KinematicEdge], list[KinematicEdge]]:
    """Links of the tree to extra ends, numbered after the nodes, and the closures of these ends.

    Parameters
    ----------
    count
        Number of nodes.
    links
        The exchanged edges, in order, as links from their first nodes.
    """
    out, closures = [], []
    for end, link in enumerate(links, count):
        edge = link.edge
        closure = Edge(None, CLOSURE, end, edge.second, tuple(_SIX), (0.0,) * 6, edge.axes, tuple({} for _ in _SIX))
        out.append(replace(link, second=end))
        closures.append(replace(link, edge=closure, first=end, sign=0.0))
    return out, closures


def dependent_coordinates(tree: JointTree, links: Sequence[KinematicEdge]) -> Dependents:
    """Coordinates that follow from the unknowns where loops are closed.

    Parameters
    ----------
    tree
        The tree of the batch.
    links
        All links, closures last.
    """
    numbers = {link.edge: number for number, link in enumerate(links)}
    closures = dict(zip(tree.exchanged, range(len(links) - len(tree.exchanged), len(links)), strict=True))
    given = [(numbers[each.edge], each.component) for each in tree.elimination.given]

    def entered(row: Row, source: Row, closing: dict[tuple[int, int], Value]) -> None:
        by = {given[index]: np.asarray(value) for index, value in source.items()}
        by |= {where: np.asarray(value) for where, value in closing.items()}
        out[key] = {k: np.asarray(value) for k, value in row.items() if k >= 0}, by

    out: Dependents = {}
    for key, row in tree.elimination.rows.items():
        lost = tree.given_up.get(key, {})
        entered(row, tree.elimination.sources[key], {(closures[e], k): -value for (e, k), value in lost.items()})
    for edge, each in tree.exchanged.items():
        end = links[numbers[edge]].child
        for k, (row, source) in enumerate(zip(each.rows, each.sources, strict=True)):
            key = 6 * end + k
            entered(row, source, {(closures[edge], k): 1.0 - each.where})
    return out
