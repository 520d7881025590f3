"""The four-bar linkage: motion, reactions, compliance, clearance and the spread of it all."""

from .accuracy import Accuracy, accuracy
from .four_bar import FourBar, FourBarMotion
from .kinetostatics import Kinetostatics, Link
from .study import Study, monte_carlo

__all__ = ["Accuracy", "FourBar", "FourBarMotion", "Kinetostatics", "Link", "Study", "accuracy", "monte_carlo"]
