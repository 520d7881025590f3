"""Differences between two descriptions, loads apart, which decide what of an earlier plan can be reused.

If there are none the plan is reused; if members are the same, what is known of the members.
"""

from __future__ import annotations

from operator import attrgetter

from ..cache import alike
from ..description import Description

# Fields on which numbering and member stiffness depend; and those that connect nodes with each other and the ground.
_MEMBERS = frozenset({"nodes", "members", "bodies"})
_LINKS = frozenset({"joints", "ties", "supports", "offsets", "bodies"})
_PARTS = _MEMBERS | _LINKS | {"masses", "size"}
_values = attrgetter(*_PARTS)


class Differences:
    """The fields in which two descriptions differ, loads apart.

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
        # identical objects and empty ones need no comparison
        self._parts = {part for part, a, b in each if a is not b and (a or b) and not alike(a, b)}

    @property
    def none(self) -> bool:
        """Whether there are no differences: the same names and the same elements and arrays."""
        return not self._parts

    @property
    def connections(self) -> bool:
        """Whether members differ in nodes, or nodes in names or bodies; elements and positions may differ."""
        return "bodies" in self._parts or self._nodes or self._ends

    @property
    def moved(self) -> bool:
        """Whether nodes differ."""
        return "nodes" in self._parts

    @property
    def elements(self) -> bool:
        """Whether members differ."""
        return "members" in self._parts

    @property
    def _nodes(self) -> bool:
        """Whether nodes differ in names or bodies."""
        one, other = self.one.nodes, self.other.nodes
        return self.moved and (
            [*one] != [*other] or [node.body for node in one.values()] != [node.body for node in other.values()]
        )

    @property
    def _ends(self) -> bool:
        """Whether members differ in names or in the nodes that they connect."""
        one, other = self.one.members, self.other.members
        return self.elements and (
            [*one] != [*other] or any(a[1:] != b[1:] for a, b in zip(one.values(), other.values(), strict=True))
        )

    @property
    def links(self) -> bool:
        """Whether joints, ties, supports, offsets or bodies differ, or the arms of rigid links."""
        rigid = "nodes" in self._parts and any(tie.rigid for tie in self.one.ties)
        return rigid or not self._parts.isdisjoint(_LINKS)
