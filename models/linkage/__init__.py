"""Any linkage, planar or spatial: description, motion, reactions, compliance."""

from .derivatives.displacement_sensitivity import DisplacementSensitivity
from .derivatives.position_sensitivity import PositionSensitivity
from .description.joints import KINDS, Kind
from .description.parts import GROUND, LinkageLink, LinkageSpring, Load, Pair
from .files import read_linkage, write_linkage
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
