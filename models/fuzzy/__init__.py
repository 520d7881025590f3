"""Fuzzy inputs, and what they make of a result: cuts at each level of membership."""

from .cuts import FuzzyResult, propagate_fuzzy
from .number import FuzzyNumber

__all__ = ["FuzzyNumber", "FuzzyResult", "propagate_fuzzy"]
