"""The paper's Figure 5: the linkage drawn.

It returns a `matplotlib.figure.Figure`; nothing here touches pyplot or a display.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.style import GREY, INK, ORANGE, SKY, figure, note, styled, unit

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]


@styled
def draw_linkage(points: Mapping[str, Array], load: tuple[float, float], theta: float) -> Figure:
    """Figure 5: the linkage at one pose, its drive clamped, its load at P.

    Parameters
    ----------
    points
        Positions (3,) of A, B, P, D and E, in metres.
    load
        Force on P along x and y, in newtons.
    theta
        Drive angle, in radians.

    Returns
    -------
    Figure
        The drawing.
    """
    at = {name: np.asarray(point, dtype=float)[:2] for name, point in points.items()}
    # Every size follows from the linkage, so that any four-bar is drawn alike.
    size = float(np.ptp(np.array(list(at.values())), axis=0).max())
    drawn_on, (axes,) = figure(6.4, 3.9)
    axes.set_aspect("equal")
    axes.axis("off")

    axes.plot(*np.transpose([at["A"], at["E"]]), color=GREY, lw=0.8, ls=(0, (6, 4)), zorder=0)
    _ground(axes, at["A"], 0.055 * size, clamped=True)
    _ground(axes, at["E"], 0.055 * size, clamped=False)
    for level, link in enumerate(("AB", "ED", "BPD"), start=2):
        _bar(axes, [at[name] for name in link], level)
    for name in "BDE":
        axes.plot(*at[name], "o", ms=7.5, mfc="white", mec=INK, mew=1.3, zorder=6)
    axes.plot(*at["A"], "s", ms=7.5, mfc=INK, mec=INK, zorder=6)
    axes.plot(*at["P"], "o", ms=5.0, mfc=ORANGE, mec=INK, mew=0.8, zorder=6)

    _arrow(axes, at["P"], load, 0.26 * size)
    _angle(axes, at["A"], theta, min(0.2 * size, 0.36 * float(np.linalg.norm(at["B"] - at["A"]))))
    _labels(axes, at, above=load[1] < 0.0)
    axes.margins(0.09)
    return drawn_on


def _bar(axes: Axes, ends: list[Array], level: float) -> None:
    for colour, width in ((INK, 9.0), (SKY, 7.0)):
        axes.plot(
            *np.transpose(ends), color=colour, lw=width, solid_capstyle="round", zorder=level + 0.01 * (9 - width)
        )


def _ground(axes: Axes, at: Array, size: float, clamped: bool) -> None:
    foot, half = at[1] - 1.6 * size, 1.1 * size
    outline = (
        [(-0.8, -1.6), (-0.8, 0.8), (0.8, 0.8), (0.8, -1.6)] if clamped else [(-0.8, -1.6), (0.0, 0.0), (0.8, -1.6)]
    )
    axes.fill(*(at + size * np.array(outline)).T, fc="#e6e6e6", ec=INK, lw=1.0, zorder=1)
    axes.plot([at[0] - half, at[0] + half], [foot, foot], color=INK, lw=1.3, zorder=1)
    for start in np.linspace(at[0] - half, at[0] + half, 7)[1:]:
        axes.plot([start, start - 0.42 * size], [foot, foot - 0.42 * size], color=INK, lw=0.8, zorder=1)


def _arrow(axes: Axes, tail: Array, load: tuple[float, float], length: float) -> None:
    force = float(np.hypot(*load))
    if force == 0.0:
        return
    tip: Array = tail + length * np.array(load) / force
    style = {"arrowstyle": "-|>,head_length=0.7,head_width=0.3", "color": ORANGE, "lw": 2.0, "shrinkA": 4, "shrinkB": 0}
    axes.annotate("", tuple(tip), tuple(tail), arrowprops=style, zorder=5)
    axes.plot(*tip, alpha=0.0)
    note(axes, f"{force:g} N", tip, (7.0, -3.0), color=ORANGE)


def _angle(axes: Axes, at: Array, theta: float, radius: float) -> None:
    swept = np.linspace(0.0, theta, 120)
    axes.plot(*(at[:, None] + radius * np.stack([np.cos(swept), np.sin(swept)])), color=GREY, lw=0.9, zorder=0.5)
    way = np.array([np.cos(theta / 2), np.sin(theta / 2)])
    align = "left" if way[0] > 0.1 else "right"
    note(axes, f"θ = {np.degrees(theta):g}°", at + radius * way, 5.0 * way, va="center", ha=align)


def _labels(axes: Axes, at: Mapping[str, Array], above: bool) -> None:
    # Pivots are labelled on the side away from their link, pins outside the corner, P away from its load.
    away = {name: -np.sign(at[link][0] - at[name][0] or 1.0) for name, link in (("A", "B"), ("E", "D"))}
    shifts = {"P": np.array([0.0, 15.0 if above else -15.0])} | {
        name: np.array([23.0 * side, -12.0]) for name, side in away.items()
    }
    shifts |= {"B": _corner(at["B"], at["A"], at["P"]), "D": _corner(at["D"], at["P"], at["E"])}
    for name, point in at.items():
        note(axes, f"${name}$", point, shifts[name], ha="center", va="center", fontsize=11, parse_math=True)
    for name, start, end in (("crank", "A", "B"), ("coupler", "B", "P"), ("rocker", "E", "D")):
        along = unit(at[end] - at[start])
        slope = np.pi / 2 - (np.pi / 2 - np.arctan2(along[1], along[0])) % np.pi
        shift = 11.0 * np.array([-np.sin(slope), np.cos(slope)])
        turned = {"rotation": np.degrees(slope), "rotation_mode": "anchor", "ha": "center", "va": "center"}
        note(axes, name, (at[start] + at[end]) / 2, shift, color=GREY, **turned)


def _corner(point: Array, first: Array, second: Array) -> Array:
    """Where the label of a pin goes: outside the corner of its two links, above where they are in line."""
    out = -unit(first - point) - unit(second - point)
    return 15.0 * (unit(out) if np.linalg.norm(out) > 0.2 else np.array([0.0, 1.0]))
