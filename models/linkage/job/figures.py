"""Figures of the job: the linkage at one pose, paths of the points with their displacements, and the forces in joints
and drives."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.graphics.canvas import draw as draw_scene
from ....framework.graphics.canvas import few_ticks, finish, frame_in_space
from ....framework.graphics.style import (
    COLOURS,
    GREY,
    ORANGE,
    entry,
    figure,
    fitting_figure,
    space_figure,
    styled,
)
from ...job.figures import TracedPoint, draw_histograms, draw_trajectories
from ...job.force_figures import Over, draw_reactions
from ...job.measured import CAPTION, FIGURE_FILE
from ..graphics.plane import ROUNDING
from ..graphics.plots import scene_of

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from ..motion import Motion
    from .result import RunResult

CAPTIONS = {
    "mechanism.png": "The linkage at {where}, faint at other poses; in orange the paths of the points and the drives.",
    "trajectory.png": "Path of {point}, displacements × {magnify:g}; with tolerances also to scale at {where}.",
    "reactions.png": "Forces in the joints, and forces or moments of the drives.",
    "histogram.png": "Displacement of {point} from its rigid position at {where}, and whether a normal fit holds.",
    FIGURE_FILE: CAPTION,
    "figure3d.png": "The loaded linkage at {where} in space.",
}


def captions(result: RunResult) -> dict[str, str]:
    """Caption of each figure by the name of its file."""
    words: dict[str, Any] = {"where": result.where(result.pose), "magnify": result.magnify}
    words["point"] = ", ".join(result.inputs.points)
    return {name: text.format(**words) for name, text in CAPTIONS.items()}


def draw(result: RunResult) -> dict[str, Figure]:
    """All figures, by the names of their files."""
    points, pose = result.inputs.points, result.pose
    found = {"mechanism.png": draw_mechanism(result.motion, pose, points, result.where(pose))}
    found["trajectory.png"] = _trajectory(result)
    spreads = [
        (result.spread[point].samples[pose][:, ways], (point, "".join("xyz"[k] for k in ways)))
        for point in points
        if (ways := _spreading(result, point))
    ]
    if spreads:
        found["histogram.png"] = draw_histograms(spreads, result.where(pose))
    found["reactions.png"] = _reactions(result)
    return found


@styled
def draw_mechanism(motion: Motion, pose: int, points: Sequence[str], title: str = "") -> Figure:
    """Draw a linkage at one of its poses.

    Parameters
    ----------
    motion
        Its motion, (poses,).
    pose
        Number of the pose; if it is not assembled, the first assembled one is drawn.
    points
        Points whose paths are drawn.
    title
        Title of the figure.

    Returns
    -------
    Figure
        A drawing in the plane of motion, or in space.
    """
    there = bool(motion.shape) and bool(motion.is_assembled[pose])
    scene = scene_of(motion, pose if there else None, points)
    drawn_on, axes = space_figure(6.4, 5.2) if scene.flat is None else fitting_figure(6.4, scene.extent)
    draw_scene(scene, axes)
    finish(scene, axes, "m", title)
    return drawn_on


def _trajectory(result: RunResult) -> Figure:
    """Paths with samples of all points that have samples; without any, rigid and loaded paths."""
    shown = list(result.shown)
    traced = []
    for point, spread in result.spread.items():
        rigid = result.rows(result.accuracy[point].rigid)[:, shown]
        ways = "".join("xyz"[k] for k in shown)
        traced.append(TracedPoint(point, ways, rigid, rigid, spread.samples[..., shown]))
    if not traced:
        return draw_paths(result)
    return draw_trajectories(traced, result.magnify, result.pose, result.where(result.pose))


def _spreading(result: RunResult, point: str | None = None) -> list[int]:
    """Components of a point, by default the first, that vary at the pose shown; histograms of others are one bar."""
    if not result.spread:
        return []
    spread = result.spread[point or result.inputs.points[0]]
    scale = np.abs(spread.mean[result.pose]).max() + result.size * ROUNDING
    return [k for k in result.shown if spread.std[result.pose, k] > ROUNDING * scale]


@styled
def draw_paths(result: RunResult) -> Figure:
    """Draw the paths of all points, rigid and with magnified displacements."""
    shown = list(result.shown)
    axes: Any
    if result.flat is None:
        drawn_on, axes = space_figure(6.4, 5.2)
        axes.set_zlabel("z [mm]")
    else:
        drawn_on, (axes,) = figure(6.4, 4.4)
    for colour, (point, found) in zip(COLOURS, result.accuracy.items(), strict=False):
        rigid = 1e3 * result.rows(found.rigid)[:, shown]
        moved = rigid + result.magnify * 1e3 * result.rows(found.total)[:, shown]
        axes.plot(*rigid.T, color=GREY if len(result.accuracy) == 1 else colour, lw=1.0, label=entry(f"{point}, rigid"))
        axes.plot(*moved.T, color=colour, lw=1.3, ls="--", label=entry(f"{point}, loaded"))
        where = result.where(result.pose) if point == result.inputs.points[-1] else None
        axes.plot(*rigid[result.pose : result.pose + 1].T, "o", mfc="none", mec=ORANGE, ms=8, ls="", label=where)
    axes.set_xlabel(f"{'xyz'[shown[0]]} [mm]")
    axes.set_ylabel(f"{'xyz'[shown[1]]} [mm]")
    if result.flat is None:
        lines = np.concatenate([np.stack(line.get_data_3d(), axis=-1) for line in axes.lines])
        frame_in_space(axes, lines[np.isfinite(lines).all(axis=-1)])
    else:
        axes.set_aspect("equal", adjustable="datalim")
        few_ticks(axes)
    axes.set_title(f"displacements × {result.magnify:g}", loc="left")
    axes.legend(loc="best")
    return drawn_on


def _reactions(result: RunResult) -> Figure:
    """Forces in the joints, and forces or moments of the drives, over the first drive."""
    linkage, found = result.inputs.linkage, result.reactions
    forces = {j: np.linalg.norm(result.rows(found.force(j))[:, :3], axis=-1) for j in linkage.joints}
    units = {"r": "N m", "u": "N"}
    forces_of_drives = (force for joint in linkage.drives for force in result.rows(found.drive(joint)).T)
    driven = ((name, units[component[0]]) for _, component, name in result.inputs.driven)
    pushes = {name: (unit, push) for (name, unit), push in zip(driven, forces_of_drives, strict=True)}
    name, drive = next(iter(result.inputs.drives.items()))
    over = Over.drive(result.drive, f"{name} [{drive.sign}]", drive.unit == "deg")
    return draw_reactions(over, forces, pushes)
