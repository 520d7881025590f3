"""The common form of joints, rigid links, ties and supports: springs and constraints between two nodes."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array
from ..cache import PATTERNS
from .disjoint_sets import least_of_sets
from .parts import Row, Value, add_row, product

GROUND = -1
# Components that a screw couples: uz and rz in the joint's axes.
ALONG, ABOUT = 2, 5


@dataclass(frozen=True, eq=False)
class Edge:
    """Connection between two nodes, or a node and the ground, by six springs from 0 to inf.

    Attributes
    ----------
    name
        Name of the joint, or of the supported node; None for ties and rigid links.
    kind
        ``joint``, ``support``, ``rigid`` or ``tie``; ``closure`` for the connection between a node and the end of a
        joint that is in the joint tree at some batch entries only.
    first, second
        Node numbers, GROUND for the ground.
    ideal
        Indices of the constrained components.
    stiffness
        Stiffness of the six springs, 0.0 where there is none or the component is ideal.
    axes
        Axes of the springs as columns in global components, (..., 3, 3); None for the global axes.
    offset
        Imposed relative displacement, for each component a row over the right-hand-side parameters.
    pitch
        Advance along z per radian about z, length.
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
        """Rank for the choice of the joint tree: number of ideal components, then largest stiffness."""
        return len(self.ideal), max(k if isinstance(k, float) else float(np.max(k)) for k in self.stiffness)

    @property
    def stiffest(self) -> Value:
        """Stiffness of the stiffest spring at each batch entry."""
        out: Value = max((k for k in self.stiffness if not isinstance(k, np.ndarray)), default=0.0)
        for k in self.stiffness:
            out = np.maximum(out, k) if isinstance(k, np.ndarray) else out
        return out

    @property
    def softest(self) -> NDArray[np.bool_]:
        """Which of the rotations rx, ry, rz have the softest springs, (3,)."""
        most = [np.inf if k in self.ideal else float(np.max(self.stiffness[k])) for k in (3, 4, 5)]
        return np.array([value == min(most) for value in most])

    def elastic(self, moved: list[Row]) -> list[Row]:
        """Rows of the displacement on which the springs act: `moved` less the offset and the advance of a screw."""
        out = [dict(row) for row in moved]
        for row, offset in zip(out, self.offset, strict=True):
            add_row(row, offset, -1.0)
        add_row(out[ALONG], moved[ABOUT], product(-1.0, self.pitch))
        return out


def strengths(edges: Iterable[Edge]) -> list[tuple[int, float]]:
    """The rank of each edge, see `Edge.strength`."""
    return [edge.strength for edge in edges]


def preference(ends: list[tuple[int, int]], strengths: Iterable[tuple[int, float]]) -> list[int]:
    """Indices of edges in order of preference for the joint tree: set by set of connected nodes, the strongest first.

    Edges of different sets, which only the ground connects, never compete for a place in the tree. Which of them is
    stronger then does not change the order, so that frames that differ only in that share a program.

    Parameters
    ----------
    ends
        First and second node of each edge.
    strengths
        Rank of each edge, see `Edge.strength`.
    """

    def sets() -> dict[int, int]:
        return least_of_sets([max(pair) for pair in ends], [pair for pair in ends if min(pair) != GROUND])

    least: dict[int, int] = PATTERNS.found(("sets", *ends), sets, len(ends))
    keys = [(least[max(pair)], -ideal, -stiffest) for pair, (ideal, stiffest) in zip(ends, strengths, strict=True)]
    return sorted(range(len(keys)), key=keys.__getitem__)
