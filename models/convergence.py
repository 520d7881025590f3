"""Convergence of an estimate with the number of samples."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..framework.errors import FrameError
from ..framework.graphics.canvas import few_ticks
from ..framework.graphics.log_ticks import log_ticks
from ..framework.graphics.style import BLUE, GREY, PALE, set_title
from .intervals import checked_probability, quantile_interval
from .moments import Moments

Array = NDArray[np.float64]

# Smallest number of samples of an estimate, and number of estimates along the way.
FEWEST, PLACES = 4, 80
# Number of samples at which the figure begins: estimates from fewer scatter too widely.
BEGIN = 16
# Probability that a normal estimate is within one standard error.
ONE_SIGMA = 0.6826894921370859


def settled(samples: Array, of: str | float) -> tuple[NDArray[np.int64], Array, Array, Array]:
    """Estimates from increasing numbers of samples.

    Parameters
    ----------
    samples
        Finite numbers, (n,).
    of
        ``"mean"``, ``"std"``, or the probability of a quantile.

    Returns
    -------
    tuple
        Numbers of samples, the estimates, and one standard error below and above them, (k,) each; for a quantile the
        bounds with the same confidence, infinite where the samples are too few.

    Raises
    ------
    FrameError
        If `of` is none of these, or there are too few samples.
    """
    if isinstance(of, str) and of not in ("mean", "std"):
        raise FrameError(f"convergence of {of!r}: choose 'mean', 'std' or the probability of a quantile")
    if len(samples) < FEWEST:
        raise FrameError(f"convergence of {len(samples)} samples: take {FEWEST} or more")
    counts = np.unique(np.geomspace(FEWEST, len(samples), PLACES).round().astype(np.int64))
    rows = np.array([_estimate(samples[:count], of) for count in counts]).T
    return counts, rows[0], rows[1], rows[2]


def _estimate(samples: Array, of: str | float) -> tuple[float, float, float]:
    """Estimate from all samples given, and one standard error below and above it."""
    if not isinstance(of, str):
        p = checked_probability(of)
        low, high = quantile_interval(samples, p, ONE_SIGMA, "propagate")
        return float(np.quantile(samples, p)), float(low), float(high)
    found = Moments.of(samples)
    value, error = (found.mean, found.standard_error) if of == "mean" else (found.std, found.std_standard_error)
    return float(value), float(value - error), float(value + error)


def draw_convergence(axes: Any, samples: Array, of: str | float, label: str, unit: str, remark: str = "") -> None:
    """Draw an estimate over the number of samples, with a band of one standard error and a line at its last value.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    samples
        Finite numbers, (n,), in the order in which they were drawn.
    of
        ``"mean"``, ``"std"``, or the probability of a quantile.
    label, unit
        Name and unit of the sampled quantity.
    remark
        Text in a line below the title; no line if empty.
    """
    counts, value, low, high = settled(samples, of)
    name = {"mean": "mean", "std": "standard deviation"}.get(str(of), f"{of} quantile")
    inside = np.isfinite(low) & np.isfinite(high)
    axes.fill_between(counts[inside], low[inside], high[inside], color=PALE, lw=0.0, label="± one standard error")
    axes.plot(counts[inside], low[inside], counts[inside], high[inside], color=BLUE, lw=0.5, alpha=0.6)
    axes.plot(counts, value, color=BLUE, lw=1.5, label=name)
    axes.axhline(value[-1], color=GREY, lw=0.8, ls=(0, (4, 3)), zorder=0.9)
    axes.set_xscale("log")
    shown = inside & (counts >= min(BEGIN, counts[-1]))
    if shown.any():
        axes.set_xlim(counts[shown][0], counts[-1])
        least, greatest = float(low[shown].min()), float(high[shown].max())
        axes.set_ylim(least - 0.05 * (greatest - least), greatest + 0.05 * (greatest - least) or None)
    log_ticks(axes.xaxis)
    axes.set_xlabel("samples")
    axes.set_ylabel(f"{name} of {label}" + (f" [{unit}]" if unit else ""), parse_math=True)
    error = 0.5 * (high[-1] - low[-1])
    digits = int(np.clip(1 - np.floor(np.log10(error)), 0, 12)) if 0.0 < error < np.inf else 6
    end = f"{value[-1]:.{digits}f} ± {error:.{digits}f} {unit}".rstrip().replace("-", "−")
    set_title(axes, "\n".join([f"{end} of {counts[-1]} samples", *([remark] if remark else [])]))
    axes.spines[["top", "right"]].set_visible(False)
    axes.legend(fontsize=7.5, frameon=False)
    few_ticks(axes)
