"""How all figures look. Nothing here touches pyplot or a display."""

from __future__ import annotations

import re
from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Inputs = ParamSpec("Inputs")
Drawn = TypeVar("Drawn")

INK, GREY, BLUE, SKY, ORANGE = "#222222", "#8c8c8c", "#0b5394", "#9cc3e6", "#d55e00"
# One after the other as dark as light, so that neighbours differ in grey as well.
COLOURS = (BLUE, "#e69f00", "#009e73", "#7b3294", "#56b4e9", "#8b2e16", "#7d9b2a", "#d6336c")
# Fill of a region that samples sweep.
PALE = "#e3ecf5"
STYLE: Any = {
    "font.size": 9.0,
    "text.parse_math": False,  # a name may hold dollars
    "axes.edgecolor": INK,
    "axes.linewidth": 0.7,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.5,
    "legend.frameon": False,
    "xtick.direction": "out",
    "ytick.direction": "out",
}


def styled(draw: Callable[Inputs, Drawn]) -> Callable[Inputs, Drawn]:
    """Let `draw` run under `STYLE`, whatever the user's own matplotlib settings are."""

    @wraps(draw)
    def wrapper(*args: Inputs.args, **kwargs: Inputs.kwargs) -> Drawn:
        from matplotlib import rc_context

        with rc_context(STYLE):
            return draw(*args, **kwargs)

    return wrapper


def figure(width: float, height: float, ratios: tuple[float, ...] = (1.0,)) -> tuple[Figure, list[Axes]]:
    """A figure, inches, with panels side by side of these relative widths."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
    return figure, list(figure.subplots(1, len(ratios), width_ratios=ratios, squeeze=False)[0])


def fitting_figure(width: float, extent: tuple[float, float]) -> tuple[Figure, Axes]:
    """A figure of this width, inches, with one panel, whose height fits a drawing of this extent (across, up)."""
    drawn_on, (axes,) = figure(width, fitting_height(width, extent))
    return drawn_on, axes


def fitting_height(width: float, extent: tuple[float, float]) -> float:
    """Height of a figure, inches, for a drawing of this extent (across, up): 0.4 to 1.1 times the width."""
    across, up = extent
    return float(np.clip(width * up / across, 0.4 * width, 1.1 * width))


def new_axes(width: float, height: float) -> Any:
    """Axes of a new figure, inches, that pyplot shows."""
    import matplotlib.pyplot as plt

    with plt.rc_context(STYLE):
        return plt.figure(figsize=(width, height), layout="constrained").add_subplot()


def space_figure(width: float, height: float) -> tuple[Figure, Any]:
    """A figure, inches, with one panel in space."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
    return figure, figure.add_subplot(projection="3d")


def entry(name: str) -> str:
    """A name as the entry of a legend, where matplotlib would leave `_name` out."""
    return f" {name}" if name.startswith("_") else name


def set_title(axes: Any, text: str, share: float = 1.0) -> None:
    """Write a title from the left of axes, in as many lines as this share of the room to their right asks for."""
    from matplotlib.font_manager import FontProperties
    from matplotlib.textpath import text_to_path

    font, room = FontProperties(size=_title_size()), _title_room(axes, share)

    def fits(line: str) -> bool:
        return bool(text_to_path.get_text_width_height_descent(line.replace("\u00a0", " "), font, False)[0] <= room)

    # A number stays on the line of its unit or sign: a space that cannot be broken stands between them meanwhile.
    bound = re.sub(r"(?<=\d) (?=[^\W\d_]{1,3}\b)|(?<=[×=]) ", "\u00a0", text)
    lines: list[str] = []
    for part in bound.split("\n"):
        lines.append("")
        for word in part.split(" "):
            longer = f"{lines[-1]} {word}".strip(" ")
            if lines[-1] and not fits(longer):
                lines.append(word)
            else:
                lines[-1] = longer
    axes.set_title("\n".join(lines).replace("\u00a0", " "), loc="left", fontsize=_title_size())


def letters_across(axes: Any) -> int:
    """About how many letters of a title find room to the right of the left side of axes."""
    return max(16, int(_title_room(axes, 1.0) / (0.5 * _title_size())))


def _title_room(axes: Any, share: float) -> float:
    """How wide a title may be, points: axes to scale are narrower than their place, and stand in the middle of it."""
    axes.apply_aspect()
    right = axes.get_position(original=True).x1 - axes.get_position().x0
    return float(72.0 * share * right * axes.figure.bbox.width / axes.figure.dpi)


def _title_size() -> float:
    """Size of titles, points."""
    from matplotlib import rcParams

    size = rcParams["axes.titlesize"]
    return float(rcParams["font.size"] if isinstance(size, str) else size)


def note(axes: Axes, text: str, at: Array, shift: ArrayLike, **style: Any) -> None:
    """Write `text` at a point, `shift` points of type away from it."""
    (x, y), (across, up) = at, np.asarray(shift)
    axes.annotate(text, (x, y), (across, up), textcoords="offset points", **style)


def unit(vector: Array) -> Array:
    """A vector of length one in the same direction; zero stays zero."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector
