"""Limit states and their inputs as other programs of structural reliability take them."""

from .openturns import OpenTURNSProblem, to_openturns
from .pystra import PystraProblem, to_pystra

__all__ = ["OpenTURNSProblem", "PystraProblem", "to_openturns", "to_pystra"]
