"""What of a description a plan depends on, its loads apart: where that is the same, the plan is taken up again."""

from __future__ import annotations

from ..cache import alike
from ..description import Description

_PARTS = ("bodies", "nodes", "members", "joints", "masses", "supports", "offsets", "ties", "size")


def same_structure(one: Description, other: Description) -> bool:
    """Whether two descriptions differ in loads alone: the same parts by name, the same numbers held."""
    return one.shape == other.shape and all(alike(getattr(one, part), getattr(other, part)) for part in _PARTS)
