"""Conversion of limit states and their inputs for other programs of structural reliability."""

from .openturns import OpenTURNSProblem, to_openturns
from .pystra import PystraProblem, to_pystra

__all__ = ["OpenTURNSProblem", "PystraProblem", "to_openturns", "to_pystra"]
