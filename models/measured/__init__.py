"""Measured positions: comparison with predicted ones, and calibration of dimensions from them."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...framework.lazily import loaded_later

if TYPE_CHECKING:
    from .calibration import Calibration, calibrate
    from .comparison import Comparison, compare
    from .table import Measured, read_measured

__all__ = ["Calibration", "Comparison", "Measured", "calibrate", "compare", "read_measured"]

# Each module is imported when a name of it is first used: reading a table does not need calibration.
_LATER = {
    "Calibration": ".calibration",
    "Comparison": ".comparison",
    "Measured": ".table",
    "calibrate": ".calibration",
    "compare": ".comparison",
    "read_measured": ".table",
}

__getattr__, __dir__ = loaded_later(__name__, _LATER, modules=["residual_plot", "table"])
