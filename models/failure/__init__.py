"""Probability of failure, down to one in a billion."""

from .reliability import Reliability, reliability

__all__ = ["Reliability", "reliability"]
