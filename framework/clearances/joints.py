"""The joints of a frame that have clearance, and the force below which none is in contact."""

from __future__ import annotations

import numpy as np

from ..description import Description

# A force below this share of the largest load or joint force is rounding.
UNLOADED = 1e-12


def joints_with_clearance(frame: Description) -> list[str]:
    """Names of the joints with clearance."""
    # a single number is compared as a Python float, which takes a quarter of the time
    return [
        name
        for name, joint in frame.joints.items()
        if (gap.item() if (gap := joint.element.clearance).size == 1 else np.count_nonzero(gap))
    ]
