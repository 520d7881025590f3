"""What uncertain inputs make of a result: inputs that depend on each other, samples, statistics with their errors."""

from .correlation import GaussianCopula
from .failures import Failures
from .histogram import Histogram
from .result import Propagation
from .reweighting import Reweighted
from .run import propagate

__all__ = ["Failures", "GaussianCopula", "Histogram", "Propagation", "Reweighted", "propagate"]
