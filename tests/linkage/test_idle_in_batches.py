"""A rod that spins between two balls, whose dimensions vary: its spin moves no point, of whichever member."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from linkframe.framework import FrameError
from linkframe.models import Linkage
from numpy.testing import assert_allclose

Array = np.ndarray[Any, np.dtype[np.float64]]
ANGLES = np.linspace(0.0, 6.0, 7)


def crank_and_slider(radius: Array | float) -> Linkage:
    place = np.stack(np.broadcast_arrays(radius, 0.0, 0.02), axis=-1)
    linkage = Linkage(A=(0, 0, 0), B=place, C=(0.4, 0.05, 0.03), P=(0.5, 0.05, 0.03))
    for name, ends in (("crank", "AB"), ("rod", "BC"), ("slider", "CP")):
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "crank", axis=(0, 0, 1), drive=True)
    linkage.spherical("B", "crank", "rod")
    linkage.spherical("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0, 0), name="slide")
    return linkage


@pytest.mark.parametrize("spread", [1e-5, 1e-2])
def test_positions_of_a_batch_with_a_rod_between_balls(spread: float) -> None:
    """The slider is where the rod's length, that of the reference configuration, lets it be."""
    radius = 0.1 + spread * np.array([0.9, -1.0, 0.1, 0.7, -0.6])
    motion = crank_and_slider(radius).move(A=ANGLES[:, None])
    pin = np.stack(np.broadcast_arrays(radius * np.cos(ANGLES)[:, None], radius * np.sin(ANGLES)[:, None], 0.02), -1)
    square = (0.4 - radius) ** 2 + 0.05**2 + 0.01**2
    across = np.sum((pin[..., 1:] - (0.05, 0.03)) ** 2, axis=-1)
    assert_allclose(motion.position("P")[..., 0], pin[..., 0] + np.sqrt(square - across) + 0.1, rtol=1e-13)
    assert np.all(motion.status == "regular")


def test_what_moves_points_is_refused_in_a_batch_as_well() -> None:
    linkage = Linkage(A=(0, 0), B=np.stack(np.broadcast_arrays(1.0 + 1e-3 * np.arange(3), 0.0), axis=-1), C=(2, 1))
    linkage.link("crank", "A", "B")
    linkage.link("arm", "B", "C")
    linkage.revolute("A", "ground", "crank", drive=True)
    linkage.revolute("B", "crank", "arm")
    with pytest.raises(FrameError, match="1 degree of freedom has no drive"):
        linkage.move(A=0.0)
