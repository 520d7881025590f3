"""Figures of a solution with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from ..results.base import Results
from .canvas import axes_for, draw, finish
from .deformed import deformed_frame
from .style import styled

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@styled
def plot_solution(
    solution: Results,
    axes: Axes | None,
    what: str,
    entry: int | tuple[int, ...] | None,
    scale: float | None,
    names: bool,
    units: tuple[str, str],
) -> Axes:
    """See `Solution.plot`."""
    shown = deformed_frame(solution, what, entry, scale, names, units)
    found: Any = axes_for(shown.scene, axes)
    drawn = draw(shown.scene, found)
    finish(shown.scene, found, units[0], shown.title, legend=False)
    if shown.values is not None:
        label, greatest = shown.values
        bars = [artist for artist in drawn if artist.get_gid() == "values"]
        for bar in bars:
            bar.set_clim(0.0, greatest)
        found.figure.colorbar(bars[0], ax=found, label=label, shrink=0.7)
    return found  # type: ignore[no-any-return]
