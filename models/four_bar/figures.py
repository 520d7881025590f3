"""The paper's Figures 5 to 7: the linkage drawn, the trajectory with its spread, the histograms.

Every function returns a `matplotlib.figure.Figure`; nothing here touches pyplot or a display.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy import stats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Inputs = ParamSpec("Inputs")

# More sampled paths and points than this only make the picture darker.
MOST_PATHS, MOST_POINTS = 200, 2000

INK, GREY, BLUE, SKY, ORANGE = "#222222", "#8c8c8c", "#0b5394", "#9cc3e6", "#d55e00"
STYLE: Any = {
    "font.size": 9.0,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "legend.frameon": False,
    "xtick.direction": "out",
    "ytick.direction": "out",
}


def styled(draw: Callable[Inputs, Figure]) -> Callable[Inputs, Figure]:
    """Let `draw` run under `STYLE`, whatever the user's own matplotlib settings are."""

    @wraps(draw)
    def wrapper(*args: Inputs.args, **kwargs: Inputs.kwargs) -> Figure:
        from matplotlib import rc_context

        with rc_context(STYLE):
            return draw(*args, **kwargs)

    return wrapper


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
    figure, (axes,) = _figure(6.4, 3.9)
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
    return figure


@styled
def draw_trajectory(path: Array, rigid: Array, samples: Array, magnify: float, pose: int, theta: Array) -> Figure:
    """Figure 6: the rigid path of P, the sampled paths and their envelope.

    Parameters
    ----------
    path
        Positions (..., 3) of P along the whole path with rigid links and no clearance, in metres.
    rigid
        The same at the poses, (poses, 3).
    samples
        Displacements (poses, samples, 3) of P, in metres; NaN at singular poses.
    magnify
        Factor by which displacements are drawn larger than they are.
    pose
        Index of the pose that the right panel shows to true scale.
    theta
        Drive angles (poses,), in radians.

    Returns
    -------
    Figure
        The path with displacements magnified, and one pose to true scale.
    """
    figure, (left, right) = _figure(7.6, 4.2, ratios=(1.25, 1.0))
    places, spread = 1e3 * rigid[:, :2], 1e3 * samples[..., :2]
    normal = path_normal(rigid)
    regular = np.asarray(np.isfinite(spread).all((1, 2)))

    across = np.einsum("psk,pk->ps", spread, normal)

    drawn = places[:, None] + magnify * spread[:, :MOST_PATHS]
    left.plot(drawn[..., 0], drawn[..., 1], color=SKY, lw=0.35, alpha=0.55, zorder=1)
    left.plot([], [], color=SKY, lw=1.0, label=f"{drawn.shape[1]} samples")
    for edge, label in ((across.min(-1), "envelope"), (across.max(-1), None)):
        line = places + magnify * edge[:, None] * normal
        left.plot(*np.where(regular[:, None], line, np.nan).T, color=BLUE, lw=1.1, zorder=3, label=label)
    left.plot(*(1e3 * path[:, :2].T), color=INK, lw=1.0, zorder=4, label="rigid path")
    if not regular.all():
        left.plot(*places[~regular].T, "x", color=ORANGE, ms=7, mew=1.6, zorder=5, label="singular pose", ls="")
    left.plot(*places[pose], "o", mfc="none", mec=ORANGE, ms=9, mew=1.2, zorder=6)
    left.set(xlabel="x of P [mm]", ylabel="y of P [mm]", aspect="equal", adjustable="datalim")
    left.set_title(f"displacements × {magnify:g}", loc="left")
    left.legend(loc="best", handlelength=1.6)

    cloud = spread[pose]
    right.axhline(0.0, color=GREY, lw=0.6)
    right.axvline(0.0, color=GREY, lw=0.6)
    right.plot(*cloud[:MOST_POINTS].T, "o", color=SKY, mec=BLUE, mew=0.4, ms=3.6, label="samples")
    _ellipses(right, cloud)
    right.plot(*cloud.mean(0), "+", color=ORANGE, ms=10, mew=1.8, label="mean")
    right.set(xlabel="$u_x$ of P [mm]", ylabel="$u_y$ of P [mm]", aspect="equal", adjustable="datalim")
    right.set_title(f"true scale at θ = {np.degrees(theta[pose]):g}°", loc="left")
    right.legend(loc="upper right", handlelength=1.6)
    return figure


@styled
def draw_histograms(displacement: Array, theta: float) -> Figure:
    """Figure 7: histograms of the displacement of P at one pose, with normal fits.

    Parameters
    ----------
    displacement
        Displacements (samples, 3) of P, in metres.
    theta
        Drive angle, in radians.

    Returns
    -------
    Figure
        One panel for x and one for y.
    """
    figure, panels = _figure(7.6, 3.2, ratios=(1.0, 1.0))
    for axes, name, values in zip(panels, "xy", 1e3 * displacement[:, :2].T, strict=True):
        mean, std = values.mean(), values.std(ddof=1)
        axes.hist(values, bins="auto", density=True, color=SKY, ec="white", lw=0.8)
        grid = np.linspace(min(values.min(), mean - 3.5 * std), max(values.max(), mean + 3.5 * std), 400)
        axes.plot(grid, stats.norm.pdf(grid, mean, std), color=BLUE, lw=1.6, label="normal fit")
        ticks = values[:MOST_PATHS]
        axes.plot(ticks, 0.0 * ticks, "|", color=INK, ms=7, mew=0.5, alpha=0.6, clip_on=False, zorder=5)
        axes.set(xlabel=f"$u_{name}$ of P [mm]", ylabel="density [1/mm]")
        title = f"θ = {np.degrees(theta):g}°,  μ = {mean:.3f} mm,  σ = {std:.3f} mm"
        axes.set_title(title.replace("-", "−"), loc="left")
    return figure


def path_normal(rigid: Array) -> Array:
    """Unit normals, (poses, 2), of the path `rigid` (poses, 3), to the left of its direction.

    Parameters
    ----------
    rigid
        Positions (poses, 3) along the path, in metres.

    Returns
    -------
    Array
        Unit vectors (poses, 2).
    """
    tangent = np.gradient(rigid[:, :2], axis=0) if len(rigid) > 1 else np.array([[1.0, 0.0]])
    normal = np.stack([-tangent[:, 1], tangent[:, 0]], axis=-1)
    length = np.linalg.norm(normal, axis=-1, keepdims=True)
    return np.asarray(np.divide(normal, length, out=np.zeros_like(normal), where=length > 0.0))


def _figure(width: float, height: float, ratios: tuple[float, ...] = (1.0,)) -> tuple[Figure, list[Axes]]:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
    return figure, list(figure.subplots(1, len(ratios), width_ratios=ratios, squeeze=False)[0])


def _note(axes: Axes, text: str, at: Array, shift: ArrayLike, **style: Any) -> None:
    """Write `text` at a point, `shift` points of type away from it."""
    (x, y), (across, up) = at, np.asarray(shift)
    axes.annotate(text, (x, y), (across, up), textcoords="offset points", **style)


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
    _note(axes, f"{force:g} N", tip, (7.0, -3.0), color=ORANGE)


def _angle(axes: Axes, at: Array, theta: float, radius: float) -> None:
    swept = np.linspace(0.0, theta, 120)
    axes.plot(*(at[:, None] + radius * np.stack([np.cos(swept), np.sin(swept)])), color=GREY, lw=0.9, zorder=0.5)
    way = np.array([np.cos(theta / 2), np.sin(theta / 2)])
    align = "left" if way[0] > 0.1 else "right"
    _note(axes, f"θ = {np.degrees(theta):g}°", at + radius * way, 5.0 * way, va="center", ha=align)


def _labels(axes: Axes, at: Mapping[str, Array], above: bool) -> None:
    # Pivots are labelled on the side away from their link, pins outside the corner, P away from its load.
    away = {name: -np.sign(at[link][0] - at[name][0] or 1.0) for name, link in (("A", "B"), ("E", "D"))}
    shifts = {"P": np.array([0.0, 15.0 if above else -15.0])} | {
        name: np.array([23.0 * side, -12.0]) for name, side in away.items()
    }
    shifts |= {"B": _corner(at["B"], at["A"], at["P"]), "D": _corner(at["D"], at["P"], at["E"])}
    for name, point in at.items():
        _note(axes, f"${name}$", point, shifts[name], ha="center", va="center", fontsize=11)
    for name, start, end in (("crank", "A", "B"), ("coupler", "B", "P"), ("rocker", "E", "D")):
        along = _unit(at[end] - at[start])
        slope = np.pi / 2 - (np.pi / 2 - np.arctan2(along[1], along[0])) % np.pi
        shift = 11.0 * np.array([-np.sin(slope), np.cos(slope)])
        turned = {"rotation": np.degrees(slope), "rotation_mode": "anchor", "ha": "center", "va": "center"}
        _note(axes, name, (at[start] + at[end]) / 2, shift, color=GREY, **turned)


def _corner(point: Array, first: Array, second: Array) -> Array:
    """Where the label of a pin goes: outside the corner of its two links, above where they are in line."""
    out = -_unit(first - point) - _unit(second - point)
    return 15.0 * (_unit(out) if np.linalg.norm(out) > 0.2 else np.array([0.0, 1.0]))


def _unit(vector: Array) -> Array:
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector


def _ellipses(axes: Axes, cloud: Array) -> None:
    if len(cloud) < 3:
        return
    values, vectors = np.linalg.eigh(np.cov(cloud.T))
    turn = np.linspace(0.0, 2.0 * np.pi, 200)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    for scale, dashes in ((1.0, "-"), (2.0, "--")):
        ring = cloud.mean(0)[:, None] + scale * vectors @ (np.sqrt(np.maximum(values, 0.0))[:, None] * circle)
        axes.plot(*ring, color=BLUE, lw=1.1, ls=dashes, label=f"{scale:g}σ ellipse")
