"""Names by which the parts of a frame are called."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from types import MappingProxyType

from .errors import FrameError

# Greatest number of names in a message.
_MOST = 12


def plain(what: str, given: str) -> str:
    """A name as plain text, whatever kind of string it was given as, such as one out of an array."""
    if not isinstance(given, str) or not given:
        raise FrameError(f"{what} is named {given!r}: give a non-empty string")
    return str(given)


def new(what: str, given: str, *known: Collection[str]) -> str:
    """The name of a new object, checked."""
    name = given if type(given) is str and given else plain(what, given)
    for names in known:
        if name in names:
            raise FrameError(f"{what} {name!r} exists already: choose another name")
    return name


def found(what: str, given: str, known: Collection[str], aliases: Mapping[str, str] = MappingProxyType({})) -> str:
    """The name of an existing object, which may be given by an alias."""
    name = given if type(given) is str and given else plain(what, given)
    name = aliases.get(name, name)
    if name not in known:
        listed = [repr(name) for name in known]
        more = " ..." if len(listed) > _MOST else ""
        text = f"known are {', '.join(listed[:_MOST])}{more}" if listed else "none is defined yet"
        raise FrameError(f"{what} {name!r} is unknown: {text}")
    return name
