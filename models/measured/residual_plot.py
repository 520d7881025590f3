"""Residuals of a measurement by pose, with matplotlib."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.canvas import few_ticks
from ...framework.graphics.curves import mark_turns
from ...framework.graphics.style import COLOURS, INK
from ...framework.graphics.units import scaled

Array = NDArray[np.float64]

MARKS = ("o", "s", "^")
# Distance between the components of one pose, as a share of the smallest distance between two poses.
APART = 0.16


def draw_residuals(
    axes: Any,
    over: tuple[str, Array],
    residual: Array,
    uncertainty: Array,
    outside: NDArray[np.bool_],
    level: float,
    length: str,
) -> None:
    """Draw the components of the residuals with their bands as error bars.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    over
        Label and values (poses,) of the horizontal axis; all values differ.
    residual, uncertainty
        Measured minus predicted position and its standard deviation, (poses, 3), lengths; NaN where nothing was
        compared.
    outside
        Whether to mark each pose, (poses,).
    level
        Probability of the bands.
    length
        Unit of length.
    """
    from scipy.special import ndtri

    reach = float(ndtri(0.5 + 0.5 * level)) * uncertainty
    times, unit = scaled(float(np.nanmax(np.abs(residual) + reach)), length)
    there = [k for k in range(3) if np.isfinite(residual[:, k]).any()]
    label, pose = over
    apart = APART * float(np.abs(np.diff(pose)).min(initial=np.inf)) if len(pose) > 1 else APART
    axes.axhline(0.0, color=INK, lw=0.6, zorder=0.5)
    for place, k in enumerate(there):
        axes.errorbar(
            pose + apart * (place - 0.5 * (len(there) - 1)), times * residual[:, k], times * reach[:, k], fmt=MARKS[k],
            color=COLOURS[k], ms=3.5, lw=0.9, capsize=1.8, label="xyz"[k],
        )  # fmt: skip
    worst = 1.08 * times * float(np.nanmax(np.abs(residual) + reach))
    axes.set_ylim(top=1.3 * worst)  # room for the legend
    if outside.any():
        axes.plot(pose[outside], np.full(int(outside.sum()), worst), "v", color=COLOURS[5], ms=4.5, label="outside")
    axes.set(xlabel=label, ylabel=f"measured − predicted [{unit}]")
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=7.5, frameon=False, ncols=4, loc="upper left", columnspacing=1.0)
    few_ticks(axes)
    if label == "pose":
        axes.xaxis.get_major_locator().set_params(integer=True)
    if label.endswith("[°]"):
        mark_turns(axes, pose)
