"""A stage of a chain is as far from its dead point as it is alone, however many stages there are."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import Linkage, PoseState


def scissor(stages: int) -> Linkage:
    """Pairs of bars crossed in their middles, one on the other, drawn apart by the foot of the first."""
    rise = {f"{side}{k}": (x, 0.6 * k) for k in range(stages + 1) for side, x in (("L", 0.0), ("R", 0.8))}
    linkage = Linkage(rise | {f"M{k}": (0.4, 0.6 * k + 0.3) for k in range(stages)})
    for k in range(stages):
        linkage.link(f"a{k}", f"L{k}", f"M{k}", f"R{k + 1}")
        linkage.link(f"b{k}", f"R{k}", f"M{k}", f"L{k + 1}")
    linkage.link("foot", "R0")
    linkage.revolute("L0", "ground", "a0")
    linkage.prismatic("R0", "ground", "foot", name="slide", axis=(1, 0), drive=True)
    linkage.revolute("R0", "foot", "b0")
    for k in range(stages):
        linkage.revolute(f"M{k}", f"a{k}", f"b{k}")
        if k:
            linkage.revolute(f"L{k}", f"b{k - 1}", f"a{k}")
            linkage.revolute(f"R{k}", f"a{k - 1}", f"b{k}")
    return linkage


@pytest.mark.parametrize("stages", [8, 16])
def test_a_scissor_of_many_stages_is_as_good_as_one(stages: int) -> None:
    foot = np.array([-0.6, -0.4, 0.0, 0.1, 0.19, 0.19999])
    one, two, many = (scissor(count).move(slide=foot) for count in (1, 2, stages))
    assert one.state.tolist() == [PoseState.REGULAR] * 5 + [PoseState.NEAR_DEAD_POINT]
    np.testing.assert_array_equal(many.state, one.state)
    np.testing.assert_array_equal(two.state, one.state)
    np.testing.assert_allclose(many.conditioning, two.conditioning, rtol=1e-6)
