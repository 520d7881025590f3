"""Spanning forests of a graph, rooted at the ground, and the edges that close loops."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from .disjoint_sets import joining

End = TypeVar("End", int, str)
End_co = TypeVar("End_co", covariant=True)
Link = TypeVar("Link")
Joined = TypeVar("Joined", bound="Joins[Any]")


class Joins(Protocol[End_co]):
    """A connection of two things: an edge between two nodes, or a joint between two links."""

    @property
    def first(self) -> End_co:
        """Node or link at its first end."""

    @property
    def second(self) -> End_co:
        """Node or link at its second end."""


@dataclass(frozen=True)
class Branch(Generic[Link, End]):
    """An edge of a tree between `parent` and `child`; `sign` is 1 if the child is the edge's second end, else -1."""

    edge: Link
    parent: End
    child: End
    sign: float

    @property
    def is_reversed(self) -> bool:
        """Whether the child is the edge's first end."""
        return self.sign < 0.0


def spanning(edges: Iterable[Joined]) -> tuple[list[Joined], list[Joined]]:
    """Spanning forest by Kruskal's algorithm, preferring earlier edges; and the remaining edges, which close loops."""
    edges = list(edges)
    joins = joining([(edge.first, edge.second) for edge in edges])
    each = list(zip(edges, joins, strict=True))
    return [edge for edge, joined in each if joined], [edge for edge, joined in each if not joined]


def rooted(edges: Iterable[Joined], ground: End, roots: Iterable[End] = ()) -> list[Branch[Joined, End]]:
    """Branches in breadth-first order from the ground, the given roots and further roots.

    Edges that would close a loop are left out, so that each end is as near to its root as possible.
    """
    at: dict[End, list[Joined]] = {ground: [], **{root: [] for root in roots}}
    for edge in edges:
        at.setdefault(edge.first, []).append(edge)
        at.setdefault(edge.second, []).append(edge)
    branches: list[Branch[Joined, End]] = []
    seen: set[End] = set()
    for root in at:
        queue = deque([root] if root not in seen else [])
        seen.add(root)
        while queue:
            parent = queue.popleft()
            for edge in at[parent]:
                child = edge.second if edge.first == parent else edge.first
                if child not in seen:
                    seen.add(child)
                    branches.append(Branch(edge, parent, child, 1.0 if child == edge.second else -1.0))
                    queue.append(child)
    return branches
