"""Frames for mechanisms: description, assembly in joint-relative coordinates, broadcasting solution, export."""

from __future__ import annotations

from typing import TYPE_CHECKING

from .errors import FrameError, MechanismWarning, PathWarning
from .lazily import loaded_later

if TYPE_CHECKING:
    from .clearances.contact import Contact
    from .error_bounds.sensitivity import Sensitivity
    from .frame import Frame
    from .joint_protocol import JointElement
    from .large.path import EquilibriumPath
    from .large.solution import LargeSolution
    from .matrices import FrameMatrices
    from .paraview.vtu import read_names
    from .protocol import LineElement, PointElement
    from .results.base import AllResults
    from .results.buckling import Buckling
    from .results.modes import Modes
    from .results.singular import FreeMotion
    from .shape_rules import cubic_shapes, straight_shapes
    from .solution import Solution
    from .states import ClearanceState, SolutionState
    from .view import movie, picture

__all__ = [
    "AllResults",
    "Buckling",
    "ClearanceState",
    "Contact",
    "EquilibriumPath",
    "Frame",
    "FrameError",
    "FrameMatrices",
    "FreeMotion",
    "JointElement",
    "LargeSolution",
    "LineElement",
    "MechanismWarning",
    "Modes",
    "PathWarning",
    "PointElement",
    "Sensitivity",
    "Solution",
    "SolutionState",
    "cubic_shapes",
    "movie",
    "picture",
    "read_names",
    "straight_shapes",
]

# Elements need the protocol alone: a frame, and the solvers with it, are imported where they are first asked for. So
# are the modules named below, which a frame needs when it is solved.
_LATER = {
    "AllResults": ".results.base",
    "Buckling": ".results.buckling",
    "ClearanceState": ".states",
    "Contact": ".clearances.contact",
    "EquilibriumPath": ".large.path",
    "Frame": ".frame",
    "FrameMatrices": ".matrices",
    "FreeMotion": ".results.singular",
    "JointElement": ".joint_protocol",
    "LargeSolution": ".large.solution",
    "LineElement": ".protocol",
    "Modes": ".results.modes",
    "PointElement": ".protocol",
    "Sensitivity": ".error_bounds.sensitivity",
    "Solution": ".solution",
    "SolutionState": ".states",
    "cubic_shapes": ".shape_rules",
    "movie": ".view",
    "picture": ".view",
    "read_names": ".paraview.vtu",
    "straight_shapes": ".shape_rules",
}

__getattr__, __dir__ = loaded_later(__name__, _LATER, modules=["basis", "matrices", "solution"])
