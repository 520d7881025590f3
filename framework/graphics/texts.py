"""Names, numbers and sizes of forces in a figure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from ..batch import Array
from .placement import PlacedText, TextPlacement
from .scene import Scene
from .style import COLOURS, INK, ORANGE

# Lines that a text may cross.
PASSING = ("ghost", "sample", "ordinate")
NAME: dict[str, Any] = {"fontsize": 8.5, "zorder": 8, "color": INK, "gid": "label"}
FORCE: dict[str, Any] = {"fontsize": 8.0, "zorder": 8, "color": ORANGE, "gid": "force"}
VALUE: dict[str, Any] = {"fontsize": 7.5, "zorder": 8, "color": COLOURS[0], "gid": "value"}


def texts_in_plane(axes: Any, scene: Scene, shown: list[int], pin: float, arrows: Sequence[Array]) -> list[Any]:
    """Write names where the widest angle between lines is free, clear of the symbol there, and sizes of forces.

    Parameters
    ----------
    axes
        Where.
    scene
        What is drawn.
    shown
        The two global axes of the figure.
    pin
        Radius of a pin.
    arrows
        Forces as they are drawn, from their places to their tips, (2, 2) each.

    Returns
    -------
    list of matplotlib.artist.Artist
        What was added.
    """
    dots: list[Any] = []
    texts = []
    for label in scene.labels:
        if not np.isfinite(label.at).all():
            continue
        at = label.at[shown]
        if label.base is not None:
            texts.append(PlacedText(label.text, at, _outwards(at - label.base[shown]), 0.0, 2.0, VALUE))
            continue
        there = [joint for joint in scene.joints if _close(joint.at[shown], at, 0.02 * scene.size)]
        clamps = [each for each in scene.supports if each.clamped and _close(each.at[shown], at, 0.02 * scene.size)]
        clear = pin * max([2.2 if joint.driven else 1.1 for joint in there] + [1.8 for _ in clamps], default=0.0)
        if not there:
            dots += axes.plot(*at[:, None], "o", ms=3.2, mfc=INK, mec="none", zorder=6, ls="")
        texts.append(PlacedText(label.text, at, _free(at, scene, shown), clear, 2.0, NAME))
    for arrow, (_, tip) in zip(scene.arrows, arrows, strict=True):
        texts.append(
            PlacedText(arrow.text, tip, np.array([1.0 if arrow.force[0] >= 0.0 else -1.0, 0.0]), 0.0, 3.0, FORCE)
        )
    lines = [stroke.points[:, shown] for stroke in scene.strokes if stroke.kind not in PASSING]
    return dots + _written(TextPlacement(axes, [*lines, *arrows]), texts)


def texts_in_space(axes: Any, scene: Scene, arrows: Sequence[Array]) -> list[Any]:
    """Write names and sizes of forces to the right of their places, if there is room.

    Parameters
    ----------
    axes
        Where.
    scene
        What is drawn.
    arrows
        Forces as they are drawn, from their places to their tips, (2, 3) each.

    Returns
    -------
    list of matplotlib.artist.Artist
        What was added.
    """
    right = np.array([1.0, 0.0])
    texts = [
        PlacedText(label.text, label.at, right, 0.0, 5.0, NAME) for label in scene.labels if np.isfinite(label.at).all()
    ]
    texts += [
        PlacedText(arrow.text, tip, right, 0.0, 3.0, FORCE)
        for arrow, (_, tip) in zip(scene.arrows, arrows, strict=True)
    ]
    lines = [stroke.points for stroke in scene.strokes if stroke.kind not in PASSING]
    return _written(TextPlacement(axes, [*lines, *arrows]), texts)


def _written(placement: TextPlacement, texts: list[PlacedText]) -> list[Any]:
    return placement.write([replace(each, look={**each.look, "path_effects": _halo()}) for each in texts])


def _outwards(way: Array) -> Array:
    """A direction (2,); up where there is none."""
    return way if way.any() else np.array([0.0, 1.0])


def _halo() -> list[Any]:
    """A white edge about a text, so that lines behind it do not cross it."""
    from matplotlib.patheffects import withStroke

    return [withStroke(linewidth=2.0, foreground="white")]


def _free(at: Array, scene: Scene, shown: list[int]) -> Array:
    """Direction from a place (2,) in the middle of the widest angle without a line, (2,)."""
    near = 0.02 * scene.size
    ways = [np.array([0.0, -1.0])] if any(_close(j.at[shown], at, near) for j in _standing(scene)) else []
    ways += [a.force[shown] for a in (*scene.arrows, *scene.moves) if _close(a.at[shown], at, near)]
    for stroke in scene.strokes:
        if stroke.kind not in PASSING:
            ways += _leaving(stroke.points[:, shown], at, near)
    angles = np.sort([np.arctan2(way[1], way[0]) for way in ways if np.linalg.norm(way) > 0.0])
    if not len(angles):
        return np.array([0.0, 1.0])
    gaps = np.diff(angles, append=angles[0] + 2.0 * np.pi)
    middle = angles[gaps.argmax()] + 0.5 * gaps.max()
    return np.array([np.cos(middle), np.sin(middle)])


def _standing(scene: Scene) -> list[Any]:
    return [*scene.supports, *(joint for joint in scene.joints if joint.grounded)]


def _close(one: Array, other: Array, near: float) -> bool:
    return bool(np.linalg.norm(one - other) < 0.1 * near)


def _leaving(line: Array, at: Array, near: float) -> list[Array]:
    """Directions in which a line (k, 2) leaves a place that lies on it."""
    step = np.diff(line, axis=0)
    square = np.maximum(np.sum(step * step, axis=-1), np.finfo(float).tiny)
    share = np.clip(np.sum((at - line[:-1]) * step, axis=-1) / square, 0.0, 1.0)
    away = np.linalg.norm(line[:-1] + share[:, None] * step - at, axis=-1)
    ways = []
    for k in np.flatnonzero(away < 0.1 * near):
        ways += [end - at for end in (line[k], line[k + 1]) if np.linalg.norm(end - at) > 0.1 * near]
    return ways
