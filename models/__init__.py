"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .distributions import Interval, tolerance
from .four_bar import Accuracy, FourBar, FourBarMotion, Kinetostatics, Link, Study, accuracy, monte_carlo
from .intervals import ConfidenceInterval
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
from .propagation import (
    Failures,
    GaussianCopula,
    Histogram,
    PolynomialChaos,
    Propagation,
    Reweighted,
    TaylorMoments,
    polynomial_chaos,
    propagate,
    taylor_moments,
)
from .sensitivity import SobolIndices, sobol_indices
from .spread import Spread

__all__ = [
    "Accuracy",
    "ConfidenceInterval",
    "DeadPoint",
    "DriveRange",
    "Failures",
    "FourBar",
    "FourBarMotion",
    "GaussianCopula",
    "Histogram",
    "Interval",
    "Kinetostatics",
    "Link",
    "Linkage",
    "LoadsWarning",
    "Mobility",
    "Motion",
    "PointAccuracy",
    "PolynomialChaos",
    "PoseState",
    "Propagation",
    "Reactions",
    "Reweighted",
    "SobolIndices",
    "Spread",
    "Stress",
    "Study",
    "TaylorMoments",
    "accuracy",
    "monte_carlo",
    "polynomial_chaos",
    "propagate",
    "read_linkage",
    "sobol_indices",
    "taylor_moments",
    "tolerance",
    "write_linkage",
]
