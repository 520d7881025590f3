"""The paper's Figure 5: the linkage to scale, with axes.

It returns a `matplotlib.figure.Figure`, without pyplot or a display.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.canvas import draw, finish
from ...framework.graphics.scene import JointSymbol, Label, LoadArrow, Scene, Stroke, Support
from ...framework.graphics.style import GREY, fitting_figure, note, styled, unit
from ...framework.graphics.units import quantity

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]

LINKS = {"crank": "AB", "coupler": "BPD", "rocker": "DE"}


@styled
def draw_linkage(points: Mapping[str, Array], load: tuple[float, float], theta: float) -> Figure:
    """Figure 5: the linkage at one pose with its drive clamped and the load at P.

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
    at = {name: np.array([*np.asarray(point, dtype=float)[:2], 0.0]) for name, point in points.items()}
    scene = linkage_scene(at, load)
    # room for the arrow of the load, whose length does not depend on the pose
    across, up = scene.extent
    drawn_on, axes = fitting_figure(6.4, (across, up + 0.2 * scene.size))
    axes.plot(*np.transpose([at["A"][:2], at["E"][:2]]), color=GREY, lw=0.8, ls=(0, (6, 4)), zorder=0)
    draw(scene, axes)
    _angle(axes, at["A"][:2], theta, min(0.16 * scene.size, 0.5 * float(np.linalg.norm(at["B"] - at["A"]))))
    for name, way in LINKS.items():
        _name_link(axes, name, at[way[0]][:2], at[way[1]][:2])
    finish(scene, axes, "m", legend=False)
    return drawn_on


def linkage_scene(at: Mapping[str, Array], load: tuple[float, float]) -> Scene:
    """Scene of the linkage: three links, a clamped drive, a pivot, the pins and the load.

    Parameters
    ----------
    at
        Positions (3,) of A, B, P, D and E, metres.
    load
        Force on P along x and y, newtons.

    Returns
    -------
    Scene
        The scene, in the plane.
    """
    force = np.array([*load, 0.0])
    size = float(np.linalg.norm(force))
    return Scene(
        strokes=[
            Stroke(np.array([at[p] for p in way]), "link", name, k) for k, (name, way) in enumerate(LINKS.items())
        ],
        joints=[JointSymbol(name, "revolute", at[name], np.eye(3)) for name in "BDE"]
        + [JointSymbol("A", "fixed", at["A"], np.eye(3))],
        supports=[Support(at["A"], clamped=True), Support(at["E"])],
        arrows=[LoadArrow(at["P"], force, quantity(size, "N"))] if size > 0.0 else [],
        labels=[Label(name, at[name]) for name in "ABPDE"],
        flat=(0, 1),
    )


def _angle(axes: Axes, at: Array, theta: float, radius: float) -> None:
    swept = np.linspace(0.0, theta, 120)
    axes.plot(*(at[:, None] + radius * np.stack([np.cos(swept), np.sin(swept)])), color=GREY, lw=0.9, zorder=0.5)
    way = np.array([np.cos(theta / 2), np.sin(theta / 2)])
    align = "left" if way[0] > 0.1 else "right"
    note(axes, f"θ = {np.degrees(theta):g}°", at + radius * way, 5.0 * way, va="center", ha=align)


def _name_link(axes: Axes, name: str, start: Array, end: Array) -> None:
    """Write the name of a link along and above it."""
    along = unit(end - start)
    slope = np.pi / 2 - (np.pi / 2 - np.arctan2(along[1], along[0])) % np.pi
    shift = 9.0 * np.array([-np.sin(slope), np.cos(slope)])
    text_style = {"rotation": np.degrees(slope), "rotation_mode": "anchor", "ha": "center", "va": "center"}
    note(axes, name, (start + end) / 2, shift, color=GREY, **text_style)
