"""Differences between two descriptions, loads apart, which decide what of an earlier plan can be reused.

If there are none the plan is reused; if members are the same, what is known of the members.
"""

from __future__ import annotations

from ..cache import alike
from ..description import Description

# Fields that connect nodes with each other and the ground; and all on which numbering and stiffness depend.
_LINKS = ("joints", "ties", "supports", "offsets", "bodies")
_PARTS = ("nodes", "members", *_LINKS, "masses", "size")


class Differences:
    """The fields in which two descriptions differ, loads apart.

    Parameters
    ----------
    one, other
        The descriptions.
    """

    def __init__(self, one: Description, other: Description) -> None:
        self.one, self.other = one, other
        a, b = vars(one), vars(other)
        # identical objects and empty ones need no comparison
        self._parts = {
            part
            for part in _PARTS
            if one.shape != other.shape
            or (a[part] is not b[part] and (a[part] or b[part]) and not alike(a[part], b[part]))
        }

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
        return not self._parts.isdisjoint(_LINKS) or (any(tie.rigid for tie in self.one.ties) and self.moved)
