"""The content of a figure, independent of the way it is drawn: lines, joint symbols, supports, arrows and texts.

Everything is in space and in the user's lengths, whether it is drawn in a plane, in space, or on a page.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from ..batch import Array

# Points whose distance from a plane is less than this fraction of the size lie in it.
FLAT = 1e-9


def beside(across: int) -> tuple[int, int]:
    """The two other axes of three, in order."""
    return (1 if across == 0 else 0), (1 if across == 2 else 2)


@dataclass(frozen=True, eq=False)
class Stroke:
    """A line.

    Attributes
    ----------
    points
        Its points, (k, 3).
    kind
        What it is, such as ``link``, ``outline``, ``ghost``, ``spring``, ``trace``, ``member``: decides its look.
    name
        What it belongs to; empty where nothing is to be told.
    number
        Which of its kind it belongs to; decides its colour.
    values
        What colours it, (k,); None where its kind does.
    """

    points: Array
    kind: str
    name: str = ""
    number: int = 0
    values: Array | None = None


@dataclass(frozen=True, eq=False)
class Region:
    """A filled polygon (k, 3); `kind`, `name` and `number` as of a `Stroke`."""

    points: Array
    kind: str
    name: str = ""
    number: int = 0


@dataclass(frozen=True, eq=False)
class JointSymbol:
    """A joint.

    Attributes
    ----------
    name, kind
        Its name, and what it lets go: ``revolute``, ``prismatic``, ...
    at, axes
        Where it is, (3,), and its axes as columns, z along the joint's axis, (3, 3).
    grounded, driven
        Whether one of its links is the ground, and whether it is a drive.
    """

    name: str
    kind: str
    at: Array
    axes: Array
    grounded: bool = False
    driven: bool = False


@dataclass(frozen=True, eq=False)
class Support:
    """Ground at a place (3,): clamped or not."""

    at: Array
    clamped: bool = False


@dataclass(frozen=True, eq=False)
class LoadArrow:
    """A force (3,) that acts at a place (3,), with its label."""

    at: Array
    force: Array
    text: str


@dataclass(frozen=True, eq=False)
class Label:
    """The name of a place (3,), or a number there, which stands away from the place `base` (3,) to which it belongs."""

    text: str
    at: Array
    base: Array | None = None


@dataclass(frozen=True, eq=False)
class Scene:
    """All that a figure shows at one pose.

    Attributes
    ----------
    strokes, regions, joints, supports, arrows, labels
        What there is of each, drawn in the order given.
    moves
        Arrows of a motion that nothing resists, all to one scale.
    flat
        The two global axes that are drawn; None for a scene in space.
    """

    strokes: list[Stroke] = field(default_factory=list)
    regions: list[Region] = field(default_factory=list)
    joints: list[JointSymbol] = field(default_factory=list)
    supports: list[Support] = field(default_factory=list)
    arrows: list[LoadArrow] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    moves: list[LoadArrow] = field(default_factory=list)
    flat: tuple[int, int] | None = None

    @property
    def points(self) -> Array:
        """Ends and corners of everything, (n, 3); places that are nowhere do not count."""
        places = [stroke.points for stroke in self.strokes] + [region.points for region in self.regions]
        marks = [*(joint.at for joint in self.joints), *(support.at for support in self.supports)]
        marks += [label.at for label in self.labels]
        found = np.concatenate([np.zeros((0, 3)), *places, np.reshape(marks, (-1, 3))])
        return np.asarray(found[np.isfinite(found).all(axis=-1)])

    @property
    def size(self) -> float:
        """Diagonal of the box around everything; 1 where all lies in one point."""
        points = self.points
        return (float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0) or 1.0

    @property
    def extent(self) -> tuple[float, float]:
        """Width and height of a flat scene with room about it for symbols and names."""
        across, up = np.ptp(self.points[:, self.flat or (0, 1)], axis=0) + 0.1 * self.size
        return float(across), float(up)

    def pin(self, size: float) -> float:
        """Radius of a pin: small beside a drawing of this size, and beside the links that it joins."""
        joined = [np.linalg.norm(np.ptp(s.points, axis=0)) for s in self.strokes if s.kind in ("link", "member")]
        return min(0.013 * size, max(0.006 * size, 0.09 * float(np.median(joined)) if joined else np.inf))


# Turns of a spring as it is drawn.
_TURNS = 8


def coil(start: Array, end: Array, radius: float) -> Array:
    """A helical spring between two points, (k, 3), with a straight piece at each end; from the side it is a wave."""
    along = end - start
    length = float(np.linalg.norm(along))
    if length == 0.0:
        return np.stack([start, end])
    # Across the coordinate axis that it leans on least, of equals z: seen along that one it is a wave.
    across = np.eye(3)[2 - int(np.abs(along)[::-1].argmin())]
    first = np.cross(across, along)
    first /= np.linalg.norm(first)
    second = np.cross(along, first) / length
    turn = np.linspace(0.0, 2.0 * np.pi * _TURNS, 16 * _TURNS + 1)
    reach = radius * np.minimum(1.0, np.minimum(turn, turn[-1] - turn))[:, None]
    share = 0.15 + 0.7 * turn[:, None] / turn[-1]
    body = start + share * along + reach * (np.sin(turn)[:, None] * first + np.cos(turn)[:, None] * second)
    return np.concatenate([start[None], body, end[None]])


def outline(places: Array) -> tuple[Array, bool]:
    """Outline of a rigid body through its points (n, 3): a line, or the corners of a polygon.

    Parameters
    ----------
    places
        Its points, (n, 3).

    Returns
    -------
    corners : ndarray
        In order: along a line, around the outermost points in their plane, or as given for a body in space, (k, 3).
    closed : bool
        Whether the last is joined to the first.
    """
    if len(places) < 3:
        return places, False
    arms = places - places.mean(axis=0)
    sizes, ways = np.linalg.svd(arms)[1:]
    flatness = sizes / max(sizes[0], np.finfo(float).tiny)
    if flatness[1] < 1e-6:
        return places[np.argsort(arms @ ways[0])][[0, -1]], False
    if len(sizes) > 2 and flatness[2] > 1e-6:
        return places, True
    return places[_hull(arms @ ways[:2].T)], True


def _hull(flat: Array) -> list[int]:
    """Numbers of the outermost of points (n, 2), in order (Andrew's monotone chain)."""
    order = [int(k) for k in np.lexsort((flat[:, 1], flat[:, 0]))]

    def half(numbers: list[int]) -> list[int]:
        chain: list[int] = []
        for k in numbers:
            while len(chain) > 1:
                (ax, ay), (bx, by) = flat[chain[-1]] - flat[chain[-2]], flat[k] - flat[chain[-1]]
                if ax * by - ay * bx > 0.0:
                    break
                chain.pop()
            chain.append(k)
        return chain[:-1]

    return half(order) + half(order[::-1])
