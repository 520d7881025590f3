"""Any linkage, planar or spatial: description, motion, reactions, compliance."""

from .joints import KINDS, Kind
from .linkage import Linkage
from .parts import GROUND, Link, Load, Pair, Spring

__all__ = ["GROUND", "KINDS", "Kind", "Link", "Linkage", "Load", "Pair", "Spring"]
