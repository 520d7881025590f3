"""Fits of pins in holes by ISO 286, and the cheapest tolerances that meet a required accuracy."""

from .allocation import Allocation, allocate, relative_cost
from .iso286 import Fit, LimitsOfSize, fit, limits_of_size, tolerance_grade

__all__ = [
    "Allocation",
    "Fit",
    "LimitsOfSize",
    "allocate",
    "fit",
    "limits_of_size",
    "relative_cost",
    "tolerance_grade",
]
