"""Fuzzy numbers as inputs, and the resulting fuzzy numbers by their cuts at levels of membership."""

from .cuts import FuzzyResult, propagate_fuzzy
from .number import FuzzyNumber

__all__ = ["FuzzyNumber", "FuzzyResult", "propagate_fuzzy"]
