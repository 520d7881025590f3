"""Measured positions: compared with a prediction, and used to find the dimensions behind it."""

from .calibration import Calibration, calibrate
from .comparison import Comparison, compare
from .table import Measured, read_measured

__all__ = ["Calibration", "Comparison", "Measured", "calibrate", "compare", "read_measured"]
