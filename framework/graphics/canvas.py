"""A scene drawn with matplotlib, in a plane or in space."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from ..batch import Array
from ..errors import FrameError
from . import symbols
from .scene import Region, Scene, Stroke
from .style import COLOURS, GREY, INK, ORANGE, PALE, SKY, STYLE, entry, fitting_height, set_title
from .texts import texts_in_plane, texts_in_space

if TYPE_CHECKING:
    from matplotlib.axes import Axes

# Length of the longest arrow as a share of what is drawn.
ARROW = 0.2
# How wide a digit is beside its size, and the least size of numbers, points.
LETTER, SMALLEST = 0.62, 5.5
# Least radius of a pin, points, and room for numbers and labels about axes in space, inches.
LEAST_PIN, NUMBERS = 2.8, 0.57
# Share of the longest side of a box below which others count no less for the distance of its numbers.
LEAST_SIDE = 0.2
# Colour of motions that nothing resists.
FREE = COLOURS[3]
LOOKS: dict[str, dict[str, Any]] = {
    "link": {"lw": 3.2, "solid_capstyle": "round", "zorder": 4},
    "zone": {"lw": 1.2, "zorder": 7},
    "outline": {"lw": 1.8, "solid_capstyle": "round", "solid_joinstyle": "round", "zorder": 3.6},
    "ghost": {"color": GREY, "lw": 0.7, "alpha": 0.35, "zorder": 1},
    "undeformed": {"color": GREY, "lw": 1.0, "ls": (0, (5, 3)), "zorder": 2},
    "member": {"color": INK, "lw": 2.4, "solid_capstyle": "round", "zorder": 4},
    "rigid": {"color": INK, "lw": 1.4, "zorder": 3},
    "spring": {"color": INK, "lw": 1.1, "zorder": 4.5},
    "trace": {"color": ORANGE, "lw": 1.4, "zorder": 2.5},
    "sample": {"color": SKY, "lw": 0.4, "alpha": 0.6, "zorder": 1.2},
    "ordinate": {"color": COLOURS[0], "lw": 0.5, "alpha": 0.7, "zorder": 3},
    "diagram": {"color": COLOURS[0], "lw": 1.2, "zorder": 3.2},
}
# Kinds that take the colour of their number.
COLOURED = ("link", "outline", "zone")
FILLS = {"link": 0.13, "diagram": 0.18, "zone": 0.3}


# Width of a new figure, inches.
_WIDTH = 6.4


def axes_for(scene: Scene, axes: Axes | None) -> Any:
    """Axes to draw a scene on: those given, or new ones of a figure that pyplot shows.

    Parameters
    ----------
    scene
        What will be drawn.
    axes
        Of matplotlib; None for new ones.

    Returns
    -------
    matplotlib.axes.Axes
        In space for a scene in space.

    Raises
    ------
    FrameError
        If a scene in space is to be drawn on axes in the plane.
    """
    if axes is not None:
        if scene.flat is None and getattr(axes, "name", "") != "3d":
            raise FrameError("this is in space, and ax is flat: make it with projection='3d', or leave it out")
        return axes
    import matplotlib.pyplot as plt

    with plt.rc_context(STYLE):
        if scene.flat is None:
            return plt.figure(figsize=(_WIDTH, 0.82 * _WIDTH), layout="constrained").add_subplot(projection="3d")
        height = fitting_height(_WIDTH, scene.extent)
        return plt.figure(figsize=(_WIDTH, height), layout="constrained").add_subplot()


def draw(scene: Scene, axes: Any, size: float | None = None) -> list[Any]:
    """Draw a scene.

    Parameters
    ----------
    scene
        What is drawn.
    axes
        Where.
    size
        Length that rules the size of symbols; that of the scene where None.

    Returns
    -------
    list of matplotlib.artist.Artist
        What was added.
    """
    size = scene.size if size is None else size
    if getattr(axes, "name", "") == "3d":
        return _in_space(scene, axes, size)
    return _in_plane(scene, axes, size, scene.flat or (0, 1))


def finish(scene: Scene, axes: Any, unit: str, title: str = "", legend: bool = True) -> None:
    """Label the axes in units of length, set equal scales and limits that fit the drawing, and add a legend of links.

    Parameters
    ----------
    scene
        What was drawn.
    axes
        Where.
    unit
        Unit of length.
    title
        What stands above.
    legend
        Whether names of links stand in a legend.
    """
    spatial = getattr(axes, "name", "") == "3d"
    shown = (0, 1, 2) if spatial else scene.flat or (0, 1)
    for way, axis in zip(shown, ("x", "y", "z"), strict=False):
        getattr(axes, f"set_{axis}label")(f"{'xyz'[way]} [{unit}]")
    if spatial:
        frame_in_space(axes, scene.points)
    else:
        axes.set_aspect("equal", adjustable="box")
        axes.margins(*_room(axes))
        axes.spines[["top", "right"]].set_visible(False)
        few_ticks(axes)
    if title:
        set_title(axes, title)
    named = axes.get_legend_handles_labels()[1]
    if legend and 0 < len(named) <= len(COLOURS):
        place: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.0, 1.0)}
        axes.legend(fontsize=7.5, frameon=False, handlelength=1.4, **({} if spatial else place))


def _room(axes: Any) -> tuple[float, float]:
    """Shares of width and height left free on each side, as long both ways: room for names at the edge."""
    box = axes.dataLim
    most = max(box.width, box.height)
    across, up = (0.05 * most / side if side > 0.02 * most else 0.05 for side in (box.width, box.height))
    return across, up


def few_ticks(axes: Any, most: int = 6) -> None:
    """No more numbers along an axis than fit beside each other, however many digits they have."""
    axes.apply_aspect()  # on which the limits depend
    width, height = axes.bbox.width / axes.figure.dpi, axes.bbox.height / axes.figure.dpi
    for axis, inches in ((axes.xaxis, width), (axes.yaxis, 2.0 * height)):
        locator = axis.get_major_locator()
        if axis.get_scale() == "linear" and hasattr(locator, "set_params"):
            count = int(np.clip(1.4 * inches, 2, most))
            locator.set_params(nbins=count)
            if axis is axes.xaxis:
                _fit_numbers(axis, inches, count)


def _fit_numbers(axis: Any, inches: float, most: int) -> None:
    """Numbers as small, and then as few, as they must be to stand beside each other, where a step has many digits."""
    size = axis.get_major_ticks()[0].label1.get_size()
    for count in range(most, 0, -1):
        if count < most:
            axis.get_major_locator().set_params(nbins=count, min_n_ticks=1)
        room = _room_of_numbers(axis, inches)
        if room >= SMALLEST:
            break
    if room < size:
        axis.set_tick_params(labelsize=max(room, SMALLEST))


def _room_of_numbers(axis: Any, inches: float) -> float:
    """Greatest size, points, at which the numbers along an axis stand beside each other."""
    low, high = np.sort(axis.get_view_interval())
    places = axis.get_majorticklocs()
    letters = max(map(len, axis.get_major_formatter().format_ticks(places)), default=0)
    places = places[(places >= low) & (places <= high)]
    if len(places) < 2 or not letters:
        return np.inf
    step = inches * float(np.diff(places).min()) / float(high - low)
    # The layout makes axes narrower still, to find room for labels.
    return 0.85 * 72.0 * step / (LETTER * (letters + 1))


def frame_in_space(axes: Any, points: Array) -> None:
    """Axes in space about points (n, 3): to scale, with fewer numbers on the short sides, and room for the labels."""
    low, high = points.min(axis=0), points.max(axis=0)
    # What lies in one point has room about it all the same.
    least = 0.12 * float((high - low).max()) or 0.01 * float(np.abs(high).max()) or 1.0
    room = np.maximum(0.02 * (high - low), 0.5 * (least - (high - low)))
    low, high = low - room, high + room
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), zlim=(low[2], high[2]))
    # Smaller than the space for it, so that numbers and labels are not cut off; a tower has them below.
    tower = max(0.0, float((high - low)[2] / np.linalg.norm(high - low)) - 0.6)
    side = min(axes.bbox.width, axes.bbox.height) / axes.figure.dpi
    axes.set_box_aspect(high - low, zoom=float(np.clip(1.0 - NUMBERS / side, 0.5, 0.9)) - 0.4 * tower)
    shares = (high - low) / (high - low).max()
    for k, axis in enumerate((axes.xaxis, axes.yaxis, axes.zaxis)):
        axis.get_major_locator().set_params(nbins=max(1, round(5.0 * min(1.0, side / 3.5) * shares[k])), min_n_ticks=1)
        # Numbers and labels stand off in shares of the other two sides: of short ones in greater shares.
        across = max(LEAST_SIDE, float(np.delete(shares, k).max()))
        axis.set_tick_params(labelsize=7.0, pad=9.0 / across - 8.0)
        axis.labelpad = 28.0 / across - 21.0


# -- in a plane -------------------------------------------------------------------------------------------------------


def _in_plane(scene: Scene, axes: Any, size: float, flat: tuple[int, int]) -> list[Any]:
    shown = list(flat)
    across, up = scene.extent
    inches = min(axes.bbox.width / across, axes.bbox.height / up) / axes.figure.dpi  # to a length
    pin = max(scene.pin(size), LEAST_PIN / 72.0 / inches)
    out: list[Any] = []
    for region in scene.regions:
        for look in _fills(region):
            out += axes.fill(*region.points[:, shown].T, **look)
    for stroke in scene.strokes:
        if stroke.values is not None:
            out.append(_coloured(axes, stroke.points[:, shown], stroke.values))
        else:
            out += axes.plot(*stroke.points[:, shown].T, **_look(stroke))
    for support in scene.supports:
        out += _support(axes, support.at[shown], 1.15 * pin, support.clamped)
    for joint in scene.joints:
        out += _joint(axes, joint, pin, shown)
    arrows = _drawn_arrows(scene, shown, size)
    for at, tip in arrows:
        out += _arrow(axes, at, tip)
    for move in scene.moves:
        out += _move(axes, move.at[shown], ARROW * size * move.force[shown])
    return out + texts_in_plane(axes, scene, shown, pin, arrows)


def _look(stroke: Stroke) -> dict[str, Any]:
    look = dict(LOOKS.get(stroke.kind, LOOKS["rigid"]))
    if stroke.kind in COLOURED:
        look["color"] = COLOURS[stroke.number % len(COLOURS)]
    if stroke.name:
        look["label"] = entry(stroke.name)
    return look | {"gid": stroke.kind}


def _fills(region: Region) -> list[dict[str, Any]]:
    """How a polygon is filled; of a band first the edges of all its parts, so that those inside are covered."""
    if region.kind == "band":
        edge = {"fc": "none", "ec": COLOURS[0], "lw": 2.0, "joinstyle": "round", "zorder": 0.2}
        return [edge, {"fc": PALE, "ec": "none", "zorder": 0.3, "gid": "band"}]
    colour = COLOURS[region.number % len(COLOURS)]
    return [{"fc": colour, "alpha": FILLS.get(region.kind, 0.15), "ec": "none", "zorder": 0.8, "gid": region.kind}]


def _coloured(axes: Any, points: Array, values: Array) -> Any:
    """A line coloured by its values (k,); its caller gives the range of colours."""
    from matplotlib.collections import LineCollection

    pieces = np.stack([points[:-1], points[1:]], axis=1)
    bars = LineCollection(list(pieces), cmap="viridis", lw=5.0, capstyle="round", zorder=4, gid="values")
    bars.set_array(0.5 * (values[:-1] + values[1:]))
    return axes.add_collection(bars)


def _support(axes: Any, at: Array, size: float, clamped: bool) -> list[Any]:
    body = symbols.CLAMP if clamped else symbols.PIVOT
    out = axes.fill(*(at + size * body).T, fc="#e6e6e6", ec=INK, lw=0.9, zorder=3.2, gid="support")
    for line in symbols.FOOT:
        out += axes.plot(*(at + size * line).T, color=INK, lw=0.8, zorder=3.2)
    return list(out)


def _joint(axes: Any, joint: Any, pin: float, shown: list[int]) -> list[Any]:
    at, axis = joint.at[shown], joint.axes[shown, 2]
    found = symbols.glyph(joint.kind, axis)
    out: list[Any] = []
    if joint.grounded:
        if joint.kind == "prismatic" and np.linalg.norm(axis) > 0.5:
            for line in symbols.GUIDE:
                out += axes.plot(*symbols.placed(line, at, pin, axis).T, color=INK, lw=0.8, zorder=3.2)
        else:
            out += _support(axes, at, pin, clamped=False)
    colour = ORANGE if joint.driven else "white"
    body = symbols.placed(found.body, at, pin, axis)
    out += axes.fill(*body.T, fc=colour, ec=INK, lw=1.0, zorder=6, gid=f"joint {joint.name}")
    for line in found.lines:
        out += axes.plot(*symbols.placed(line, at, pin, axis).T, color=INK, lw=0.8, zorder=6.1)
    if joint.driven:
        slides = joint.kind in ("prismatic", "cylindrical") and np.linalg.norm(axis) > 0.5
        way = symbols.placed(symbols.SHAFT if slides else symbols.ARC, at, pin, axis)
        out.append(_arrow_along(axes, way))
    return out


def _arrow_along(axes: Any, way: Array) -> Any:
    """A line (k, 2) with an arrow's head at its end."""
    from matplotlib.patches import FancyArrowPatch
    from matplotlib.path import Path

    style = "-|>,head_length=4,head_width=2"
    return axes.add_patch(FancyArrowPatch(path=Path(way), arrowstyle=style, color=ORANGE, lw=1.4, zorder=5.5))


def _longest(scene: Scene) -> float:
    return max((float(np.linalg.norm(arrow.force)) for arrow in scene.arrows), default=0.0)


def _drawn(force: Array, longest: float, size: float) -> Array:
    """A force (k,) as it is drawn: no shorter than can be seen, and nothing where it is square to the figure."""
    share = float(np.linalg.norm(force)) / longest if longest else 0.0
    return np.zeros_like(force) if share < 1e-9 else ARROW * size * max(share, 0.25) * force / np.linalg.norm(force)


def _arrow(axes: Any, at: Array, tip: Array) -> list[Any]:
    """A force that pulls at its place; square to the figure it is a cross."""
    if not (tip - at).any():
        return list(axes.plot(*at[:, None], "x", color=ORANGE, ms=8, mew=1.6, zorder=7, gid="load"))
    style = {"arrowstyle": "-|>,head_length=0.6,head_width=0.25", "color": ORANGE, "lw": 1.8, "shrinkA": 3}
    out = [axes.annotate("", tuple(tip), tuple(at), arrowprops={**style, "shrinkB": 0}, zorder=7, gid="load")]
    # An annotation does not count where axes are to hold everything: its end does.
    return [*out, *axes.plot(*tip[:, None], alpha=0.0)]


def _move(axes: Any, at: Array, way: Array) -> list[Any]:
    """An arrow of a free motion; square to the figure it is nothing."""
    if np.linalg.norm(way) == 0.0:
        return []
    tip = at + way
    style = {"arrowstyle": "-|>,head_length=0.5,head_width=0.22", "color": FREE, "lw": 1.5, "shrinkA": 3, "shrinkB": 0}
    return [
        axes.annotate("", tuple(tip), tuple(at), arrowprops=style, zorder=6.8, gid="free motion"),
        *axes.plot(*tip[:, None], alpha=0.0),
    ]


def _drawn_arrows(scene: Scene, shown: list[int], size: float) -> list[Array]:
    """Forces as they are drawn, from their places to their tips, (2, 2) or (2, 3) each."""
    longest = _longest(scene)
    return [
        np.stack([arrow.at[shown], arrow.at[shown] + _drawn(arrow.force[shown], longest, size)])
        for arrow in scene.arrows
    ]


# -- in space ---------------------------------------------------------------------------------------------------------

MARKERS = {"revolute": "o", "prismatic": "s", "cylindrical": "D", "screw": "D", "planar": "s", "fixed": "X"}


def _in_space(scene: Scene, axes: Any, size: float) -> list[Any]:
    from mpl_toolkits.mplot3d.art3d import Line3DCollection, Poly3DCollection

    out: list[Any] = []
    for region in scene.regions:
        look = _fills(region)[-1]
        colour, alpha = look["fc"], look.get("alpha", 1.0)
        out.append(axes.add_collection3d(Poly3DCollection([region.points], facecolor=colour, alpha=alpha)))
    for stroke in scene.strokes:
        if stroke.values is None:
            out += axes.plot(*stroke.points.T, **_look(stroke))
            continue
        pieces = np.stack([stroke.points[:-1], stroke.points[1:]], axis=1)
        bars = Line3DCollection(list(pieces), cmap="viridis", lw=4.0, gid="values")
        bars.set_array(0.5 * (stroke.values[:-1] + stroke.values[1:]))
        out.append(axes.add_collection3d(bars))
    for joint in scene.joints:
        fill = ORANGE if joint.driven else SKY if joint.grounded else "white"
        mark = MARKERS.get(joint.kind, "o")
        out += _mark(axes, joint.at, mark, f"joint {joint.name}", mfc=fill, ms=7 if joint.grounded else 5.5)
        if joint.kind not in ("spherical", "fixed", "universal"):
            ends = joint.at + 2.0 * scene.pin(size) * np.array([[-1.0], [1.0]]) * joint.axes[:, 2]
            out += axes.plot(*ends.T, color=INK, lw=1.6, zorder=5)
    for support in scene.supports:
        out += _mark(axes, support.at, "s" if support.clamped else "^", "support", mfc="#b0b0b0", ms=8)
    for move in scene.moves:
        way = ARROW * size * move.force
        out.append(axes.quiver(*move.at, *way, color=FREE, lw=1.5, arrow_length_ratio=0.2, gid="free motion"))
    arrows = _drawn_arrows(scene, [0, 1, 2], size)
    for at, tip in arrows:
        out.append(axes.quiver(*at, *(tip - at), color=ORANGE, lw=1.8, arrow_length_ratio=0.2))
    return out + texts_in_space(axes, scene, arrows)


def _mark(axes: Any, at: ArrayLike, mark: str, gid: str, **look: Any) -> list[Any]:
    return list(axes.plot(*np.reshape(at, (3, 1)), mark, mec=INK, mew=1.0, zorder=6, gid=gid, ls="", **look))
