"""Restriction of results to the connected part of the frame that they belong to, so that other parts are not solved."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import signature
from typing import Any, TypeVar, cast

from ..batch import Array
from ..description import Description
from .linear import LinearResults

Result = TypeVar("Result", bound=Callable[..., Array])


def of_part(node: Callable[[Description, str], str | None]) -> Callable[[Result], Result]:
    """Decorator: compute a result by name from the part of the frame that contains it; `node` returns its node."""

    def decorate(result: Result) -> Result:
        first = list(signature(result).parameters)[1]

        @wraps(result)
        def found(self: LinearResults, *given: Any, **named: Any) -> Array:
            name = given[0] if given else named.get(first)
            at = node(self.frame, name) if isinstance(name, str) else None
            return result(self.part(at), *given, **named)

        return cast("Result", found)

    return decorate


def of_node(frame: Description, name: str) -> str | None:
    """The node itself."""
    return frame.aliases.get(name, name)


def of_member(frame: Description, name: str) -> str | None:
    """Start of a member; None where it is unknown."""
    return frame.members[name].start if name in frame.members else None


def of_joint(frame: Description, name: str) -> str | None:
    """First node of a joint; None where it is unknown."""
    return frame.joints[name].first if name in frame.joints else None


def node_of(frame: Description, name: str, kind: str) -> str | None:
    """A node in the part of the frame that contains a result, of a kind such as ``joint_force``; None if unknown."""
    if not isinstance(name, str):
        return None
    found = {"end_forces": of_member, "joint_displacement": of_joint, "joint_force": of_joint}.get(kind, of_node)
    return found(frame, name)
