"""Free motions at dead points, where lengths and angles are unknown together."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage
from linkframe.models.linkage.poses.singular import conditioning


@pytest.mark.parametrize("height", [0.3, 1.2, 1.6])
def test_a_slide_at_its_dead_point_goes_by_the_height_times_the_turn(height: float) -> None:
    """Two bars of 1 m from a fixed pivot to a block that slides along a line at a height above it, the angle between
    them driven: where their ends are as far apart as the line is high, they turn as one body about the foot of the
    height, ``ds = h dtheta``."""
    far = height + 0.2
    along = np.sqrt(far**2 - height**2)
    across = np.sqrt(1.0 - far**2 / 4.0)
    end = np.array([along, height])
    middle = end / 2.0 + across * np.array([-height, along]) / far
    linkage = Linkage(A=(0.0, 0.0), B=middle, C=end)
    linkage.link("AB", "A", "B")
    linkage.link("BC", "B", "C")
    linkage.link("block", "C")
    linkage.revolute("A", "ground", "AB")
    linkage.revolute("B", "AB", "BC", drive=True)
    linkage.revolute("C", "BC", "block")
    linkage.prismatic("C", "ground", "block", axis=(1.0, 0.0), name="slide")
    # the angle between the bars, from the law of cosines
    turn = np.arccos(far**2 / 2.0 - 1.0) - np.arccos(height**2 / 2.0 - 1.0)
    motion = linkage.move(B=turn)
    assert motion.status.item().startswith("singular")
    ratio, free = conditioning(motion)
    assert float(ratio) < 1e-7
    mechanism = motion.mechanism
    speeds = {mechanism.columns[k][0]: free[j, 0] for j, k in enumerate(mechanism.unknown)}
    assert abs(speeds["slide"]) * mechanism.size == pytest.approx(height * abs(speeds["A"]), rel=1e-6)
