"""What of a description a plan depends on, its loads apart: where that is the same, the plan is taken up again, and
where members alone are, what is known of these."""

from __future__ import annotations

from ..cache import alike
from ..description import Description

# What nodes and members, and the stiffness of these, are made of.
_MEMBERS = ("nodes", "members", "bodies")
_PARTS = (*_MEMBERS, "joints", "masses", "supports", "offsets", "ties", "size")


# What holds nodes to each other and to the ground.
_LINKS = ("joints", "ties", "supports", "offsets", "bodies")


def same_structure(one: Description, other: Description) -> bool:
    """Whether two descriptions differ in loads alone: the same parts by name, the same numbers held."""
    return _same(one, other, _PARTS)


def same_members(one: Description, other: Description) -> bool:
    """Whether two descriptions have the same members between the same places."""
    return _same(one, other, _MEMBERS)


def same_connections(one: Description, other: Description) -> bool:
    """Whether two descriptions have the same members, between nodes that may lie in other places."""
    return (
        list(one.nodes) == list(other.nodes)
        and _same(one, other, ("members", "bodies"))
        and all(a.body == b.body for a, b in zip(one.nodes.values(), other.nodes.values(), strict=True))
    )


def same_links(one: Description, other: Description, *, moved: bool) -> bool:
    """Whether two descriptions of the same members have the same numbers in joints, ties, supports and bodies.

    Parameters
    ----------
    one, other
        The descriptions.
    moved
        Whether nodes lie in other places, and with them what is rigid between them.
    """
    return _same(one, other, _LINKS) and not (moved and any(tie.rigid for tie in one.ties))


def _same(one: Description, other: Description, parts: tuple[str, ...]) -> bool:
    return one.shape == other.shape and all(alike(getattr(one, part), getattr(other, part)) for part in parts)
