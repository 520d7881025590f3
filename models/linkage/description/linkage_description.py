"""What a linkage is: the whole description, which the analyses read and the user changes by its calls."""

from __future__ import annotations

from collections.abc import Mapping
from copy import copy
from typing import Any, Self

from numpy.typing import ArrayLike

from .joining import Joining


class LinkageDescription(Joining):
    """Points, links, joints, drives, springs and loads; see `Linkage`, which adds what can be asked of them.

    Parameters
    ----------
    points
        Points by name, for names that are no Python identifiers.
    named
        Points by keyword.

    Attributes
    ----------
    kept, inertias
        The mechanism that was compiled last, and the inertia of links, each with what it was found from. Those who
        find them put them here, so that they live as long as the description.
    """

    def __init__(self, points: Mapping[str, ArrayLike] | None = None, /, **named: ArrayLike) -> None:
        super().__init__(points, **named)
        self.kept: tuple[tuple[object, ...], Any] | None = None
        self.inertias: dict[str, tuple[tuple[object, ...], Any]] = {}

    def __repr__(self) -> str:
        driven = ", ".join(self.drives) or "none"
        parts = ((len(self.points), "points"), (len(self.links), "links"), (len(self.joints), "joints"))
        return f"<Linkage: {', '.join(f'{count} {noun}' for count, noun in parts)}; driven: {driven}>"

    def __getstate__(self) -> dict[str, object]:
        """What another process needs; what is kept is known by where it lies in this one, and is made again."""
        return vars(self) | {"kept": None, "inertias": {}}

    @property
    def version(self) -> tuple[object, ...]:
        """What the compiled mechanism depends on; equal as long as points, links, joints and drives are the same."""
        parts = (self.points, self.links, self.joints)
        return *(tuple(map(id, part.values())) for part in parts), tuple(self.drives.items())

    def alike(self) -> Self:
        """The description as it is now: points, links, joints and drives that are added later are not in it."""
        other = copy(self)
        other.points, other.links = dict(self.points), dict(self.links)
        other.joints, other.drives = dict(self.joints), dict(self.drives)
        other.kept = None
        return other
