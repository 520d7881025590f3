"""Disjoint sets (union-find), each known by its least member."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

Thing = TypeVar("Thing", int, str)


class DisjointSets(Generic[Thing]):
    """Disjoint sets, each known by its least member (Tarjan, J. ACM 22 (1975) 215-225).

    A member that was never joined is a set of its own.
    """

    def __init__(self) -> None:
        self._above: dict[Thing, Thing] = {}

    def find(self, member: Thing) -> Thing:
        """The least member of the set that contains `member`."""
        above = self._above
        while (nearer := above.get(member, member)) != member:
            above[member] = above.get(nearer, nearer)
            member = nearer
        return member

    def join(self, one: Thing, other: Thing) -> bool:
        """Join the sets of two members; False if they are in the same set already."""
        a, b = self.find(one), self.find(other)
        if a == b:
            return False
        self._above[max(a, b)] = min(a, b)
        return True


def joining(pairs: Iterable[tuple[Thing, Thing]]) -> list[bool]:
    """For each pair in turn, whether it joins two sets; False where it closes a loop."""
    sets = DisjointSets[Thing]()
    return [sets.join(one, other) for one, other in pairs]


def least_of_sets(members: Iterable[Thing], pairs: Iterable[tuple[Thing, Thing]]) -> dict[Thing, Thing]:
    """For each member the least member of its set, after joining all pairs."""
    sets = DisjointSets[Thing]()
    for one, other in pairs:
        sets.join(one, other)
    return {member: sets.find(member) for member in members}
