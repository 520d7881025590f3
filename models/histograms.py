"""Histograms of samples with a normal fit and a test of it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from ..framework.errors import FrameError
from ..framework.graphics.canvas import few_ticks
from ..framework.graphics.style import BLUE, INK, SKY, letters_across, new_axes, styled
from .moments import Moments
from .normality import FEWEST, LIMIT, anderson_darling
from .sampling import Normal

if TYPE_CHECKING:
    from matplotlib.axes import Axes

Array = NDArray[np.float64]

# Largest number of sampled values drawn as ticks.
MOST_TICKS = 200
# Samples that differ by less than this share of their size count as equal.
SAME = 1e-9


@styled
def plot_histogram(samples: ArrayLike, ax: Axes | None = None, *, label: str = "value", unit: str = "") -> Axes:
    """Draw a histogram of samples with the normal density of the same mean and standard deviation.

    The title gives mean and standard deviation with their standard errors, and the Anderson-Darling statistic. If the
    statistic exceeds the critical value at a significance level of 1 %, the density is dashed and labelled as not
    fitting.

    Parameters
    ----------
    samples
        Samples, (n,); values that are not finite are ignored.
    ax
        Axes of matplotlib to draw on; new ones if None.
    label
        Name of the sampled quantity, on the horizontal axis.
    unit
        Unit of the sampled quantity.

    Returns
    -------
    matplotlib.axes.Axes
        The axes.

    Raises
    ------
    FrameError
        If the samples do not have shape (n,), or fewer than two are finite.

    Examples
    --------
    The positions of a journal that lies on one side or the other are not normally distributed.

    >>> import matplotlib; matplotlib.use("Agg")
    >>> import numpy as np
    >>> from linkframe.models import plot_histogram
    >>> sides = np.sign(np.random.default_rng(0).normal(size=100)) + 0.1 * np.random.default_rng(1).normal(size=100)
    >>> print(plot_histogram(sides, label="$u_x$", unit="mm").get_title(loc="left").splitlines()[-1])
    not normal at 1 % (A² = 14 > 1.035)
    """
    values = np.asarray(samples, dtype=float)
    if values.ndim != 1 or np.count_nonzero(np.isfinite(values)) < 2:
        raise FrameError(f"samples of {label} have shape {values.shape}: give one row of two finite numbers or more")
    axes: Any = new_axes(4.4, 3.4) if ax is None else ax
    draw_histogram(axes, values[np.isfinite(values)], label, unit)
    return axes  # type: ignore[no-any-return]


def draw_histogram(axes: Axes, values: Array, label: str, unit: str, where: str = "") -> None:
    """Draw a histogram on given axes, as `plot_histogram` does.

    Parameters
    ----------
    axes
        Axes of matplotlib.
    values
        Finite numbers, (n,).
    label, unit
        Name of the quantity, which may contain mathematical text, and its unit.
    where
        Text at the beginning of the title, such as the pose.
    """
    text = f"{label} [{unit}]" if unit else label
    axes.set_xlabel(text, parse_math=True)
    first = f"{where}, " if where else ""
    if np.ptp(values) <= SAME * np.abs(values).max():
        axes.axvline(float(values[0]), color=BLUE, lw=1.6)
        axes.set_yticks([])
        axes.set_title(f"{first}all samples the same: {values[0]:.3g} {unit}".replace("-", "−"), loc="left")
        few_ticks(axes)
        return
    moments = Moments.of(values)
    mean, std = float(moments.mean), float(moments.std)
    fits, verdict = _judged(values)
    axes.hist(values, bins=_bins(values), density=True, color=SKY, ec="white", lw=0.8)
    grid = np.linspace(min(values.min(), mean - 3.5 * std), max(values.max(), mean + 3.5 * std), 400)
    label = "normal fit" if fits else "normal fit, does not hold"
    axes.plot(grid, Normal(mean, std).pdf(grid), color=BLUE, lw=1.6, ls="-" if fits else (0, (4, 2)), label=label)
    ticks = values[:MOST_TICKS]
    axes.plot(ticks, 0.0 * ticks, "|", color=INK, ms=7, mew=0.5, alpha=0.6, clip_on=False, zorder=5)
    axes.set_ylabel(f"density [1/{unit}]" if unit else "density")
    lines = [*_numbers(moments, first, unit, letters_across(axes)), *verdict]
    axes.set_title("\n".join(lines).replace("-", "−"), loc="left")
    axes.spines[["top", "right"]].set_visible(False)
    few_ticks(axes)


def _bins(values: Array) -> int:
    """Number of bars: the automatic choice of NumPy, but from 5 to 60."""
    return int(np.clip(len(np.histogram_bin_edges(values, "auto")) - 1, 5, 60))


def _judged(values: Array) -> tuple[bool, list[str]]:
    """Whether the samples can be normal, and a line of text about it; no line for few samples."""
    if len(values) < FEWEST:
        return True, []
    statistic = anderson_darling(values)
    if statistic > LIMIT:
        return False, [f"not normal at 1 % (A² = {statistic:.3g} > {LIMIT:g})"]
    return True, [f"normal is not refuted (A² = {statistic:.2g})"]


def _numbers(moments: Moments, first: str, unit: str, most: int) -> list[str]:
    """Lines of at most `most` letters with mean and standard deviation to the digits that their errors allow."""
    error, deviation = float(moments.standard_error), float(moments.std_standard_error)
    least = min((each for each in (error, deviation) if each > 0.0), default=1.0)
    digits = int(np.clip(1 - math.floor(math.log10(least)), 3, 12))
    mean = f"μ = {float(moments.mean):.{digits}f} ± {error:.{digits}f} {unit}"
    spread = f"σ = {float(moments.std):.{digits}f} ± {deviation:.{digits}f} {unit}"
    both = f"{mean},  {spread}"
    return [
        f"{first}with standard errors:" if first else "with standard errors:",
        *([both] if len(both) <= most else [mean, spread]),
    ]
