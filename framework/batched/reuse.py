"""What of a description a plan depends on, its loads apart: where that is the same, the plan is taken up again, and
where members alone are, what is known of these."""

from __future__ import annotations

from operator import attrgetter

from ..cache import alike
from ..description import Description

# What nodes and members, and the stiffness of these, are made of; and what holds nodes to each other and to the ground.
_MEMBERS = frozenset({"nodes", "members", "bodies"})
_LINKS = frozenset({"joints", "ties", "supports", "offsets", "bodies"})
_PARTS = _MEMBERS | _LINKS | {"masses", "size"}
_values = attrgetter(*_PARTS)
_NOT_NODES, _NOT_ELEMENTS = _MEMBERS - {"nodes"}, _MEMBERS - {"members"}


class Differences:
    """What two descriptions differ in, their loads apart.

    Parameters
    ----------
    one, other
        The descriptions.
    """

    def __init__(self, one: Description, other: Description) -> None:
        self.one, self.other = one, other
        if one.shape != other.shape:
            self._parts = set(_PARTS)
            return
        each = zip(_PARTS, _values(one), _values(other), strict=True)
        # what is one object, and of what there is nothing, takes no look inside
        self._parts = {part for part, a, b in each if a is not b and (a or b) and not alike(a, b)}

    @property
    def none(self) -> bool:
        """Whether there are none: the same parts by name, the same numbers held."""
        return not self._parts

    @property
    def members(self) -> bool:
        """Whether members are others, or between other places."""
        return not self._parts.isdisjoint(_MEMBERS)

    @property
    def connections(self) -> bool:
        """Whether members are others, or between other nodes, wherever these lie."""
        one, other = self.one.nodes, self.other.nodes
        return (
            not self._parts.isdisjoint(_NOT_NODES)
            or list(one) != list(other)
            or [node.body for node in one.values()] != [node.body for node in other.values()]
        )

    @property
    def elements(self) -> bool:
        """Whether members are others between the same nodes, and nothing else of nodes and bodies is."""
        one, other = self.one.members, self.other.members
        return (
            "members" in self._parts
            and self._parts.isdisjoint(_NOT_ELEMENTS)
            and list(one) == list(other)
            and all(a[1:] == b[1:] for a, b in zip(one.values(), other.values(), strict=True))
        )

    @property
    def links(self) -> bool:
        """Whether joints, ties, supports or bodies have other numbers, as what is rigid has where its nodes move."""
        rigid = "nodes" in self._parts and any(tie.rigid for tie in self.one.ties)
        return rigid or not self._parts.isdisjoint(_LINKS)
