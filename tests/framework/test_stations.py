"""Stations along members whose length varies over the batch."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.solution import Solution

LENGTHS = (1.0, 2.0, 3.0)


def cantilever(length: object, segments: int) -> Solution:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", np.multiply.outer(length, (1.0, 0.0, 0.0)))
    frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=2e11, nu=0.3), segments=segments), "A", "B")
    frame.fix("A")
    frame.load("B", fy=-1.0)
    frame.line_load("AB", fy=-3.0)
    return frame.solve()


@pytest.mark.parametrize("segments", [1, 4])
@pytest.mark.parametrize("quantity", ["forces", "displacement_along", "stress"])
def test_a_batch_of_lengths_gives_what_each_length_gives(segments: int, quantity: str) -> None:
    at = np.array([0.0, 0.3, 0.9, 1.0])
    batch = cantilever(LENGTHS, segments)
    common = getattr(batch, quantity)("AB", at)
    relative = getattr(batch, quantity)("AB", np.multiply.outer(LENGTHS, at))
    for entry, length in enumerate(LENGTHS):
        alone = getattr(cantilever(length, segments), quantity)
        for ours, theirs in ((common, alone("AB", at)), (relative, alone("AB", length * at))):
            np.testing.assert_allclose(ours[entry], theirs, rtol=1e-13, atol=1e-13 * np.abs(theirs).max())


def test_shear_and_moment_of_a_cantilever_at_every_length() -> None:
    # V = P + q (L - x) and M = -(P (L - x) + q (L - x)^2 / 2), by equilibrium of the part beyond x.
    at = 0.9
    rest = np.array(LENGTHS) - at
    forces = cantilever(LENGTHS, 4).forces("AB", np.array([at]))[:, 0]
    np.testing.assert_allclose(np.abs(forces[:, 1]), 1.0 + 3.0 * rest, rtol=1e-12)
    np.testing.assert_allclose(np.abs(forces[:, 5]), rest + 1.5 * rest**2, rtol=1e-12)
