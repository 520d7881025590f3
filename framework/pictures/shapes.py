"""Bodies to look at, as points, normals and faces: tubes along curves, and copies of round templates."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..batch import Array

Numbers = NDArray[np.int64]

SIDES = 24
CAP = np.linspace(np.pi / 2, 0.0, 6)[:-1]


@dataclass(frozen=True)
class Surface:
    """Points (n, 3), outward normals (n, 3), faces (m, 4) and one value a point (n,)."""

    points: Array
    normals: Array
    faces: Numbers
    values: Array


def tubes(curves: Array, values: Array, radius: float) -> Surface:
    """Round-ended tubes along curves.

    Parameters
    ----------
    curves
        Points of each curve, (m, k, 3), k > 1.
    values
        What to colour by, (m, k).
    radius
        Radius of the tubes.
    """
    k = curves.shape[1]
    # Rings: those of the first cap, one a station, those of the second cap.
    ring = np.concatenate([np.zeros_like(CAP), np.arange(k), np.full_like(CAP, k - 1)]).astype(np.int64)
    along = np.concatenate([-np.sin(CAP), np.zeros(k), np.sin(CAP[::-1])])
    across = np.concatenate([np.cos(CAP), np.ones(k), np.cos(CAP[::-1])])
    tangent, side, up = (axis[:, ring, None] for axis in _axes(curves))
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)[:, None]
    around = np.cos(turn) * side + np.sin(turn) * up
    normals = across[:, None, None] * around + along[:, None, None] * tangent
    points = curves[:, ring, None] + radius * normals
    corner = np.arange(points.size // 3).reshape(points.shape[:-1])
    shade = np.broadcast_to(values[:, ring, None], points.shape[:-1])
    return Surface(points.reshape(-1, 3), normals.reshape(-1, 3), _quads(corner), shade.reshape(-1))


def prism(corners: Array, start: Array, end: Array, axes: Array) -> Surface:
    """A convex outline drawn out from one point to another, flat at both ends.

    Parameters
    ----------
    corners
        Outline in the plane across, (k, 2), counterclockwise seen against the way.
    start, end
        Where it begins and ends, (3,).
    axes
        Unit vectors as rows: along, and the two axes of the outline, (3, 3).
    """
    k = len(corners)
    outline = corners @ axes[1:]
    after, middle = np.roll(outline, -1, axis=0), np.broadcast_to(outline.mean(axis=0), outline.shape)
    edge = np.roll(corners, -1, axis=0) - corners
    out = np.stack([edge[:, 1], -edge[:, 0]], axis=-1) @ axes[1:]
    out /= np.linalg.norm(out, axis=-1, keepdims=True)
    sides = np.stack([start + outline, start + after, end + after, end + outline], axis=1)
    first = np.stack([start + middle, start + after, start + outline, start + middle], axis=1)
    last = np.stack([end + middle, end + outline, end + after, end + middle], axis=1)
    points = np.concatenate([sides, first, last]).reshape(-1, 3)
    ends = np.broadcast_to(axes[0], (4 * k, 3))
    normals = np.concatenate([np.repeat(out, 4, axis=0), -ends, ends])
    return Surface(points, normals, np.arange(len(points)).reshape(-1, 4), np.zeros(len(points)))


def joined(surfaces: Sequence[Surface]) -> Surface:
    """Several surfaces as one."""
    first = np.cumsum([0, *(len(each.points) for each in surfaces)])
    return Surface(
        np.concatenate([np.zeros((0, 3)), *(each.points for each in surfaces)]),
        np.concatenate([np.zeros((0, 3)), *(each.normals for each in surfaces)]),
        np.concatenate([np.zeros((0, 4), np.int64), *(e.faces + k for e, k in zip(surfaces, first, strict=False))]),
        np.concatenate([np.zeros(0), *(each.values for each in surfaces)]),
    )


def sphere() -> Surface:
    """Unit sphere."""
    angle = np.linspace(0.0, np.pi, SIDES)
    outline = np.stack([np.sin(angle), -np.cos(angle)], axis=-1)
    return _revolved(outline, outline)


def block() -> Surface:
    """Cylinder of radius 1 below the origin, from z = -1 to z = 0."""
    return _turned_solid([(0.0, -1.0), (1.0, -1.0), (1.0, 0.0), (0.0, 0.0)])


def cone() -> Surface:
    """Cone of radius 1 with its base at z = -2 and its tip at the origin."""
    return _turned_solid([(0.0, -2.0), (1.0, -2.0), (0.0, 0.0)])


def arrow() -> Surface:
    """Arrow of length 1 along z with its tip at the origin."""
    return _turned_solid([(0.0, -1.0), (0.025, -1.0), (0.025, -0.28), (0.07, -0.28), (0.0, 0.0)])


def _turned_solid(outline: list[tuple[float, float]]) -> Surface:
    """Solid of revolution with sharp edges; its outline (r, z) runs from bottom to top."""
    corner = np.array(outline)
    step = np.diff(corner, axis=0)
    normal = np.stack([step[:, 1], -step[:, 0]], axis=-1) / np.linalg.norm(step, axis=-1, keepdims=True)
    ends = np.stack([corner[:-1], corner[1:]], axis=1)
    return _revolved(ends.reshape(-1, 2), np.repeat(normal, 2, axis=0))


def _revolved(outline: Array, normal: Array) -> Surface:
    """Outline (n, 2) and its normals, as radius and height, turned about the z axis."""
    turn = np.linspace(0.0, 2.0 * np.pi, SIDES, endpoint=False)

    def swept(pairs: Array) -> Array:
        radius, height = pairs.T[:, :, None]
        return np.stack([radius * np.cos(turn), radius * np.sin(turn), height + 0.0 * turn], axis=-1)

    points = swept(outline)
    corner = np.arange(points.size // 3).reshape(1, *points.shape[:-1])
    return Surface(points.reshape(-1, 3), swept(normal).reshape(-1, 3), _quads(corner), np.zeros(points.size // 3))


def _quads(corner: Numbers) -> Numbers:
    """Faces (f, 4) between neighbours in the closed rings `corner` (m, rings, sides)."""
    near, far = corner[:, :-1], corner[:, 1:]
    return np.stack([near, np.roll(near, -1, axis=2), np.roll(far, -1, axis=2), far], axis=-1).reshape(-1, 4)


def copies(template: Surface, places: Array, sizes: Array, axes: Array) -> Surface:
    """A template at each of `places` (n, 3), `sizes` (n,) times as large, turned to the columns of `axes` (n, 3, 3)."""
    count, size = len(places), len(template.points)
    points = places[:, None] + sizes[:, None, None] * np.einsum("nij,kj->nki", axes, template.points)
    normals = np.einsum("nij,kj->nki", axes, template.normals)
    faces = template.faces + size * np.arange(count)[:, None, None]
    return Surface(points.reshape(-1, 3), normals.reshape(-1, 3), faces.reshape(-1, 4), np.tile(template.values, count))


def arrows(tips: Array, vectors: Array, up: Array) -> Surface:
    """Arrows along vectors (n, 3) that end at `tips` (n, 3); zero vectors have arrows along `up` of no length."""
    length = np.linalg.norm(vectors, axis=-1)
    return copies(arrow(), tips, length, upright(np.where(length[:, None] > 0.0, vectors, up)))


def upright(directions: Array) -> Array:
    """Axes (n, 3, 3), as columns, of which the third is along `directions` (n, 3)."""
    third = directions / np.linalg.norm(directions, axis=-1, keepdims=True)
    first = _across(third)
    return np.stack([first, np.cross(third, first), third], axis=-1)


def _axes(curves: Array) -> tuple[Array, Array, Array]:
    """Unit tangents of curves and two directions across them, each (m, k, 3)."""
    tangent = np.gradient(curves, axis=1)
    tangent /= np.linalg.norm(tangent, axis=-1, keepdims=True)
    # One reference direction a curve, or the tube would twist.
    reference = _across(curves[:, -1] - curves[:, 0])[:, None]
    side = np.cross(np.cross(tangent, reference), tangent)
    side /= np.linalg.norm(side, axis=-1, keepdims=True)
    return tangent, side, np.cross(tangent, side)


def _across(vectors: Array) -> Array:
    """A unit vector perpendicular to each of `vectors` (n, 3)."""
    least = np.eye(3)[np.abs(vectors).argmin(axis=-1)]
    across: Array = np.cross(vectors, least)
    across /= np.linalg.norm(across, axis=-1, keepdims=True)
    return across
