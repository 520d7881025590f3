"""Propagation of uncertain inputs through a function: correlated inputs, samples, and statistics with their errors."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...framework.lazily import loaded_later

if TYPE_CHECKING:
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

# Each module is imported when a name of it is first used: sampling needs neither chaos expansions nor correlations.
_LATER = {
    "Failures": ".failures",
    "GaussianCopula": ".correlation",
    "Histogram": ".histogram",
    "PolynomialChaos": ".chaos",
    "Propagation": ".result",
    "Reweighted": ".reweighting",
    "TaylorMoments": ".taylor",
    "polynomial_chaos": ".chaos",
    "propagate": ".run",
    "taylor_moments": ".taylor",
}

__getattr__, __dir__ = loaded_later(
    __name__, _LATER, modules=["checkpoint", "ordered", "packed", "processes", "workers"]
)
