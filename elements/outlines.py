"""Outlines of cross-sections, for pictures of frames in space."""

from __future__ import annotations

import numpy as np

from ..framework.protocol import Array
from .circle import Circle
from .cross_section import CrossSection
from .i_section import ISection
from .tube import Tube

TURN = np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False)


def outlines(section: CrossSection) -> list[Array]:
    """A cross-section as convex outlines in its local axes.

    Parameters
    ----------
    section
        The cross-section; of a batch the first entry is drawn, of a tube the outer circle. A section that has no
        outline here becomes the rectangle with the same ``Iy / A`` and ``Iz / A``.

    Returns
    -------
    list of ndarray
        Corners y, z of each convex part, counterclockwise, (k, 2), length.
    """
    if isinstance(section, Circle):
        return [0.5 * _first(section.diameter) * _round()]
    if isinstance(section, Tube):
        return [0.5 * _first(section.outer) * _round()]
    if isinstance(section, ISection):
        height, width = _first(section.height), _first(section.width)
        web, flange = _first(section.web), _first(section.flange)
        lift = np.array([0.0, 0.5 * (height - flange)])
        return [_box(web, height - 2.0 * flange), _box(width, flange) + lift, _box(width, flange) - lift]
    return [_box(*(float(np.sqrt(12.0 * _first(i) / _first(section.A))) for i in (section.Iz, section.Iy)))]


def _first(value: object) -> float:
    return float(np.asarray(value, dtype=float).reshape(-1)[0])


def _round() -> Array:
    return np.stack([np.cos(TURN), np.sin(TURN)], axis=-1)


def _box(y: float, z: float) -> Array:
    return 0.5 * np.array([(-y, -z), (y, -z), (y, z), (-y, z)])
