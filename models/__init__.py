"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .failure import Reliability, reliability
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
    "Calibration",
    "Comparison",
    "DeadPoint",
    "DriveRange",
    "FourBar",
    "FourBarMotion",
    "Kinetostatics",
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
    "calibrate",
    "compare",
    "monte_carlo",
    "propagate",
    "read_linkage",
    "read_measured",
    "reliability",
    "sobol_indices",
    "write_linkage",
]
