"""Names of the nodes and members of a linkage's frame."""

from __future__ import annotations

import numpy as np

from ....framework.batch import Array
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, LinkageLink, Pair
from ..description.sketch import places

# Distances that differ by less than this share of the largest count as equal.
ALIKE = 1e-9


class Nodes:
    """Which node stands for a point of a link, and what its members are called.

    Parameters
    ----------
    linkage
        The linkage.

    Attributes
    ----------
    on_ground
        Points at which joints or springs meet the ground.
    on
        By link, the ground last: the node of each of its points.
    """

    def __init__(self, linkage: LinkageDescription) -> None:
        self.on_ground = list(dict.fromkeys(_ground_points(linkage)))
        points = {name: link.points for name, link in linkage.links.items()} | {GROUND: self.on_ground}
        self._carriers: dict[str, list[str]] = {point: [] for point in linkage.points}
        for link, own in points.items():
            for point in own:
                self._carriers[point].append(link)
        self.on = {link: {point: self.of(link, point) for point in own} for link, own in points.items()}

    def of(self, link: str, point: str) -> str:
        """Node of a link's point."""
        return point if len(self._carriers[point]) < 2 else f"{point}.{link}"

    def members(self, link: LinkageLink, count: int) -> list[str]:
        """Names of the `count` members of a link: that of the link, followed by a number if there are several."""
        return [link.name] if count == 1 else [f"{link.name}.{index}" for index in range(1, count + 1)]

    @property
    def by_point(self) -> dict[str, str]:
        """By point shared by several links: its node on the first of them; the ground counts as the last link."""
        return {point: self.of(links[0], point) for point, links in self._carriers.items() if len(links) > 1}

    def guide(self, pair: Pair) -> str:
        """Node of a joint on its first link; a joint that slides has one of its own under the slider."""
        if pair.kind.slides:
            return f"{pair.name}.slider" if f"{pair.name}.{pair.first}" in self._names else f"{pair.name}.{pair.first}"
        return self.of(pair.first, pair.point)

    def centre_node(self, linkage: LinkageDescription, link: str, centre: Array) -> str:
        """The point of a link nearest to its centre of mass; the first of several that are equally near."""
        points = linkage.links[link].points
        away = [float(np.max(np.linalg.norm(centre - at, axis=-1))) for at in places(linkage, link).values()]
        # both ends of a bar are equally near to its middle, but for rounding
        return next(point for point, far in zip(points, away, strict=True) if far <= min(away) + ALIKE * max(away))

    @property
    def _names(self) -> set[str]:
        return {node for nodes in self.on.values() for node in nodes.values()}


def _ground_points(linkage: LinkageDescription) -> list[str]:
    """Points at which joints or springs meet the ground; without sliders on it, whose nodes move."""
    found = []
    for pair in linkage.joints.values():
        if pair.second == GROUND or (pair.first == GROUND and not pair.kind.slides):
            found.append(pair.point)
    for spring in linkage.springs:
        found += [point for link, point in (spring.first, spring.second) if link == GROUND]
    return found
