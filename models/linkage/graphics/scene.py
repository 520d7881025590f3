"""A linkage as lines and symbols: links, joints by kind, ground, drives, springs, loads, names."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ....framework.batch import Array
from ....framework.graphics.scene import JointSymbol, Label, LoadArrow, Region, Scene, Stroke, coil, outline
from ....framework.graphics.units import quantity
from ..description.linkage_description import LinkageDescription
from ..description.parts import GROUND, LinkageLink
from .places import DrawnPlaces

# Radius of a spring's coil, as a share of the drawing's size.
COIL = 0.022


def linkage_scene(
    places: DrawnPlaces, flat: tuple[int, int] | None, *, names: bool = True, loads: bool = True, force_unit: str = "N"
) -> Scene:
    """A linkage at one pose.

    Parameters
    ----------
    places
        Positions and axes.
    flat
        The plane in which it is drawn; None in space.
    names
        Whether points are named.
    loads
        Whether applied forces are drawn.
    force_unit
        Unit of the forces.

    Returns
    -------
    Scene
        The scene, in the user's unit of length.
    """
    linkage = places.linkage
    scene = Scene(flat=flat)
    for number, link in enumerate(linkage.links.values()):
        _add_link(scene, places, link, number)
    scene.joints.extend(
        JointSymbol(
            pair.name,
            pair.kind.name,
            places.position(pair.point, pair.second),
            places.axes(pair.name),
            GROUND in (pair.first, pair.second),
            pair.name in linkage.drives,
        )
        for pair in linkage.joints.values()
    )
    size = scene.size
    for spring in linkage.springs:
        start, end = (places.position(point, link) for link, point in (spring.first, spring.second))
        scene.strokes.append(Stroke(coil(start, end, COIL * size), "spring"))
    if loads:
        scene.arrows.extend(_arrows(places, force_unit))
    if names:
        used = points_in_use(linkage)
        scene.labels.extend(Label(point, places.position(point, link)) for point, link in used.items())
    return scene


def ghost(places: DrawnPlaces) -> list[Stroke]:
    """Links at another pose, as faint lines."""
    return [Stroke(line, "ghost") for link in places.linkage.links.values() for line in lines(places, link)]


def _add_link(scene: Scene, places: DrawnPlaces, link: LinkageLink, number: int) -> None:
    """Add a link: beams as thick lines, and a body of three or more points that are not in line as a pale area too.

    A link with one point is drawn by its joints alone.
    """
    if len(link.points) < 2:
        return
    corners, closed = outline(np.array([places.position(point, link.name) for point in link.points]))
    if closed:
        scene.regions.append(Region(corners, "link", link.name, number))
    kind = "link" if link.beams or not closed else "outline"
    for index, line in enumerate(lines(places, link)):
        scene.strokes.append(Stroke(line, kind, "" if index else link.name, number))
    if closed and link.beams:
        # a thin outline of the body, so that the beams, which carry the load, stand out
        scene.strokes.append(Stroke(np.concatenate([corners, corners[:1]]), "ghost", number=number))


def lines(places: DrawnPlaces, link: LinkageLink) -> Iterator[Array]:
    """A link as lines (k, 3): its beams, or the outline of its points."""
    at = {point: places.position(point, link.name) for point in link.points}
    if link.beams:
        yield from (np.stack([at[a], at[b]]) for a, b in link.beams)
        return
    corners, closed = outline(np.array(list(at.values())))
    yield np.concatenate([corners, corners[:1]]) if closed else corners


def points_in_use(linkage: LinkageDescription) -> dict[str, str | None]:
    """Points on links or in joints, and the first link that has each."""
    used: dict[str, str | None] = {}
    for point in linkage.points:
        holders = [link.name for link in linkage.links.values() if point in link.points]
        if holders or any(pair.point == point for pair in linkage.joints.values()):
            used[point] = holders[0] if holders else None
    return used


def _arrows(places: DrawnPlaces, unit: str) -> Iterator[LoadArrow]:
    """Arrows of forces at points; torques are not drawn."""
    for load in places.linkage.loads:
        given = load.value[..., :3]
        force = places.rotated(load.link, given) if load.follower else places.value(given, 1)
        size = float(np.linalg.norm(force))
        if load.point is not None and size > 0.0:
            yield LoadArrow(places.position(load.point, load.link), force, quantity(size, unit))
