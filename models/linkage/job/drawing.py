"""A picture of a linkage: its links at one pose, faint at others, the paths of points; plane or in space."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.batch import Array
from ...job.style import BLUE, GREY, INK, ORANGE, SKY, entry, figure, note, space_figure, styled
from ..description.parts import GROUND
from .plane import plane

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..motion import Motion

# Other poses that are drawn faintly.
GHOSTS = 8
MARKERS = {"revolute": "o", "prismatic": "s", "cylindrical": "D", "screw": "D", "planar": "s", "fixed": "X"}
COLOURS = (BLUE, "#009e73", "#b8860b", "#7b3294", "#56b4e9", "#a0522d", "#556b2f", "#d6336c")


@styled
def draw_mechanism(motion: Motion, pose: int, points: Sequence[str], title: str = "") -> Figure:
    """Draw a linkage at one of its poses.

    Parameters
    ----------
    motion
        Its motion, (poses,).
    pose
        Number of the pose.
    points
        Points whose paths are drawn.
    title
        What stands above.

    Returns
    -------
    Figure
        A drawing in the plane of motion, or in space.
    """
    flat = plane(motion)
    axes: Any
    if flat is None:
        drawn_on, axes = space_figure(6.4, 5.2)
    else:
        drawn_on, (axes,) = figure(6.4, 4.8)
    shown = draw_links(axes, motion, pose, points)
    _finish(axes, shown, flat, title)
    if len(motion.linkage.links) <= len(COLOURS):
        axes.legend(loc="upper left" if flat is None else "best", fontsize=7.0)
    if flat is not None:
        _labels(axes, motion, pose, shown)
    return drawn_on


def draw_links(axes: Any, motion: Motion, pose: int, points: Sequence[str]) -> tuple[int, ...]:
    """Draw links, joints and springs, and nothing around them.

    Parameters
    ----------
    axes
        Where to draw: of matplotlib, in space for a linkage in space.
    motion, pose, points
        As for `draw_mechanism`.

    Returns
    -------
    tuple of int
        The directions drawn, 0 for x to 2 for z.
    """
    shown = plane(motion) or (0, 1, 2)
    there = np.flatnonzero(np.broadcast_to(motion.is_assembled, motion.shape))
    for ghost in there[:: max(1, len(there) // GHOSTS)]:
        for line in _lines(motion, int(ghost)):
            axes.plot(*line[:, shown].T, color=GREY, lw=0.7, alpha=0.35, zorder=1)
    for point in points:
        path = np.broadcast_to(motion.position(point), (*motion.shape, 3))[:, shown]
        axes.plot(*path.T, color=ORANGE, lw=1.2, zorder=2)
        axes.plot(*path[pose : pose + 1].T, ".", color=ORANGE, ms=5, zorder=7)
    for colour, link in zip(_colours(len(motion.linkage.links)), motion.linkage.links, strict=False):
        for index, line in enumerate(_outline(motion, link, pose)):
            label = None if index else entry(link)
            axes.plot(*line[:, shown].T, color=colour, lw=3.0, solid_capstyle="round", zorder=4, label=label)
    _springs(axes, motion, pose, shown)
    _joints(axes, motion, pose, shown)
    return shown


def _colours(count: int) -> list[str]:
    return [COLOURS[k % len(COLOURS)] for k in range(count)]


def _lines(motion: Motion, pose: int) -> Iterator[Array]:
    for link in motion.linkage.links:
        yield from _outline(motion, link, pose)


def _outline(motion: Motion, link: str, pose: int) -> Iterator[Array]:
    """A link as lines (k, 3): its beams, or the outline of its points."""
    given = motion.linkage.links[link]
    at = {point: _at(motion, point, link, pose) for point in given.points}
    if given.beams:
        yield from (np.stack([at[a], at[b]]) for a, b in given.beams)
    else:
        places = list(at.values())
        yield np.stack([*places, places[0]] if len(places) > 2 else places)


def _at(motion: Motion, point: str, link: str | None, pose: int) -> Array:
    """Position of a point at one pose, (3,)."""
    return np.asarray(np.broadcast_to(motion.position(point, link), (*motion.shape, 3))[pose])


def _springs(axes: Any, motion: Motion, pose: int, shown: tuple[int, ...]) -> None:
    for spring in motion.linkage.springs:
        ends = [_at(motion, point, link, pose) for link, point in (spring.first, spring.second)]
        zigzag = np.linspace(0.0, 1.0, 17)[:, None] * (ends[1] - ends[0]) + ends[0]
        if len(shown) == 2:
            along = (ends[1] - ends[0])[list(shown)]
            across = np.zeros(3)
            across[list(shown)] = 0.06 * np.array([-along[1], along[0]])
            zigzag[3:14] += np.array([0.0, 1.0, 0.0, -1.0] * 3)[:11, None] * across
        axes.plot(*zigzag[:, shown].T, color=GREY, lw=1.2, zorder=3)


def _joints(axes: Any, motion: Motion, pose: int, shown: tuple[int, ...]) -> None:
    for pair in motion.linkage.joints.values():
        place = _at(motion, pair.point, pair.second, pose)
        grounded, driven = GROUND in (pair.first, pair.second), pair.name in motion.linkage.drives
        axes.plot(
            *place[list(shown), None],
            MARKERS.get(pair.kind.name, "o"),
            ms=8.0 if grounded else 6.0,
            mfc=ORANGE if driven else SKY if grounded else "white",
            mec=INK,
            mew=1.1,
            zorder=6,
        )


def _finish(axes: Any, shown: tuple[int, ...], flat: tuple[int, int] | None, title: str) -> None:
    names = "xyz"
    axes.set_xlabel(f"{names[shown[0]]} [m]")
    axes.set_ylabel(f"{names[shown[1]]} [m]")
    if flat is None:
        axes.set_zlabel("z [m]")
        axes.set_aspect("equal")
    else:
        axes.set_aspect("equal", adjustable="datalim")
        axes.margins(0.12)
    axes.set_title(title, loc="left")


def _labels(axes: Any, motion: Motion, pose: int, shown: tuple[int, ...]) -> None:
    """Names of the points, away from the middle of the linkage."""
    used = [p for p in motion.linkage.points if any(p in link.points for link in motion.linkage.links.values())]
    places = {p: _at(motion, p, None, pose)[list(shown)] for p in used}
    middle = np.mean(list(places.values()), axis=0)
    for name, place in places.items():
        away = place - middle
        length = float(np.linalg.norm(away))
        shift = 11.0 * away / length if length > 0.0 else np.array([0.0, 11.0])
        note(axes, name, place, shift, ha="center", va="center", color=INK)
