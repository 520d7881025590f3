"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .four_bar import Accuracy, FourBar, FourBarMotion, Kinetostatics, Link, Study, accuracy, monte_carlo
from .propagation import Propagation, propagate
from .sensitivity import SobolIndices, sobol_indices
from .spread import Spread

__all__ = [
    "Accuracy",
    "FourBar",
    "FourBarMotion",
    "Kinetostatics",
    "Link",
    "Propagation",
    "SobolIndices",
    "Spread",
    "Study",
    "accuracy",
    "monte_carlo",
    "propagate",
    "sobol_indices",
]
