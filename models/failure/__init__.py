"""Probability of failure, down to one in a billion."""

from .adapters import OpenTURNSProblem, PystraProblem, to_openturns, to_pystra
from .reliability import Reliability, reliability

__all__ = ["OpenTURNSProblem", "PystraProblem", "Reliability", "reliability", "to_openturns", "to_pystra"]
