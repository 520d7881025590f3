"""What joints, rigid links, ties and supports are alike: springs and constrained components between two nodes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from .disjoint_sets import least_of_sets
from .parts import Row, Value, add_row, product

GROUND = -1
# Components that a screw couples: uz and rz in the joint's axes.
ALONG, ABOUT = 2, 5


@dataclass(frozen=True, eq=False)
class Edge:
    """Connection between two nodes (or the ground): six springs from 0 to inf between them.

    Attributes
    ----------
    name
        The joint, or the node supported; None for ties.
    kind
        ``joint``, ``support``, ``rigid`` or ``tie``; ``closure`` between the end of a joint that is in the tree of some
        entries only, and the node there.
    first, second
        Node numbers, GROUND for the ground.
    ideal
        Components that are constrained.
    stiffness
        By component, 0.0 where there is no spring.
    axes
        (..., 3, 3) as columns, None for the global ones.
    offset
        Imposed relative displacement by component, over the right-hand-side parameters.
    pitch
        Advance along z per radian about z.
    """

    name: str | None
    kind: str
    first: int
    second: int
    ideal: tuple[int, ...]
    stiffness: tuple[Value, ...]
    axes: Array | None
    offset: tuple[Row, ...]
    pitch: Value = 0.0

    @property
    def strength(self) -> tuple[int, float]:
        """Sorts what had better be in the tree: most ideal components, then the stiffest."""
        return len(self.ideal), max(k if isinstance(k, float) else float(np.max(k)) for k in self.stiffness)

    @property
    def stiffest(self) -> Value:
        """Stiffness of its stiffest spring, at each batch entry."""
        out: Value = max((k for k in self.stiffness if not isinstance(k, np.ndarray)), default=0.0)
        for k in self.stiffness:
            out = np.maximum(out, k) if isinstance(k, np.ndarray) else out
        return out

    @property
    def softest(self) -> NDArray[np.bool_]:
        """Components of rotation that turn first, (3,): those of the softest springs."""
        most = [np.inf if k in self.ideal else float(np.max(self.stiffness[k])) for k in (3, 4, 5)]
        return np.array([value == min(most) for value in most])

    def elastic(self, moved: list[Row]) -> list[Row]:
        """What of the relative displacement `moved` is neither imposed nor the advance of a screw."""
        out = [dict(row) for row in moved]
        for row, offset in zip(out, self.offset, strict=True):
            add_row(row, offset, -1.0)
        add_row(out[ALONG], moved[ABOUT], product(-1.0, self.pitch))
        return out


def strengths(edges: Iterable[Edge]) -> list[tuple[int, float]]:
    """What sorts them, see `Edge.strength`."""
    return [edge.strength for edge in edges]


def preference(ends: list[tuple[int, int]], strengths: Iterable[tuple[int, float]]) -> list[int]:
    """Places of edges in order of preference for the tree: the strongest first of those that connect one set of nodes.

    Between edges of different sets, which the ground alone connects, the tree has no choice: which of them is stronger
    does not matter, and frames that differ in nothing else are solved alike.

    Parameters
    ----------
    ends
        First and second node of each edge.
    strengths
        Of each edge, see `Edge.strength`.
    """
    apart = [pair for pair in ends if min(pair) != GROUND]
    least = least_of_sets([max(pair) for pair in ends], apart)
    keys = [(least[max(pair)], -ideal, -stiffest) for pair, (ideal, stiffest) in zip(ends, strengths, strict=True)]
    return sorted(range(len(keys)), key=keys.__getitem__)
