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
    """The fields in which two descriptions differ, loads apart; each is compared when it is first asked for.

    Parameters
    ----------
    one, other
        The descriptions.
    """

    def __init__(self, one: Description, other: Description) -> None:
        self.one, self.other = one, other
        self._known: dict[str, bool] = {} if one.shape == other.shape else dict.fromkeys(_PARTS, True)

    def _differs(self, part: str) -> bool:
        """Whether the descriptions differ in a field."""
        found = self._known.get(part)
        if found is None:
            a, b = getattr(self.one, part), getattr(self.other, part)
            # identical objects and empty ones need no comparison
            found = self._known[part] = a is not b and bool(a or b) and not alike(a, b)
        return found

    @property
    def none(self) -> bool:
        """Whether there are no differences: the same names and the same elements and arrays."""
        return not any(map(self._differs, _PARTS))

    @property
    def connections(self) -> bool:
        """Whether members differ in nodes, or nodes in names or bodies; elements and positions may differ."""
        return self._differs("bodies") or self._nodes or self._ends

    @property
    def moved(self) -> bool:
        """Whether nodes differ."""
        return self._differs("nodes")

    @property
    def elements(self) -> bool:
        """Whether members differ."""
        return self._differs("members")

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
        return any(map(self._differs, _LINKS)) or (any(tie.rigid for tie in self.one.ties) and self.moved)
