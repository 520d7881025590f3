"""The four-bar linkage: motion, reactions, compliance, clearance and the spread of it all."""

from .four_bar import FourBar
from .kinetostatics import Kinetostatics, Link
from .motion import FourBarMotion

__all__ = ["FourBar", "FourBarMotion", "Kinetostatics", "Link"]
