"""A plan is compiled once: another load, or another solution of the same frame, takes it up again."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from ..description import Description

_NAMED = ("bodies", "nodes", "members", "joints", "masses")
_VALUED = ("supports", "offsets")


def same_structure(one: Description, other: Description) -> bool:
    """Whether two descriptions differ in loads alone: the same objects by name, the same numbers held."""
    return (
        one.shape == other.shape
        and all(_identical(getattr(one, part), getattr(other, part)) for part in _NAMED)
        and all(_identical_values(getattr(one, part), getattr(other, part)) for part in _VALUED)
        and one.ties == other.ties
    )


def _identical(one: Mapping[Any, object], other: Mapping[Any, object]) -> bool:
    return one.keys() == other.keys() and all(one[key] is other[key] for key in one)


def _identical_values(one: Mapping[str, Mapping[int, object]], other: Mapping[str, Mapping[int, object]]) -> bool:
    return one.keys() == other.keys() and all(_identical(one[key], other[key]) for key in one)
