"""Any linkage, planar or spatial: description, motion, reactions, compliance."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...framework.lazily import loaded_later

if TYPE_CHECKING:
    from .derivatives.displacement_sensitivity import DisplacementSensitivity
    from .derivatives.position_sensitivity import PositionSensitivity
    from .description.joints import KINDS, Kind
    from .description.parts import GROUND, LinkageLink, LinkageSpring, Load, Pair
    from .files.read_linkage import read_linkage
    from .files.write_linkage import write_linkage
    from .linkage import Linkage
    from .loaded_motion import LoadsWarning
    from .motion import Motion
    from .poses.dead_points import DeadPoint, DriveRange
    from .poses.mobility import Mobility
    from .poses.states import PoseState
    from .robot_files.left_out import ConversionWarning
    from .statics.accuracy import PointAccuracy, Stress
    from .statics.reactions import Reactions
    from .study.study import AccuracyStudy
    from .workspace.workspace import Workspace
    from .worst_case.allocation import FitAllocation
    from .worst_case.contributors import Contributors
    from .worst_case.finite import FiniteWorstCase
    from .worst_case.fuzzy import FuzzyReach
    from .worst_case.region import ReachableRegion
    from .worst_case.worst_case import WorstCase

__all__ = [
    "GROUND",
    "KINDS",
    "AccuracyStudy",
    "Contributors",
    "ConversionWarning",
    "DeadPoint",
    "DisplacementSensitivity",
    "DriveRange",
    "FiniteWorstCase",
    "FitAllocation",
    "FuzzyReach",
    "Kind",
    "Linkage",
    "LinkageLink",
    "LinkageSpring",
    "Load",
    "LoadsWarning",
    "Mobility",
    "Motion",
    "Pair",
    "PointAccuracy",
    "PoseState",
    "PositionSensitivity",
    "ReachableRegion",
    "Reactions",
    "Stress",
    "Workspace",
    "WorstCase",
    "read_linkage",
    "write_linkage",
]

# Each name is loaded when it is first used: a motion needs neither tolerances nor files.
_LATER = {
    "AccuracyStudy": ".study.study",
    "Contributors": ".worst_case.contributors",
    "ConversionWarning": ".robot_files.left_out",
    "DeadPoint": ".poses.dead_points",
    "DisplacementSensitivity": ".derivatives.displacement_sensitivity",
    "DriveRange": ".poses.dead_points",
    "FiniteWorstCase": ".worst_case.finite",
    "FitAllocation": ".worst_case.allocation",
    "FuzzyReach": ".worst_case.fuzzy",
    "GROUND": ".description.parts",
    "KINDS": ".description.joints",
    "Kind": ".description.joints",
    "Linkage": ".linkage",
    "LinkageLink": ".description.parts",
    "LinkageSpring": ".description.parts",
    "Load": ".description.parts",
    "LoadsWarning": ".loaded_motion",
    "Mobility": ".poses.mobility",
    "Motion": ".motion",
    "Pair": ".description.parts",
    "PointAccuracy": ".statics.accuracy",
    "PoseState": ".poses.states",
    "PositionSensitivity": ".derivatives.position_sensitivity",
    "ReachableRegion": ".worst_case.region",
    "Reactions": ".statics.reactions",
    "Stress": ".statics.accuracy",
    "Workspace": ".workspace.workspace",
    "WorstCase": ".worst_case.worst_case",
    "read_linkage": ".files.read_linkage",
    "write_linkage": ".files.write_linkage",
}

__getattr__, __dir__ = loaded_later(__name__, _LATER)
