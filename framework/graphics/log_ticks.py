"""Numbers along logarithmic axes, in plain text."""

from __future__ import annotations

from typing import Any

import numpy as np

RAISED = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# Up to this ratio of the ends of an axis, numbers between the powers of ten are written as well.
FEW_POWERS = 100.0
BETWEEN = (2, 5)


def log_ticks(axis: Any) -> None:
    """Write the numbers along a logarithmic axis of matplotlib, whose limits are set, in plain text.

    Figures are drawn with mathematical text turned off, as names may hold dollars; matplotlib's own numbers along
    logarithmic axes are such text.

    Parameters
    ----------
    axis
        The axis, ``axes.xaxis`` or ``axes.yaxis``.
    """
    from matplotlib.ticker import FuncFormatter, NullFormatter

    low, high = sorted(axis.get_view_interval())
    axis.set_major_formatter(FuncFormatter(_major))
    axis.set_minor_formatter(FuncFormatter(_minor) if high <= FEW_POWERS * low else NullFormatter())


def _major(value: float, _place: object = None) -> str:
    power = round(np.log10(value)) if value > 0.0 else 0
    return f"{value:.4g}" if -3 <= power <= 4 else f"10{str(power).translate(RAISED)}"


def _minor(value: float, _place: object = None) -> str:
    power = np.floor(np.log10(value) + 1e-9) if value > 0.0 else 0.0
    leading = round(value / 10.0**power)
    if leading not in BETWEEN:
        return ""
    return f"{value:.4g}" if -3 <= power <= 4 else f"{leading}·10{str(int(power)).translate(RAISED)}"
