"""Maps over a grid of places, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ....framework.batch import Array
from ....framework.errors import FrameError
from ....framework.graphics.canvas import few_ticks
from ....framework.graphics.log_ticks import log_ticks
from ....framework.graphics.style import INK, new_axes, set_title, styled
from ....framework.graphics.units import moment_unit, scaled
from ..graphics.units import Units

if TYPE_CHECKING:
    from matplotlib.axes import Axes

KINDS = ("stiffness", "condition", "effort")
# Ratio of the largest to the smallest value above which the colours are logarithmic.
WIDE = 10.0
# Factor from the median beyond which colours stay the same.
FAR = 100.0


class MappedPlaces(Protocol):
    """The part of a workspace that a map needs."""

    @property
    def axes(self) -> tuple[int, int]:
        """The two global axes of the grid."""

    @property
    def grid(self) -> tuple[Array, Array]:
        """Coordinates along them."""

    @property
    def place(self) -> Array:
        """Position of the grid along the third axis, and the reference position along the others, (3,)."""

    @property
    def point(self) -> str:
        """Name of the point."""

    @property
    def reached(self) -> NDArray[np.bool_]:
        """Which places are reached, (rows, columns)."""

    @property
    def elsewhere(self) -> NDArray[np.bool_]:
        """Which of the others the point can have in another assembly mode, (rows, columns)."""

    def stiffness(self, direction: ArrayLike | None) -> Array:
        """Stiffness, (rows, columns)."""

    def condition(self, length: float | None) -> Array:
        """Condition number, (rows, columns)."""

    def effort(self, drive: str | None) -> Array:
        """Largest drive force or moment, (rows, columns)."""

    def drives_turn(self, drive: str | None) -> bool:
        """Whether the effort is a moment."""

    def flat(self) -> bool:
        """Whether the linkage moves in the plane of the grid."""


@styled
def plot_map(
    space: MappedPlaces,
    what: str,
    axes: Axes | None,
    direction: ArrayLike | None,
    length: float | None,
    drive: str | None,
    units: Units,
) -> Axes:
    """See `Workspace.plot`."""
    if what not in KINDS:
        raise FrameError(f"plot was given what={what!r}: choose one of {', '.join(KINDS)}")
    if what == "stiffness":
        values, label = space.stiffness(direction), "least stiffness" if direction is None else _along(direction)
        values, unit = _in_units(values, units[1])
        label = f"{label} of {space.point} [{unit}/{units[0]}]"
    elif what == "effort":
        unit = moment_unit(units) if space.drives_turn(drive) else units[1]
        values, unit = _in_units(space.effort(drive), unit)
        name = "torque" if space.drives_turn(drive) else "force"
        label = f"{'greatest drive ' + name if drive is None else f'{name} of drive {drive}'} [{unit}]"
    else:
        values, label = space.condition(length), "condition number κ"
    u, v = space.grid
    found: Any = new_axes(5.4, float(np.clip(4.4 * np.ptp(v) / np.ptp(u), 2.6, 5.6))) if axes is None else axes
    _coloured(found, u, v, values, label)
    names = ["xyz"[k] for k in space.axes]
    found.set(xlabel=f"{names[0]} [{units[0]}]", ylabel=f"{names[1]} [{units[0]}]")
    found.set_aspect("equal", adjustable="box")
    home = space.place[list(space.axes)]
    if u.min() <= home[0] <= u.max() and v.min() <= home[1] <= v.max():
        found.plot(*home[:, None], "+", color="white", ms=9, mew=2.6, gid="halo")
        found.plot(*home[:, None], "+", color=INK, ms=8, mew=1.2, gid="reference")
    few_ticks(found)
    set_title(found, "\n".join(_told(space, values, units)))
    return found  # type: ignore[no-any-return]


def _along(direction: ArrayLike) -> str:
    told = ", ".join(f"{each:.3g}" for each in np.ravel(np.asarray(direction, dtype=float)))
    return f"stiffness along ({told})".replace("-", "−")


def _in_units(values: Array, unit: str) -> tuple[Array, str]:
    """Values with a prefix of the unit such that the median is between 1 and 1000, and that unit."""
    there = np.abs(values[np.isfinite(values)])
    times, prefixed = scaled(float(np.median(there)) if there.size else 0.0, unit)
    return times * values, prefixed


def _told(space: MappedPlaces, values: Array, units: Units) -> list[str]:
    """Lines of the title: where the grid lies, and how many places are blank and why."""
    across = 3 - sum(space.axes)
    lines = [] if space.flat() else [f"{'xyz'[across]} = {space.place[across]:.4g} {units[0]}".replace("-", "−")]
    count, there = space.reached.size, int(np.count_nonzero(space.reached))
    without = there - int(np.count_nonzero(np.isfinite(values) & space.reached))
    elsewhere = int(np.count_nonzero(space.elsewhere))
    blank = [f"{count - there} of {count} places not reachable"] if there < count else []
    blank += [f"{elsewhere} of them in another assembly mode"] if elsewhere else []
    blank += [f"{without} singular or rigid"] if without else []
    return [*lines, *(["blank: " + ", ".join(blank)] if blank else [f"all {count} places reachable"])]


def _coloured(axes: Any, u: Array, v: Array, values: Array, label: str) -> None:
    """Draw cells in colours with a colour bar, and labelled contour lines; legible in grey too."""
    from matplotlib.colors import LogNorm, Normalize

    shown = np.ma.masked_invalid(values)
    if shown.count() == 0:
        raise FrameError(f"no place of the map has a finite {label.partition(' [')[0]}: there is nothing to draw")
    least, middle, most = float(shown.min()), float(np.median(shown.compressed())), float(shown.max())
    # near a singular pose values grow without bound, and all others would have one colour
    low, high = (max(least, middle / FAR), min(most, middle * FAR)) if least >= 0.0 else (least, most)
    norm = LogNorm(low, high) if low > 0.0 and high > WIDE * low else Normalize(low, high)
    cells = axes.pcolormesh(u, v, shown, shading="nearest", cmap="viridis", norm=norm, rasterized=True, gid="map")
    ends = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}
    bar = axes.figure.colorbar(cells, ax=axes, shrink=0.85, extend=ends[least < low, most > high])
    bar.set_label(label, parse_math=False)
    if isinstance(norm, LogNorm):
        log_ticks(bar.ax.yaxis)
    if min(values.shape) > 2 and most > least * (1.0 + 1e-6):
        levels = np.quantile(shown.compressed(), [0.1, 0.3, 0.5, 0.7, 0.9])
        lines = axes.contour(u, v, shown, sorted({float(f"{k:.2g}") for k in levels}), colors="white", linewidths=0.7)
        axes.clabel(lines, fontsize=6.5, fmt="%.3g")
