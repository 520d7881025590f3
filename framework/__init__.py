"""Frames for mechanisms: description, assembly in joint-relative coordinates, broadcasting solution, export."""

from __future__ import annotations

from .errors import FrameError, MechanismWarning
from .frame import Frame
from .solution import Solution

__all__ = ["Frame", "FrameError", "MechanismWarning", "Solution"]
