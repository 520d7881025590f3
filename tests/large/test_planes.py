"""A frame is kept to a coordinate plane only where it lies in it, not where it stands across."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from numpy.testing import assert_allclose

STEEL = Material(E=200e9, nu=0.3)
ROD = Beam(Circle(diameter=0.02), STEEL, segments=4)
INF = float("inf")


def cantilever(along: int, force: np.ndarray, moment: np.ndarray) -> np.ndarray:
    """Displacement of the tip of a rod of length 1 along a global axis."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", tuple(np.eye(3)[along]))
    frame.add("AB", ROD, "A", "B")
    frame.fix("A")
    frame.load("B", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), (*force, *moment), strict=True)))
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    found: np.ndarray = solution.displacement("B")
    return found


@pytest.mark.parametrize("along", [0, 1, 2])
def test_a_round_rod_loaded_across_both_ways(along: int) -> None:
    """It bends into the force as under the same force along one axis: objectivity for a turn about the rod."""
    one, two = (along + 1) % 3, (along + 2) % 3
    force = np.zeros(3)
    force[one], force[two] = 300.0, 400.0
    found = cantilever(along, force, np.zeros(3))
    straight = cantilever(0, np.array([0.0, 500.0, 0.0]), np.zeros(3))
    assert_allclose(found[along], straight[0], rtol=1e-9)
    assert_allclose(found[[one, two]], straight[1] * np.array([0.6, 0.8]), rtol=1e-9)
    assert_allclose(found[3:][[one, two]], straight[5] * np.array([-0.8, 0.6]), rtol=1e-9)


def test_a_rod_on_a_ball_is_turned_out_of_every_plane() -> None:
    """Springs of 1 N m/rad in a ball joint against a force of 1 N on an arm of 1 m: p = k φ sin-law in one plane."""
    frame = Frame()
    for name, x in {"O": 0.0, "A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("ball", Joint((INF, INF, INF, 1.0, 1.0, 1.0)), "O", "A")
    frame.add("AB", Beam(Circle(diameter=0.02), STEEL), "A", "B")
    frame.fix("O")
    frame.load("B", fy=0.06, fz=0.08)
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    turn = solution.joint_displacement("ball")[3:]
    assert_allclose(turn / np.linalg.norm(turn), [0.0, -0.8, 0.6], atol=1e-9)
    size = np.linalg.norm(turn)
    assert_allclose(size, 0.1 * np.cos(size), rtol=1e-4)  # the rod bends by 1e-6
