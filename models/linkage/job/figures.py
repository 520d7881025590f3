"""Figures of the job: paths of the points with their displacements, and the forces in joints and drives."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ....framework.batch import Array
from ....framework.graphics.style import COLOURS, GREY, ORANGE, entry, figure, space_figure, styled
from ...job.figures import draw_histograms, draw_trajectory
from ..graphics.plane import ROUNDING
from .drawing import draw_mechanism

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from .result import RunResult

CAPTIONS = {
    "mechanism.png": "The linkage at {where}, faint at other poses; in orange the paths of the points and the drives.",
    "trajectory.png": "Path of {point}, displacements × {magnify:g}.",
    "reactions.png": "Forces in the joints, and forces or moments of the drives.",
    "histogram.png": "Displacement of {point} from its rigid position at {where}, with normal fits.",
    "figure3d.png": "The loaded linkage at {where} in space.",
}


def captions(result: RunResult) -> dict[str, str]:
    """Caption of each figure by the name of its file."""
    words: dict[str, Any] = {"where": result.where(result.pose), "magnify": result.magnify}
    words["point"] = result.inputs.points[0]
    return {name: text.format(**words) for name, text in CAPTIONS.items()}


def draw(result: RunResult) -> dict[str, Figure]:
    """All figures, by the names of their files."""
    points, pose = result.inputs.points, result.pose
    found = {"mechanism.png": draw_mechanism(result.motion, pose, points, result.where(pose))}
    found["trajectory.png"] = _trajectory(result)
    if spread := _spreading(result):
        name = points[0], "".join("xyz"[k] for k in spread)
        found["histogram.png"] = draw_histograms(_samples(result)[pose][:, spread], result.where(pose), name)
    found["reactions.png"] = draw_reactions(result)
    return found


def _trajectory(result: RunResult) -> Figure:
    if not result.spread or result.flat is None:
        return draw_paths(result)
    shown, point = list(result.flat), result.inputs.points[0]
    rigid = np.broadcast_to(result.main.rigid, (result.poses, 3))[:, shown]
    name = point, "".join("xyz"[k] for k in shown)
    samples, pose = _samples(result)[..., shown], result.pose
    return draw_trajectory(rigid, rigid, samples, result.magnify, pose, result.where(pose), name)


def _samples(result: RunResult) -> Array:
    """Displacement of the first point, (poses, samples, 3)."""
    return result.spread[result.inputs.points[0]].samples


def _spreading(result: RunResult) -> list[int]:
    """Components of the first point that spread at the pose shown; of the others a histogram would be one bar."""
    if not result.spread:
        return []
    spread = result.spread[result.inputs.points[0]]
    scale = np.abs(spread.mean[result.pose]).max() + result.size * ROUNDING
    return [k for k in result.shown if spread.std[result.pose, k] > ROUNDING * scale]


@styled
def draw_paths(result: RunResult) -> Figure:
    """Paths of all points, rigid and displaced; the displacements magnified."""
    shown = list(result.shown)
    axes: Any
    if result.flat is None:
        drawn_on, axes = space_figure(6.4, 5.2)
        axes.set_zlabel("z [mm]")
    else:
        drawn_on, (axes,) = figure(6.4, 4.4)
    for colour, (point, found) in zip(COLOURS, result.accuracy.items(), strict=False):
        rigid = 1e3 * np.broadcast_to(found.rigid, (result.poses, 3))[:, shown]
        moved = rigid + result.magnify * 1e3 * np.broadcast_to(found.total, (result.poses, 6))[:, shown]
        axes.plot(*rigid.T, color=GREY if len(result.accuracy) == 1 else colour, lw=1.0, label=entry(f"{point}, rigid"))
        axes.plot(*moved.T, color=colour, lw=1.3, ls="--", label=entry(f"{point}, loaded"))
        axes.plot(*rigid[result.pose : result.pose + 1].T, "o", mfc="none", mec=ORANGE, ms=8)
    axes.set_xlabel(f"{'xyz'[shown[0]]} [mm]")
    axes.set_ylabel(f"{'xyz'[shown[1]]} [mm]")
    axes.set_aspect("equal", **({} if result.flat is None else {"adjustable": "datalim"}))
    if result.flat is None:
        _few_ticks(axes)
    axes.set_title(f"displacements × {result.magnify:g}", loc="left")
    axes.legend(loc="best")
    return drawn_on


def _few_ticks(axes: Any) -> None:
    """Fewer numbers on axes in space that are short beside the longest."""
    each = (axes.xaxis, axes.yaxis, axes.zaxis)
    axes.xaxis.labelpad = axes.yaxis.labelpad = 9.0
    lengths = [float(np.ptp(axis.get_view_interval())) for axis in each]
    for axis, length in zip(each, lengths, strict=True):
        axis.get_major_locator().set_params(nbins=max(1, round(6 * length / max(lengths))))


@styled
def draw_reactions(result: RunResult) -> Figure:
    """Size of the force in every joint, and the forces or moments of the drives, over the first drive.

    Over the number of the pose where that drive goes to and fro. The greatest forces are named, the rest stay grey.
    """
    drawn_on, (left, right) = figure(7.6, 3.4, ratios=(1.0, 1.0))
    linkage, found = result.inputs.linkage, result.reactions
    forces = {j: np.linalg.norm(_rows(result, found.force(j))[:, :3], axis=-1) for j in linkage.joints}
    _draw_named(left, result, forces)
    units = {"r": "N m", "u": "N"}
    forces_of_drives = (force for joint in linkage.drives for force in _rows(result, found.drive(joint)).T)
    names = (f"{name} [{units[component[0]]}]" for _, component, name in result.inputs.driven)
    pushes = dict(zip(names, forces_of_drives, strict=True))
    _draw_named(right, result, pushes)
    name, drive = next(iter(result.inputs.drives.items()))
    over = f"{name} [{ {'deg': '°', 'rad': 'rad'}.get(drive.unit, 'm') }]" if result.increasing else "pose"
    for axes, label in ((left, "joint force [N]"), (right, "drive force or moment")):
        axes.set(xlabel=over, ylabel=label)
        axes.legend(loc="best", fontsize=7.0)
    return drawn_on


def _draw_named(axes: Any, result: RunResult, curves: Mapping[str, Array]) -> None:
    """Curves over the poses, the greatest in colour with their names, the others grey."""
    x = result.drive if result.increasing else np.arange(result.poses)
    style: Any = {"marker": "o"} if result.poses == 1 else {}
    size = {name: float(np.max(np.abs(curve), where=np.isfinite(curve), initial=0.0)) for name, curve in curves.items()}
    named = sorted(curves, key=lambda name: -size[name])[: len(COLOURS)]
    for name in curves:
        if name not in named:
            axes.plot(x, curves[name], color=GREY, lw=0.7, alpha=0.6, **style)
    for colour, name in zip(COLOURS, (name for name in curves if name in named), strict=False):
        axes.plot(x, curves[name], color=colour, lw=1.2, label=entry(name), **style)


def _rows(result: RunResult, values: Array) -> Array:
    return np.broadcast_to(values, (result.poses, values.shape[-1]))
