"""Linkages: motion, reactions, compliance, clearance, and the spread of all of it under tolerances."""

from .four_bar import FourBar, FourBarMotion, Kinetostatics, Link

__all__ = ["FourBar", "FourBarMotion", "Kinetostatics", "Link"]
