"""How the figures of all jobs look. Nothing here touches pyplot or a display."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import TYPE_CHECKING, Any, ParamSpec

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Inputs = ParamSpec("Inputs")

INK, GREY, BLUE, SKY, ORANGE = "#222222", "#8c8c8c", "#0b5394", "#9cc3e6", "#d55e00"
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


def styled(draw: Callable[Inputs, Figure]) -> Callable[Inputs, Figure]:
    """Let `draw` run under `STYLE`, whatever the user's own matplotlib settings are."""

    @wraps(draw)
    def wrapper(*args: Inputs.args, **kwargs: Inputs.kwargs) -> Figure:
        from matplotlib import rc_context

        with rc_context(STYLE):
            return draw(*args, **kwargs)

    return wrapper


def figure(width: float, height: float, ratios: tuple[float, ...] = (1.0,)) -> tuple[Figure, list[Axes]]:
    """A figure, inches, with panels side by side of these relative widths."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
    return figure, list(figure.subplots(1, len(ratios), width_ratios=ratios, squeeze=False)[0])


def space_figure(width: float, height: float) -> tuple[Figure, Any]:
    """A figure, inches, with one panel in space."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), dpi=200, layout="constrained")
    return figure, figure.add_subplot(projection="3d")


def entry(name: str) -> str:
    """A name as the entry of a legend, where matplotlib would leave `_name` out."""
    return f" {name}" if name.startswith("_") else name


def note(axes: Axes, text: str, at: Array, shift: ArrayLike, **style: Any) -> None:
    """Write `text` at a point, `shift` points of type away from it."""
    (x, y), (across, up) = at, np.asarray(shift)
    axes.annotate(text, (x, y), (across, up), textcoords="offset points", **style)


def unit(vector: Array) -> Array:
    """A vector of length one in the same direction; zero stays zero."""
    length = float(np.linalg.norm(vector))
    return vector / length if length > 0.0 else vector
