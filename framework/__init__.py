"""Frames for mechanisms: description, assembly in joint-relative coordinates, broadcasting solution, export."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING

from .errors import FrameError, MechanismWarning
from .frame import Frame

if TYPE_CHECKING:
    from .large.path import EquilibriumPath
    from .large.solution import LargeSolution
    from .solution import Solution

__all__ = ["EquilibriumPath", "Frame", "FrameError", "LargeSolution", "MechanismWarning", "Solution"]

# What a description does not need is imported where it is first asked for: the solvers, and scikit-fem with them.
_LATER = {"EquilibriumPath": ".large.path", "LargeSolution": ".large.solution", "Solution": ".solution"}


def __getattr__(name: str) -> object:
    if name not in _LATER:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_LATER[name], __name__), name)
