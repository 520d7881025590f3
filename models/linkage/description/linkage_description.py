"""What a linkage is: the whole description, which the analyses read and the user changes by its calls."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Self

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
    """

    def __init__(self, points: Mapping[str, ArrayLike] | None = None, /, **named: ArrayLike) -> None:
        super().__init__(points, **named)

    def __repr__(self) -> str:
        driven = ", ".join(self.drives) or "none"
        parts = ((len(self.points), "points"), (len(self.links), "links"), (len(self.joints), "joints"))
        return f"<Linkage: {', '.join(f'{count} {noun}' for count, noun in parts)}; driven: {driven}>"

    @property
    def version(self) -> tuple[object, ...]:
        """What the compiled mechanism depends on: points, links, joints and drives of now, after their names."""
        points, links, joints, drives = self.points, self.links, self.joints, self.drives
        return (
            *(*points, *points.values()),
            *(*links, *links.values()),
            *(*joints, *joints.values()),
            *(*drives, *drives.values()),
        )

    def alike(self) -> Self:
        """Independent copy.

        Returns
        -------
        same type
            The description as it is now: what is added to either later is not in the other. Arrays are shared.
        """
        other = object.__new__(type(self))
        for name, value in vars(self).items():
            setattr(other, name, value.copy() if isinstance(value, (dict, list)) else value)
        return other

    __copy__ = alike
