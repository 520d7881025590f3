"""Any linkage, planar or spatial: description, motion, reactions, compliance."""

from .accuracy import PointAccuracy, Stress
from .dead_points import DeadPoint, DriveRange
from .files import read_linkage, write_linkage
from .joints import KINDS, Kind
from .linkage import Linkage
from .mobility import Mobility
from .motion import Motion
from .parts import GROUND, Link, Load, Pair, Spring
from .reactions import Reactions

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
    "PointAccuracy",
    "Reactions",
    "Spring",
    "Stress",
    "read_linkage",
    "write_linkage",
]
