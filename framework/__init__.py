"""Frames for mechanisms: description, assembly in joint-relative coordinates, broadcasting solution, export."""

from __future__ import annotations

from .errors import FrameError, MechanismWarning
from .frame import Frame
from .large.path import EquilibriumPath
from .large.solution import LargeSolution
from .solution import Solution

__all__ = ["EquilibriumPath", "Frame", "FrameError", "LargeSolution", "MechanismWarning", "Solution"]
