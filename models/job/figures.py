"""The paper's Figures 6 and 7 for points of any linkage: trajectories with their spread, and histograms.

Every function returns a `matplotlib.figure.Figure`; none uses pyplot or a display.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.canvas import few_ticks, frame_in_space
from ...framework.graphics.style import BLUE, GREY, INK, ORANGE, PALE, SKY, styled
from ..histograms import draw_histogram
from .envelope import swept

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Name of a point, and names of the directions in which it is drawn.
Point = tuple[str, str]

# Largest numbers of sampled paths and points that are drawn: more would only make the figure darker.
MOST_PATHS, MOST_POINTS = 200, 2000
# Identifier in the figure of the patches of the region that samples sweep.
ENVELOPE = "envelope"
# Style of legends that lie over curves.
PAPER: Any = {"frameon": True, "facecolor": "white", "edgecolor": "none", "framealpha": 0.85}


@dataclass(frozen=True, eq=False)
class TracedPoint:
    """Path and samples of a point that are drawn.

    Attributes
    ----------
    name, ways
        Its name, and the global directions that are drawn, two or three of ``xyz``.
    path
        Positions along the whole path with rigid links and no clearance, (k, directions), metres.
    rigid
        Such positions at the poses, (poses, directions), metres.
    samples
        Displacements, (poses, samples, directions), metres; NaN at singular poses.
    """

    name: str
    ways: str
    path: Array
    rigid: Array
    samples: Array


@styled
def draw_trajectories(points: Sequence[TracedPoint], magnify: float, pose: int, where: str) -> Figure:
    """Figure 6 for points, one below the other: the rigid path, sampled paths and the boundary of the swept region.

    Parameters
    ----------
    points
        The points, at least one.
    magnify
        Factor on drawn displacements.
    pose
        Index of the pose that the right panel shows to true scale.
    where
        That pose in words, such as ``"θ = 30°"``.

    Returns
    -------
    Figure
        For each point its path with magnified displacements and one pose to true scale; for a point in space the latter
        in the three coordinate planes.
    """
    from matplotlib.figure import Figure

    spatial = len(points[0].ways) > 2
    height = 7.4 if spatial else 4.2
    drawn_on = Figure(figsize=(7.6, height * len(points)), dpi=200, layout="constrained")
    for part, point in zip(drawn_on.subfigures(len(points), 1, squeeze=False)[:, 0], points, strict=True):
        if spatial:
            above, below = part.subfigures(2, 1, height_ratios=(1.9, 1.0))
            _path_in_space(above.add_subplot(projection="3d"), point, magnify, pose, where)
            for axes, pair in zip(below.subplots(1, 3), ((0, 1), (0, 2), (1, 2)), strict=True):
                _cloud(axes, point, pose, where, pair, legend=False)
        else:
            left, right = part.subplots(1, 2, width_ratios=(1.25, 1.0))
            _path(left, point, magnify, pose, where)
            _cloud(right, point, pose, where, (0, 1), legend=True)
    return drawn_on


def _path(axes: Axes, point: TracedPoint, magnify: float, pose: int, where: str) -> None:
    places, spread = 1e3 * point.rigid, 1e3 * point.samples
    moved = places[:, None] + magnify * spread
    _envelope(axes, moved)
    drawn = moved[:, :MOST_PATHS]
    axes.plot(drawn[..., 0], drawn[..., 1], color=SKY, lw=0.35, alpha=0.55, zorder=1)
    axes.plot([], [], color=SKY, lw=1.0, label=f"{drawn.shape[1]} samples")
    axes.plot([], [], color=BLUE, lw=1.1, label="their envelope")
    _rigid(axes, point, pose, where)
    name, x, y = point.name, point.ways[0], point.ways[1]
    axes.set(xlabel=f"{x} of {name} [mm]", ylabel=f"{y} of {name} [mm]", aspect="equal", adjustable="datalim")
    axes.set_title(f"displacements × {magnify:g}", loc="left")
    axes.legend(loc="best", handlelength=1.6, **PAPER)
    few_ticks(axes)


def _rigid(axes: Any, point: TracedPoint, pose: int, where: str) -> None:
    """Draw the rigid path, its singular poses, and the pose that is shown to true scale."""
    places, spread = 1e3 * point.rigid, point.samples
    axes.plot(*(1e3 * point.path.T), color=INK, lw=1.0, zorder=4, label="rigid path")
    regular = np.asarray(np.isfinite(spread).all(axis=-1).any(axis=-1))
    singular = ~regular & np.isfinite(places).all(axis=-1)
    if singular.any():
        axes.plot(*places[singular].T, "x", color=ORANGE, ms=7, mew=1.6, zorder=5, label="singular pose", ls="")
    at = places[pose : pose + 1].T
    axes.plot(*at, "o", mfc="none", mec=ORANGE, ms=9, mew=1.2, zorder=6, ls="", label=where)


def _path_in_space(axes: Any, point: TracedPoint, magnify: float, pose: int, where: str) -> None:
    moved = 1e3 * (point.rigid[:, None] + magnify * point.samples)
    for path in np.moveaxis(moved[:, :MOST_PATHS], 1, 0):
        axes.plot(*path.T, color=SKY, lw=0.4, alpha=0.6)
    axes.plot([], [], [], color=SKY, lw=1.0, label=f"{min(moved.shape[1], MOST_PATHS)} samples")
    _rigid(axes, point, pose, where)
    everything = np.concatenate([moved.reshape(-1, 3), 1e3 * point.path])
    frame_in_space(axes, everything[np.isfinite(everything).all(axis=-1)])
    axes.set(xlabel="x [mm]", ylabel="y [mm]", zlabel="z [mm]")
    axes.set_title(f"{point.name}, displacements × {magnify:g}", loc="left")
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0), handlelength=1.6)


def _cloud(axes: Axes, point: TracedPoint, pose: int, where: str, pair: tuple[int, int], *, legend: bool) -> None:
    """Draw displacements at one pose in two directions with their ellipses, and axes through zero if in view."""
    spread = 1e3 * point.samples[pose]
    cloud = spread[np.isfinite(spread).all(axis=-1)][:, pair]
    if not len(cloud):
        axes.set_title(f"no sample has a result at {where}", loc="left")
        axes.set_axis_off()
        return
    factor, unit = small(cloud)
    cloud = factor * cloud
    axes.plot(*cloud[:MOST_POINTS].T, "o", color=SKY, mec=BLUE, mew=0.4, ms=3.6, label="samples")
    _ellipses(axes, cloud)
    axes.plot(*cloud.mean(0), "+", color=ORANGE, ms=10, mew=1.8, label="mean")
    # a cloud that spreads in one direction only still has the width of its rounding errors
    axes.set(aspect="equal", adjustable="datalim")
    low, high = zip(axes.get_xlim(), axes.get_ylim(), strict=True)
    for least, most, line in zip(low, high, (axes.axvline, axes.axhline), strict=True):
        if least < 0.0 < most:
            line(0.0, color=GREY, lw=0.6)
    for axis, k in (("x", pair[0]), ("y", pair[1])):
        getattr(axes, f"set_{axis}label")(displacement_label(point.ways[k], point.name, unit), parse_math=True)
    axes.set_title(f"true scale at {where}", loc="left")
    if legend:
        axes.legend(loc="best", handlelength=1.6, **PAPER)
    few_ticks(axes, 5)


@styled
def draw_histograms(spreads: Sequence[tuple[Array, Point]], where: str) -> Figure:
    """Figure 7 for points, one below the other: histograms of their displacements at one pose, with normal fits.

    Parameters
    ----------
    spreads
        For each point: displacements (samples, directions or more), in metres, without those that are NaN; and its name
        with the names of one to three directions.
    where
        The pose in words, such as ``"θ = 30°"``.

    Returns
    -------
    Figure
        A row of panels for each point.
    """
    from matplotlib.figure import Figure

    most = max(len(names) for _, (_, names) in spreads)
    drawn_on = Figure(figsize=(max(4.2, 3.8 * most), 3.4 * len(spreads)), dpi=200, layout="constrained")
    for row, (displacement, (of, names)) in zip(
        drawn_on.subfigures(len(spreads), 1, squeeze=False)[:, 0], spreads, strict=True
    ):
        there = displacement[np.isfinite(displacement).all(axis=-1)]
        panels = row.subplots(1, len(names), squeeze=False)[0]
        for axes, name, values in zip(panels, names, 1e3 * there[:, : len(names)].T, strict=True):
            factor, unit = small(values)
            draw_histogram(axes, factor * values, displacement_label(name, of), unit, where)
    return drawn_on


def small(values: Array) -> tuple[float, str]:
    """Factor on lengths in mm, and their unit then: a smaller one if all lengths are small."""
    greatest = float(np.abs(values).max(initial=0.0, where=np.isfinite(values)))
    if greatest == 0.0 or greatest >= 0.1:
        return 1.0, "mm"
    return (1e3, "µm") if greatest >= 1e-4 else (1e6, "nm")


def displacement_label(way: str, point: str, unit: str = "") -> str:
    """Label with mathematical text, except for the point's name."""
    plain = point.replace("$", r"\$")
    return f"$u_{way}$ of {plain}{f' [{unit}]' if unit else ''}"


def _envelope(axes: Axes, places: Array) -> None:
    """Draw the boundary of the region that the sampled paths (poses, samples, 2) sweep.

    The outlines of all steps are drawn with twice the width and then filled, so that only the boundary remains.
    """
    from matplotlib.patches import Polygon

    outlines = swept(places)
    if not outlines:
        return
    looks: tuple[dict[str, Any], ...] = (
        {"fc": "none", "ec": BLUE, "lw": 2.2, "joinstyle": "round", "zorder": 0.2},
        {"fc": PALE, "ec": "none", "zorder": 0.3, "gid": ENVELOPE},
    )
    for look in looks:
        for outline in outlines:
            axes.add_artist(Polygon(outline, **look))
    # the corners of all at once, as add_patch would look for extrema along each edge
    axes.update_datalim(np.concatenate(outlines))
    axes.autoscale_view()


def _ellipses(axes: Axes, cloud: Array) -> None:
    if len(cloud) < 3:
        return
    values, vectors = np.linalg.eigh(np.cov(cloud.T))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for scale, dashes in ((1.0, "-"), (2.0, "--")):
        ring = cloud.mean(0)[:, None] + scale * vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * circle)
        axes.plot(*ring, color=BLUE, lw=1.1, ls=dashes, label=f"{scale:g}σ ellipse")
