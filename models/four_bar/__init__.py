"""The four-bar linkage: motion, reactions, compliance, clearance and the spread of it all."""

from __future__ import annotations

from typing import TYPE_CHECKING

from ...framework.lazily import loaded_later

if TYPE_CHECKING:
    from .displacement import Accuracy, accuracy
    from .four_bar import FourBar, FourBarMotion
    from .kinetostatics import Kinetostatics, Link
    from .study import Study, monte_carlo

__all__ = ["Accuracy", "FourBar", "FourBarMotion", "Kinetostatics", "Link", "Study", "accuracy", "monte_carlo"]

# Each module is imported when a name of it is first used: a motion needs neither samples nor what any linkage does.
_LATER = {
    "Accuracy": ".displacement",
    "FourBar": ".four_bar",
    "FourBarMotion": ".four_bar",
    "Kinetostatics": ".kinetostatics",
    "Link": ".kinetostatics",
    "Study": ".study",
    "accuracy": ".displacement",
    "monte_carlo": ".study",
}

__getattr__, __dir__ = loaded_later(__name__, _LATER, modules=["as_linkage"])
