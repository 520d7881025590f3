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
from .propagation import Propagation, propagate
from .sensitivity import SobolIndices, sobol_indices
from .spread import Spread

__all__ = [
    "Accuracy",
    "DeadPoint",
    "DriveRange",
    "FourBar",
    "FourBarMotion",
    "Kinetostatics",
    "Link",
    "Linkage",
    "LoadsWarning",
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
    "monte_carlo",
    "propagate",
    "read_linkage",
    "reliability",
    "sobol_indices",
    "write_linkage",
]
