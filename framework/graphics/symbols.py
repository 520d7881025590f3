"""Symbols of joints, drives and the ground in a plane, as lines in units of their size."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from ..batch import Array

TURN = np.linspace(0.0, 2.0 * np.pi, 49)
RING = np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)
# Half width and half length of what slides, in units of a pin's radius.
WIDE, LONG = 0.95, 1.7


@dataclass(frozen=True, eq=False)
class Glyph:
    """A symbol about the origin, its axis along x.

    Attributes
    ----------
    body
        Closed outline that is filled, (k, 2).
    lines
        Lines over it, each (k, 2).
    """

    body: Array
    lines: tuple[Array, ...] = ()


def _box(half_length: float, half_width: float) -> Array:
    corners = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0)])
    return np.asarray(corners * (half_length, half_width))


def _line(*points: tuple[float, float]) -> Array:
    return np.array(points, dtype=float)


# Seen along the axis of the joint, and from the side, its axis along x.
ALONG = {
    "revolute": Glyph(RING),
    "cylindrical": Glyph(RING, (0.45 * RING,)),
    "screw": Glyph(RING, (_line((-0.6, 0.0), (0.6, 0.0)), _line((0.0, -0.6), (0.0, 0.6)))),
    "prismatic": Glyph(_box(WIDE, WIDE), (_line((-0.5, -0.5), (0.5, 0.5)), _line((-0.5, 0.5), (0.5, -0.5)))),
    "planar": Glyph(_box(1.2, 1.2), (0.5 * RING,)),
}
ASIDE = {
    "revolute": Glyph(_box(1.1, 0.8), (_line((-1.9, 0.0), (1.9, 0.0)),)),
    "cylindrical": Glyph(_box(LONG, 0.7), (_line((-2.4, 0.0), (2.4, 0.0)),)),
    "screw": Glyph(_box(LONG, 0.7), tuple(_line((x - 0.3, -0.7), (x + 0.3, 0.7)) for x in (-1.0, 0.0, 1.0))),
    "prismatic": Glyph(_box(LONG, WIDE)),
    "planar": Glyph(_box(LONG, 0.35)),
}
ANY = {
    "spherical": Glyph(RING, (0.5 * RING,)),
    "universal": Glyph(RING, (_line((-1.0, 0.0), (1.0, 0.0)), _line((0.0, -1.0), (0.0, 1.0)))),
    "fixed": Glyph(_box(0.8, 0.8), (_line((-0.8, -0.8), (0.8, 0.8)), _line((-0.8, 0.8), (0.8, -0.8)))),
}


def glyph(kind: str, axis: Array) -> Glyph:
    """The symbol of a joint as it is seen.

    Parameters
    ----------
    kind
        Kind of joint, such as ``revolute``.
    axis
        Its axis as it is seen in the plane of the figure, (2,), of length 1 where it lies in that plane.
    """
    if kind in ANY:
        return ANY[kind]
    return (ASIDE if np.linalg.norm(axis) > 0.5 else ALONG).get(kind, ALONG["revolute"])


def placed(lines: Array, at: Array, size: float, axis: Array) -> Array:
    """Lines (k, 2) of a symbol at a place (2,), `size` times as large, x turned to `axis` (2,)."""
    length = float(np.linalg.norm(axis))
    cos, sin = axis / length if length > 0.5 else (1.0, 0.0)
    return np.asarray(at + size * lines @ np.array([[cos, sin], [-sin, cos]]))


def hatched(half: float, step: float, length: float) -> list[Array]:
    """Ground below the origin: a line along x, and strokes below it."""
    strokes = [_line((x, 0.0), (x - length, -length)) for x in np.arange(-half + length, half + 1e-9, step)]
    return [_line((-half, 0.0), (half, 0.0)), *strokes]


PIVOT = _line((-1.15, -2.2), (0.0, 0.0), (1.15, -2.2), (-1.15, -2.2))
CLAMP = _line((-1.5, -2.2), (-1.5, 1.5), (1.5, 1.5), (1.5, -2.2), (-1.5, -2.2))
FOOT = [np.asarray(each - (0.0, 2.2)) for each in hatched(2.4, 0.8, 0.8)]
# A guide beside what slides along x.
GUIDE = [np.asarray(each - (0.0, WIDE)) for each in hatched(3.6, 0.9, 0.7)]
ARC = 2.1 * np.stack([np.cos(TURN[4:34] - 0.4), np.sin(TURN[4:34] - 0.4)], axis=-1)
SHAFT = _line((-3.4, 1.9), (3.4, 1.9))
