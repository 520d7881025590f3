"""The paper's Figures 6 and 7 for a point of any linkage: its trajectory with its spread, and histograms.

Every function returns a `matplotlib.figure.Figure`; nothing here touches pyplot or a display.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.style import BLUE, GREY, INK, ORANGE, SKY, figure, styled
from ..moments import Moments
from ..sampling import Normal
from .envelope import swept

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

# Name of a point, and of the two directions in which it is drawn.
Point = tuple[str, str]

# More sampled paths and points than this only make the picture darker.
MOST_PATHS, MOST_POINTS = 200, 2000
# Fill of the region that samples sweep, and the name of its patches in the drawing.
PALE, ENVELOPE = "#edf3f9", "envelope"
# Samples that differ by less than this share of their size differ by rounding.
SAME = 1e-9


@styled
def draw_trajectory(
    path: Array, rigid: Array, samples: Array, magnify: float, pose: int, where: str, point: Point = ("P", "xy")
) -> Figure:
    """Figure 6: the rigid path of a point, the sampled paths and the boundary of what they sweep.

    Parameters
    ----------
    path
        Positions (..., 2 or more) along the whole path with rigid links and no clearance, in metres; the first two
        components are drawn.
    rigid
        The same at the poses, (poses, 2 or more).
    samples
        Displacements (poses, samples, 2 or more), in metres; NaN at singular poses.
    magnify
        Factor by which displacements are drawn larger than they are.
    pose
        Index of the pose that the right panel shows to true scale.
    where
        Which pose that is, such as ``"θ = 30°"``.
    point
        Name of the point and of the two directions.

    Returns
    -------
    Figure
        The path with displacements magnified, and one pose to true scale.
    """
    drawn_on, (left, right) = figure(7.6, 4.2, ratios=(1.25, 1.0))
    places, spread = 1e3 * rigid[:, :2], 1e3 * samples[..., :2]
    regular = np.asarray(np.isfinite(spread).all(axis=-1).any(axis=-1))

    moved = places[:, None] + magnify * spread
    _envelope(left, moved)
    drawn = moved[:, :MOST_PATHS]
    left.plot(drawn[..., 0], drawn[..., 1], color=SKY, lw=0.35, alpha=0.55, zorder=1)
    left.plot([], [], color=SKY, lw=1.0, label=f"{drawn.shape[1]} samples")
    left.plot([], [], color=BLUE, lw=1.1, label="their envelope")
    left.plot(*(1e3 * path[:, :2].T), color=INK, lw=1.0, zorder=4, label="rigid path")
    singular = ~regular & np.isfinite(places).all(axis=-1)
    if singular.any():
        left.plot(*places[singular].T, "x", color=ORANGE, ms=7, mew=1.6, zorder=5, label="singular pose", ls="")
    left.plot(*places[pose], "o", mfc="none", mec=ORANGE, ms=9, mew=1.2, zorder=6)
    name, x, y = point[0], point[1][0], point[1][1]
    left.set(xlabel=f"{x} of {name} [mm]", ylabel=f"{y} of {name} [mm]", aspect="equal", adjustable="datalim")
    left.set_title(f"displacements × {magnify:g}", loc="left")
    left.legend(loc="best", handlelength=1.6)

    cloud = spread[pose][np.isfinite(spread[pose]).all(axis=-1)]
    right.axhline(0.0, color=GREY, lw=0.6)
    right.axvline(0.0, color=GREY, lw=0.6)
    right.plot(*cloud[:MOST_POINTS].T, "o", color=SKY, mec=BLUE, mew=0.4, ms=3.6, label="samples")
    _ellipses(right, cloud)
    right.plot(*cloud.mean(0), "+", color=ORANGE, ms=10, mew=1.8, label="mean")
    right.set(aspect="equal", adjustable="datalim")
    right.set_xlabel(_displacement(x, name), parse_math=True)
    right.set_ylabel(_displacement(y, name), parse_math=True)
    right.set_title(f"true scale at {where}", loc="left")
    right.legend(loc="upper right", handlelength=1.6)
    return drawn_on


@styled
def draw_histograms(displacement: Array, where: str, point: Point = ("P", "xy")) -> Figure:
    """Figure 7: histograms of the displacement of a point at one pose, with normal fits.

    Parameters
    ----------
    displacement
        Displacements (samples, 1 to 3 or more), in metres; samples that are NaN do not count.
    where
        Which pose that is, such as ``"θ = 30°"``.
    point
        Name of the point and of one to three directions.

    Returns
    -------
    Figure
        One panel for each direction.
    """
    of, names = point
    drawn_on, panels = figure(3.8 * len(names), 3.2, ratios=(1.0,) * len(names))
    there = displacement[np.isfinite(displacement).all(axis=-1)]
    for axes, name, values in zip(panels, names, 1e3 * there[:, : len(names)].T, strict=True):
        if np.ptp(values) <= SAME * np.abs(values).max():
            _one_value(axes, _displacement(name, of), where, float(values[0]))
            continue
        moments = Moments.of(values)
        mean, std = float(moments.mean), float(moments.std)
        axes.hist(values, bins="auto", density=True, color=SKY, ec="white", lw=0.8)
        grid = np.linspace(min(values.min(), mean - 3.5 * std), max(values.max(), mean + 3.5 * std), 400)
        axes.plot(grid, Normal(mean, std).pdf(grid), color=BLUE, lw=1.6, label="normal fit")
        ticks = values[:MOST_PATHS]
        axes.plot(ticks, 0.0 * ticks, "|", color=INK, ms=7, mew=0.5, alpha=0.6, clip_on=False, zorder=5)
        axes.set_xlabel(_displacement(name, of), parse_math=True)
        axes.set_ylabel("density [1/mm]")
        title = (
            f"{where}, with standard errors:\nμ = {mean:.3f} ± {moments.standard_error:.3f} mm,"
            f"  σ = {std:.3f} ± {moments.std_standard_error:.3f} mm"
        )
        axes.set_title(title.replace("-", "−"), loc="left")
    return drawn_on


def _one_value(axes: Axes, label: str, where: str, value: float) -> None:
    """A panel for samples that are all the same."""
    axes.axvline(value, color=BLUE, lw=1.6)
    axes.set_xlabel(label, parse_math=True)
    axes.set_yticks([])
    axes.set_title(f"{where}, all samples the same: {value:.3g} mm".replace("-", "−"), loc="left")


def _displacement(way: str, point: str) -> str:
    """Label with mathematics, of which the point's name is none."""
    plain = point.replace("$", r"\$")
    return f"$u_{way}$ of {plain} [mm]"


def _envelope(axes: Axes, places: Array) -> None:
    """Draw the boundary of what the sampled paths (poses, samples, 2) sweep.

    It is what is left of the outlines of all steps, drawn in twice the width, when all of them are filled.
    """
    outlines = swept(places)
    for outline in outlines:
        axes.fill(*outline.T, fc="none", ec=BLUE, lw=2.2, joinstyle="round", zorder=0.2)
    for outline in outlines:
        axes.fill(*outline.T, fc=PALE, ec="none", zorder=0.3, gid=ENVELOPE)


def _ellipses(axes: Axes, cloud: Array) -> None:
    if len(cloud) < 3:
        return
    values, vectors = np.linalg.eigh(np.cov(cloud.T))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for scale, dashes in ((1.0, "-"), (2.0, "--")):
        ring = cloud.mean(0)[:, None] + scale * vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * circle)
        axes.plot(*ring, color=BLUE, lw=1.1, ls=dashes, label=f"{scale:g}σ ellipse")
