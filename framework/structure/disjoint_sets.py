"""Sets of things that are joined two by two."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Generic, TypeVar

Thing = TypeVar("Thing", int, str)


class DisjointSets(Generic[Thing]):
    """Sets, each known by the least of its members (Tarjan, J. ACM 22 (1975) 215-225); what was not joined is alone."""

    def __init__(self) -> None:
        self._above: dict[Thing, Thing] = {}

    def find(self, member: Thing) -> Thing:
        """The least member of the set that something is in."""
        above = self._above
        while (nearer := above.get(member, member)) != member:
            above[member] = above.get(nearer, nearer)
            member = nearer
        return member

    def join(self, one: Thing, other: Thing) -> bool:
        """Make one set of those that two are in; False where they are in one."""
        a, b = self.find(one), self.find(other)
        if a == b:
            return False
        self._above[max(a, b)] = min(a, b)
        return True


def joining(pairs: Iterable[tuple[Thing, Thing]]) -> list[bool]:
    """Of each pair whether it joins two sets; False where that closes a loop."""
    sets = DisjointSets[Thing]()
    return [sets.join(one, other) for one, other in pairs]


def least_of_sets(members: Iterable[Thing], pairs: Iterable[tuple[Thing, Thing]]) -> dict[Thing, Thing]:
    """By member the least of those with which pairs join it."""
    sets = DisjointSets[Thing]()
    for one, other in pairs:
        sets.join(one, other)
    return {member: sets.find(member) for member in members}
