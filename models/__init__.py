"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .four_bar import Accuracy, FourBar, FourBarMotion, Kinetostatics, Link, Study, accuracy, monte_carlo
from .linkage import (
    Contributors,
    DeadPoint,
    DriveRange,
    FiniteWorstCase,
    Linkage,
    LoadsWarning,
    Mobility,
    Motion,
    PointAccuracy,
    PoseState,
    PositionSensitivity,
    ReachableRegion,
    Reactions,
    Stress,
    WorstCase,
    read_linkage,
    write_linkage,
)
from .propagation import Propagation, propagate
from .sensitivity import SobolIndices, sobol_indices
from .spread import Spread

__all__ = [
    "Accuracy",
    "Contributors",
    "DeadPoint",
    "DriveRange",
    "FiniteWorstCase",
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
    "PositionSensitivity",
    "Propagation",
    "ReachableRegion",
    "Reactions",
    "SobolIndices",
    "Spread",
    "Stress",
    "Study",
    "WorstCase",
    "accuracy",
    "monte_carlo",
    "propagate",
    "read_linkage",
    "sobol_indices",
    "write_linkage",
]
