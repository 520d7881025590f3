"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .four_bar import Accuracy, FourBar, FourBarMotion, Kinetostatics, Link, Study, accuracy, monte_carlo
from .job.histogram import plot_histogram
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
    "SobolIndices",
    "Spread",
    "Stress",
    "Study",
    "accuracy",
    "monte_carlo",
    "plot_histogram",
    "propagate",
    "read_linkage",
    "sobol_indices",
    "write_linkage",
]
