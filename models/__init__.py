"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .failure import Reliability, reliability
from .fits import Allocation, Fit, LimitsOfSize, allocate, fit, limits_of_size, tolerance_grade
from .four_bar import Accuracy, FourBar, FourBarMotion, Kinetostatics, Link, Study, accuracy, monte_carlo
from .linkage import (
    DeadPoint,
    DriveRange,
    Linkage,
    LoadsWarning,
    Mobility,
    Motion,
    PointAccuracy,
    PoseState,
    Reactions,
    Stress,
    read_linkage,
    write_linkage,
)
from .measured import Calibration, Comparison, Measured, calibrate, compare, read_measured
from .propagation import Propagation, propagate
from .sensitivity import SobolIndices, sobol_indices
from .spread import Spread

__all__ = [
    "Accuracy",
    "Allocation",
    "Calibration",
    "Comparison",
    "DeadPoint",
    "DriveRange",
    "Fit",
    "FourBar",
    "FourBarMotion",
    "Kinetostatics",
    "LimitsOfSize",
    "Link",
    "Linkage",
    "LoadsWarning",
    "Measured",
    "Mobility",
    "Motion",
    "PointAccuracy",
    "PoseState",
    "Propagation",
    "Reactions",
    "Reliability",
    "SobolIndices",
    "Spread",
    "Stress",
    "Study",
    "accuracy",
    "allocate",
    "calibrate",
    "compare",
    "fit",
    "limits_of_size",
    "monte_carlo",
    "propagate",
    "read_linkage",
    "read_measured",
    "reliability",
    "sobol_indices",
    "tolerance_grade",
    "write_linkage",
]
