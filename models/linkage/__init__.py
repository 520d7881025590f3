"""Any linkage, planar or spatial: description, motion, reactions, compliance."""

from .dead_points import DeadPoint, DriveRange
from .joints import KINDS, Kind
from .linkage import Linkage
from .mobility import Mobility
from .motion import Motion
from .parts import GROUND, Link, Load, Pair, Spring

__all__ = [
    "GROUND",
    "KINDS",
    "DeadPoint",
    "DriveRange",
    "Kind",
    "Link",
    "Linkage",
    "Load",
    "Mobility",
    "Motion",
    "Pair",
    "Spring",
]
