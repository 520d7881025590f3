"""Probability of failure over the poses of a motion, with matplotlib."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from ...framework.graphics.curves import mark_turns
from ...framework.graphics.log_ticks import log_ticks
from ...framework.graphics.style import BLUE, SKY, new_axes, styled
from ..intervals import ConfidenceInterval

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]


@styled
def plot_probability(
    along: Array, probability: Array, band: ConfidenceInterval | None, label: str, axes: Axes | None
) -> Axes:
    """Draw probabilities (poses,) over `along` (poses,) with the confidence band, as for `Reliability.plot`."""
    found: Any = new_axes(4.8, 3.2) if axes is None else axes
    order = np.argsort(along, kind="stable")
    # A probability of zero cannot be shown on a logarithmic axis: it leaves a gap.
    shown = np.where(probability > 0.0, probability, np.nan)[order]
    if band is not None:
        found.fill_between(
            along[order],
            np.where(band.low > 0.0, band.low, np.nan)[order],
            band.high[order],
            color=SKY,
            alpha=0.4,
            lw=0,
        )
    found.plot(along[order], shown, color=BLUE, marker="o", ms=3, lw=1.2)
    found.set(yscale="log", xlabel=label, ylabel="probability of failure")
    log_ticks(found.yaxis)
    found.spines[["top", "right"]].set_visible(False)
    if label.endswith("[°]"):
        mark_turns(found, along)
    return found  # type: ignore[no-any-return]
