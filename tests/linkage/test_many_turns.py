"""Far values of a drive that turns: the same places after whole turns, without going all the way."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.framework.cache import COMPILED
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from reference.linkages import bennett, four_bar, rssr

LINKAGES = {
    "crank-rocker": (four_bar(2, 7, 9, 6, 0.5), 1, (1, -1, 0, 0)),
    "parallelogram": (four_bar(0.1, 0.2, 0.1, 0.2, 0.7), 1, (1, -1, 1, 1)),
    # Through its change point a linkage whose bars come to lie in line closes after the second turn only.
    "Grashof's equality": (four_bar(1, 3, 2, 4, 0.7), 2, (1, -1, 0, 0)),
    "Bennett": (bennett(np.pi / 6, np.pi / 3, 1.2), 1, (1, -1, -1, 1)),
    "rod with a universal joint": (rssr(0.1, 0.4, 0.25, (0.15, 0.1, 0.3), 0.3, True), 1, None),
}


def coordinates(linkage: Linkage, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    motion = linkage.move({next(iter(linkage.drives)): theta})
    assert np.all(motion.status == "regular")
    pins = [name for name, joint in linkage.joints.items() if joint.kind.name == "revolute"]
    points = np.stack([motion.position(point) for point in linkage.points])
    return points, np.stack([motion.coordinate(pin)[..., 0] for pin in pins], axis=-1)


@pytest.mark.parametrize("name", LINKAGES)
@pytest.mark.parametrize("turns", [8, -50, 100_000])
def test_whole_turns_lead_back(name: str, turns: int):
    linkage, period, winding = LINKAGES[name]
    theta = np.array([0.9, 2.5, 4.5])
    near, angles = coordinates(linkage, theta)
    far, wound = coordinates(linkage, theta + 2.0 * np.pi * turns)
    assert_allclose(far, near, rtol=0.0, atol=4e-15 * (9 + abs(turns)) * np.abs(near).max())
    if winding is not None:
        # Of the others no turns are counted where that would leave them rounded to some 1e-10.
        counted = winding if abs(turns) < 150 else winding[:1]
        grown = (wound - angles)[:, : len(counted)] / (2.0 * np.pi)
        assert_allclose(grown, np.broadcast_to(turns * np.array(counted), grown.shape), rtol=0.0, atol=1e-9)
        assert np.abs(wound[:, len(counted) :]).max(initial=0.0) < 20.0
    assert turns % period == 0
    _, loops, _ = COMPILED.get(linkage)[1].begun
    assert all(track.end < 60.0 for _, track in loops.kept.values())


def test_a_turn_that_does_not_lead_back_is_followed():
    """A nut on a screw is somewhere else after each turn, though all angles come round."""
    linkage = Linkage(A=(0, 0), B=(1, 0))
    linkage.link("rod", "A")
    linkage.link("nut", "A", "B")
    linkage.revolute("A", "ground", "rod", axis=(1, 0), drive=True)
    linkage.screw("A", "rod", "nut", axis=(1, 0), pitch=0.01, name="thread")
    linkage.prismatic("B", "ground", "nut", axis=(1, 0))
    assert_allclose(linkage.move(A=2.0 * np.pi * 50).position("B"), (0.5, 0.0, 0.0), atol=1e-13)
