"""What uncertain inputs make of a result: inputs that depend on each other, samples, statistics with their errors."""

from .chaos import PolynomialChaos, polynomial_chaos
from .correlation import GaussianCopula
from .failures import Failures
from .histogram import Histogram
from .result import Propagation
from .reweighting import Reweighted
from .run import propagate
from .taylor import TaylorMoments, taylor_moments

__all__ = [
    "Failures",
    "GaussianCopula",
    "Histogram",
    "PolynomialChaos",
    "Propagation",
    "Reweighted",
    "TaylorMoments",
    "polynomial_chaos",
    "propagate",
    "taylor_moments",
]
