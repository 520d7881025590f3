"""Loops with redundant ideal components, and their states of self-stress.

An ideal component that follows from the others of its loop is redundant: equilibrium alone does not determine which of
them carry the load. Any two distributions differ by states of self-stress, forces in equilibrium without a load.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from ..batched.plan import Plan
from ..entries import WHOLE, Change, Entries
from ..structure.disjoint_sets import DisjointSets
from ..structure.edge import GROUND
from ..structure.topology import Index
from .exchanged_links import CLOSURE
from .kinematic_edge import KinematicEdge, Real

# Links among which the load is shared; the forces in rigid links and ties follow from theirs.
SHARING = ("joint", "support")
# Distance, relative to their coordinates, up to which joints count as being in one place.
_ONE_PLACE = 1e-9


@dataclass(frozen=True)
class RedundantLoops:
    """Loops with edges in common, some ideal components of which are redundant.

    Attributes
    ----------
    links
        Numbers of their links, (k,), those of the tree first, parents first.
    self_stresses
        By redundant component: forces in ideal components of links that close a loop, by (number of the link,
        component).
    length
        Length by which moments are divided to compare them with forces, (...), in m: see `_length`.
    """

    links: Index
    self_stresses: list[dict[tuple[int, int], Real]]
    length: Real

    def mapped(self, change: Change) -> RedundantLoops:
        """A copy with `change`, given the number of trailing axes, applied to every array."""
        each = [{key: change(value, 0) for key, value in own.items()} for own in self.self_stresses]
        return RedundantLoops(self.links, each, change(self.length, 0))


def redundant_loops(plan: Plan, links: Sequence[KinematicEdge], entries: Entries = WHOLE) -> list[RedundantLoops]:
    """The loops of a frame that have redundant components, which do not depend on the choice of closing edges.

    Parameters
    ----------
    plan
        The compiled frame.
    links
        Edges of the tree, parents first, then those that close a loop, at the entries.
    entries
        At which of the batch.
    """
    elimination = plan.tree.elimination
    if not elimination.self_stresses:
        return []
    sets = _joined(links)
    numbers = {link.edge: number for number, link in enumerate(links)}
    found: dict[int, list[dict[tuple[int, int], Real]]] = {}
    for constraint, source in elimination.self_stresses.items():
        given = ((elimination.given[index], entries(np.asarray(value), 0)) for index, value in source.items())
        own = {(numbers[each.edge], each.component): value for each, value in given}
        found.setdefault(sets.find(numbers[elimination.given[constraint].edge]), []).append(own)
    members: dict[int, list[int]] = {}
    for number in range(len(links)):
        members.setdefault(sets.find(number), []).append(number)
    out = []
    for name, stresses in found.items():
        sharing = [links[k] for k in members[name] if links[k].edge.kind in SHARING and links[k].edge.ideal]
        if sharing:
            out.append(RedundantLoops(np.array(members[name]), stresses, _length(plan, sharing, entries)))
    return out


def _joined(links: Sequence[KinematicEdge]) -> DisjointSets[int]:
    """Numbers of links in disjoint sets: loops with edges in common form one set."""
    above = {link.child: number for number, link in enumerate(links) if link.sign}
    sets = DisjointSets[int]()
    for number, link in enumerate(links):
        if not link.sign and link.edge.ideal and link.edge.kind != CLOSURE:
            ways = _way(links, above, link.first), _way(links, above, link.second)
            for each in set(ways[0]) ^ set(ways[1]):
                sets.join(number, each)
    return sets


def _way(links: Sequence[KinematicEdge], above: dict[int, int], node: int) -> list[int]:
    """Numbers of the links from a node to the root of its tree."""
    out = []
    while node != GROUND and node in above:
        out.append(above[node])
        node = links[above[node]].parent
    return out


def _length(plan: Plan, links: Sequence[KinematicEdge], entries: Entries) -> Real:
    """Root of the mean square distance of joints and supports from their middle, and of the advance of screws, (...);
    one where all of them are in one place."""
    places = [entries(plan.topology.position(link.second), 1) for link in links]
    middle = sum(places, np.zeros(3)) / len(places)
    square = sum((np.sum((place - middle) ** 2, axis=-1) for place in places), np.zeros(()))
    far = sum((np.sum(place**2, axis=-1) for place in places), np.zeros(()))
    square = np.where(square > _ONE_PLACE**2 * far, square, 0.0)
    square = sum((np.asarray(link.lead, np.float64) ** 2 for link in links if link.lead is not None), square)
    return np.where(square > 0.0, np.sqrt(square / len(links)), 1.0)
