"""Figures of a linkage and of its motion, with matplotlib; each draws on given axes or new ones, and returns them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from html import escape
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.graphics.canvas import axes_for, draw, finish, frame_in_space
from ....framework.graphics.deformed import round_scale
from ....framework.graphics.scene import Region, Scene, Stroke
from ....framework.graphics.style import fitting_figure, space_figure, styled
from ...job.envelope import swept
from ..description.linkage_description import LinkageDescription
from .places import (
    FREE_TEXT,
    DrawnPoses,
    PosePlaces,
    ReferencePlaces,
    assembled_of,
    free_arrows,
    rows_of,
    series_of,
)
from .plane import plane
from .regions import drawn_regions, magnified, outline_of, told
from .scene import ghost, linkage_scene
from .units import GHOSTS, SI, Units

if TYPE_CHECKING:
    from matplotlib.animation import FuncAnimation
    from matplotlib.axes import Axes

# Largest number of sampled paths that are drawn in space.
PATHS = 100
# Size at which the largest displacement of a band is drawn, as a share of the figure's extent.
SHARE = 0.05


@styled
def plot_linkage(
    linkage: LinkageDescription, axes: Axes | None, entry: int, names: bool, loads: bool, units: Units
) -> Axes:
    """See `Linkage.plot`."""
    if not linkage.points:
        raise FrameError("the linkage has no points: there is nothing to draw")
    many = math.prod(linkage.shape)
    if entry not in range(many):
        raise FrameError(f"plot was given entry={entry!r}, but the linkage has a batch of {many}: give 0 to {many - 1}")
    places = ReferencePlaces(linkage, entry)
    scene = linkage_scene(places, places.flat, names=names, loads=loads, force_unit=units[1])
    found = axes_for(scene, axes)
    draw(scene, found)
    finish(scene, found, units[0])
    return found  # type: ignore[no-any-return]


@styled
def html_of(linkage: LinkageDescription) -> str:
    """A line of text and a drawing of a linkage for a notebook; the text alone if there is nothing to draw."""
    from io import StringIO

    told = f"<p>{escape(repr(linkage).strip('<>'))}</p>"
    if not linkage.links:
        return told
    places = ReferencePlaces(linkage)
    scene = linkage_scene(places, places.flat)
    drawn_on, axes = space_figure(5.0, 4.1) if scene.flat is None else fitting_figure(5.0, scene.extent)
    draw(scene, axes)
    finish(scene, axes, SI[0])
    text = StringIO()
    drawn_on.savefig(text, format="svg", metadata={"Date": None})
    return told + text.getvalue()[text.getvalue().index("<svg") :]


def scene_of(
    motion: DrawnPoses,
    pose: int | tuple[int, ...] | None,
    trace: Sequence[str] = (),
    *,
    ghosts: int = GHOSTS,
    names: bool = True,
    loads: bool = True,
    unit: str = "N",
) -> Scene:
    """The scene that `Motion.plot` draws, without bands and regions.

    Parameters
    ----------
    motion
        The motion.
    pose
        Index of the pose drawn; the first assembled one if None.
    trace
        Points whose path along the longest batch axis is drawn.
    ghosts
        Approximate number of other poses that are drawn faintly.
    names, loads
        Whether points are named and forces drawn.
    unit
        Unit of the forces.

    Returns
    -------
    Scene
        Lines, symbols and texts of that pose.
    """
    series, number = series_of(motion, pose)
    places = PosePlaces(motion, number)
    scene = linkage_scene(places, plane(motion), names=names, loads=loads, force_unit=unit)
    scene.moves.extend(free_arrows(motion, number))
    there = assembled_of(motion, series)
    for other in there[:: max(1, len(there) // ghosts)] if ghosts else []:
        scene.strokes.extend(ghost(PosePlaces(motion, other)))
    for point in trace:
        path = rows_of(motion, motion.position(point))[series]
        scene.strokes.append(Stroke(path, "trace"))
    return scene


@styled
def plot_motion(
    motion: DrawnPoses,
    axes: Axes | None,
    pose: int | tuple[int, ...] | None,
    trace: Sequence[str],
    band: ArrayLike | None,
    regions: object,
    level: float,
    magnify: float | None,
    ghosts: int,
    names: bool,
    loads: bool,
    units: Units,
) -> Axes:
    """See `Motion.plot`."""
    scene = scene_of(motion, pose, trace, ghosts=ghosts, names=names, loads=loads, unit=units[1])
    title = ""
    if band is not None:
        if len(trace) != 1:
            raise FrameError(f"band= is of one point, and trace= names {len(trace)}: name the point that it belongs to")
        title = _add_band(scene, motion, trace[0], _samples(band), magnify)
    if regions is not None:
        lines = [title, _add_regions(scene, motion, series_of(motion, pose)[1], regions, level, magnify)]
        title = "\n".join(line for line in lines if line)
    if scene.moves:
        title = "\n".join(line for line in (title, FREE_TEXT) if line)
    found = axes_for(scene, axes)
    draw(scene, found)
    finish(scene, found, units[0], title)
    return found  # type: ignore[no-any-return]


@styled
def animate_motion(
    motion: DrawnPoses, axes: Axes | None, trace: Sequence[str], interval: float, names: bool, units: Units
) -> FuncAnimation:
    """See `Motion.animate`."""
    from matplotlib.animation import FuncAnimation

    series, _ = series_of(motion, None)
    there = assembled_of(motion, series)
    scenes = [_only(motion, k, trace, series, names, units[1]) for k in there]
    everything = Scene(strokes=[stroke for scene in scenes for stroke in scene.strokes], flat=scenes[0].flat)
    found = axes_for(everything, axes)
    # fix the limits that contain the lines of all poses
    drawn = draw(everything, found)
    finish(everything, found, units[0], legend=False)
    if everything.flat is None:
        frame_in_space(found, everything.points)
    else:
        found.set(xlim=found.get_xlim(), ylim=found.get_ylim())
    size = everything.size

    def show(frame: int) -> list[Any]:
        while drawn:
            drawn.pop().remove()
        drawn.extend(draw(scenes[frame], found, size))
        return drawn

    show(0)
    return FuncAnimation(found.get_figure(), show, frames=len(scenes), interval=interval)


def _only(motion: DrawnPoses, pose: int, trace: Sequence[str], series: list[int], names: bool, unit: str) -> Scene:
    """Scene of one pose, by its flat index, with the paths of points over a series of poses."""
    scene = linkage_scene(PosePlaces(motion, pose), plane(motion), names=names, force_unit=unit)
    scene.strokes.extend(Stroke(rows_of(motion, motion.position(point))[series], "trace") for point in trace)
    return scene


def _add_regions(
    scene: Scene, motion: DrawnPoses, pose: int, given: object, level: float, magnify: float | None
) -> str:
    """Add regions about points, in space as three outlines; returns a text with the factor on them."""
    regions = drawn_regions(motion, given, level)
    factor = magnified(regions, (pose,), scene.size) if magnify is None else magnify
    for number, region in enumerate(regions):
        for flat in [scene.flat] if scene.flat else [(0, 1), (1, 2), (0, 2)]:
            corners = outline_of(motion, region, pose, flat, factor)
            if scene.flat:
                scene.regions.append(Region(corners, "zone", region.point, number + 3))
            scene.strokes.append(Stroke(np.concatenate([corners, corners[:1]]), "zone", region.text, number + 3))
    return told(regions, factor)


def _samples(band: ArrayLike | object) -> Array:
    """Displacements of an array, or of an object with ``samples``, such as a `Spread`."""
    return np.asarray(getattr(band, "samples", band), dtype=float)


def _add_band(scene: Scene, motion: DrawnPoses, point: str, samples: Array, magnify: float | None) -> str:
    """Add the band that a point sweeps; returns a text with the factor on the displacements."""
    if len(motion.shape) != 1 or samples.ndim not in (2, 3) or len(samples) != motion.shape[0] or samples.shape[-1] < 2:
        raise FrameError(
            f"band has shape {samples.shape} and the motion {motion.shape}: give displacements of {point} by pose and"
            " sample, (poses, samples, 2 or more), or half widths by pose, (poses, 2 or more)"
        )
    path = motion.position(point)
    shift = np.zeros((*samples.shape[:-1], 3))
    shift[..., : min(3, samples.shape[-1])] = samples[..., :3]
    if samples.ndim == 2:
        corners = np.array([(x, y, z) for x in (-1.0, 1.0) for y in (-1.0, 1.0) for z in (-1.0, 1.0)])
        shift = shift[:, None] * corners
    factor = round_scale(shift, SHARE * scene.size) if magnify is None else magnify
    places = path[:, None] + factor * shift
    if scene.flat is None:
        paths = np.moveaxis(places, 1, 0)[:PATHS]
        scene.strokes.extend(Stroke(each, "sample") for each in paths)
    else:
        shown = list(scene.flat)
        for outline in swept(places[..., shown]):
            corners = np.zeros((len(outline), 3))
            corners[:, shown] = outline
            scene.regions.append(Region(corners, "band", point))
    return f"displacements of {point} × {factor:g}"
