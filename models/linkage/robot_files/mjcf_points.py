"""Points of a linkage that is read from MJCF: its sites, and new points for joints without a site."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ..description.parts import GROUND, ROUNDING
from .mjcf_bodies import ReadBody
from .mjcf_joints import ReadPair
from .mjcf_loops import ReadLoops
from .mjcf_write import AXES_OF_LOADS


class PointsOfBodies:
    """Points by name, and the points of each link.

    Parameters
    ----------
    bodies, loops
        Bodies of the file, and its loop closures.

    Attributes
    ----------
    places
        Positions (3,) by name of the point.
    on_links
        Names of the points on each link.
    """

    def __init__(self, bodies: list[ReadBody], loops: ReadLoops) -> None:
        self.parts, self.near = loops.parts, ROUNDING * loops.size
        self.places: dict[str, Array] = {}
        self.on_links: dict[str, list[str]] = {body.name: [] for body in bodies if body.name not in self.parts}
        sites = {name: site.origin for body in bodies for name, site in body.sites.items()}
        self._of_sites: dict[str, str] = {}
        for body in bodies:
            for name, place in ((name, sites[name]) for name in body.sites):
                if name == AXES_OF_LOADS:
                    continue
                stem = name.removesuffix(f" on {body.name}")
                point = stem if stem in sites and self._is_at(sites[stem], place) else name
                self._of_sites[name] = point
                self.places.setdefault(point, sites[point])
                self._put(self.link_of(body.name), point)

    def link_of(self, body: str) -> str:
        """The link of a body, which may be a part of that link."""
        return self.parts.get(body, body)

    def of_site(self, site: str) -> str:
        """The point of a site."""
        return self._of_sites[site]

    def of(self, joining: ReadPair) -> str:
        """The point of a joint, added to both of its links: one there, if possible of its name, or else a new one."""
        links = [self.link_of(link) for link in (joining.first, joining.second)]
        known = [set(self.on_links.get(link, ())) for link in links if link != GROUND]
        there = [
            point
            for point, place in self.places.items()
            if any(point in own for own in known) and self._is_at(place, joining.place)
        ]
        best = min(there, key=lambda point: (point != joining.name, not all(point in own for own in known)), default="")
        point = best or self._new(joining.name or joining.second, joining.place)
        for link in links:
            self._put(link, point)
        return point

    def complete(self, bodies: list[ReadBody]) -> None:
        """Give links without any point their origin."""
        for body in bodies:
            if body.name != GROUND and not self.on_links.get(self.link_of(body.name)):
                self._put(body.name, self._new(body.name, body.frame.origin))

    def _new(self, wanted: str, place: Array) -> str:
        name, count = wanted, 1
        while name in self.places:
            count += 1
            name = f"{wanted} {count}"
        self.places[name] = place
        return name

    def _put(self, link: str, point: str) -> None:
        own = self.on_links.setdefault(link, [])
        if point not in own:
            own.append(point)

    def _is_at(self, place: Array, other: Array) -> bool:
        return bool(np.linalg.norm(place - other) <= self.near)
