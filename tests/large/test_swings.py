"""Long ways to an equilibrium: pendulums and chains of stiff links fall from anywhere to where they hang."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from numpy.testing import assert_allclose

STEEL = Material(E=200e9, nu=0.3, density=7850.0)
INF = float("inf")
PIN = Joint((INF, INF, INF, INF, INF, 0.0))
GRAVITY = (0.0, -9.81, 0.0)


def test_a_pendulum_hangs_wherever_it_starts() -> None:
    """From straight up, where it is in equilibrium, too; its links 1e7 times stiffer than heavy."""
    angle = np.radians([-90.0, -45.0, 0.0, 45.0, 89.9, 90.0, 135.0, 269.0])
    place = np.stack([np.cos(angle), np.sin(angle), np.zeros(8)], axis=-1)
    frame = Frame()
    frame.node("O", (0.0, 0.0, 0.0))
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", place)
    frame.add("pin", PIN, "O", "A")
    frame.add("AB", Beam(Circle(diameter=0.05), STEEL), "A", "B")
    frame.fix("O")
    frame.gravity(GRAVITY)
    solution = frame.solve(large=True)
    below = place + solution.displacement("B")[:, :3]
    assert_allclose(below, np.tile([0.0, -1.0, 0.0], (8, 1)), atol=1e-6)
    assert solution.stable.all()
    assert (solution.status == "stable beyond a saddle").tolist() == [False] * 5 + [True] + [False] * 2
    assert solution.iterations.max() < 60


@pytest.mark.parametrize("angle", [0.0, 57.0, 143.0])
def test_a_long_rod_hangs_below_where_its_hinge_is_moved(angle: float) -> None:
    """In more segments than are solved side by side; it lengthens by its weight, ``rho g L^2 / 2 E``."""
    start = np.array([np.cos(np.radians(angle)), np.sin(np.radians(angle)), 0.0])
    frame = Frame()
    frame.node("O", (0.0, 0.0, 0.0))
    frame.node("B", start)
    frame.add("OB", Beam(Circle(diameter=0.05), Material(E=2e9, nu=0.3, density=7850.0), segments=81), "O", "B")
    frame.fix("O", "uy", "uz", "rx", "ry")
    frame.prescribe("O", ux=0.3)
    frame.gravity(GRAVITY)
    solution = frame.solve(large=True)
    assert solution.stable
    longer = 7850.0 * 9.81 / (2.0 * 2e9)
    assert_allclose(start + solution.displacement("B")[:3], [0.3, -1.0 - longer, 0.0], atol=1e-9)


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_a_chain_hangs_as_its_weights_tell(side: float) -> None:
    """Four bars between two pins, from an arc below (1) and from one above (-1), which falls through.

    With the horizontal pull H the slope of a bar is the mean vertical force on it over H, and from bar to bar that
    changes by half the weight of both.
    """
    start = np.array([(0.0, 0.0), (0.3, -0.4), (0.75, -0.6), (1.2, -0.4), (1.5, 0.0)]) * [1.0, side]
    frame = Frame()
    for k, (x, y) in enumerate(start):
        frame.node(f"a{k}", (x, y, 0.0))
        frame.node(f"b{k}", (x, y, 0.0))
        frame.add(f"pin{k}", PIN, f"a{k}", f"b{k}")
    for k in range(4):
        frame.add(f"bar{k}", Beam(Circle(diameter=0.01), STEEL), f"b{k}", f"a{k + 1}")
    frame.fix("a0")
    frame.fix("b4")
    frame.gravity(GRAVITY)
    solution = frame.solve(large=True)
    assert solution.stable
    found = np.array([start[k] + solution.displacement(f"b{k}")[:2] for k in range(5)])
    sizes = np.linalg.norm(np.diff(start, axis=0), axis=-1)
    assert_allclose(np.linalg.norm(np.diff(found, axis=0), axis=-1), sizes, rtol=1e-6)
    slope = np.diff(found[:, 1]) / np.diff(found[:, 0])
    over = np.diff(slope) / (sizes[1:] + sizes[:-1])
    assert over[0] > 0.0
    assert_allclose(over, over[0], rtol=1e-4)


@pytest.mark.parametrize("free", [3, 1], ids=["ball", "pin"])
def test_what_neither_load_nor_stiffness_resists_is_not_unstable(free: int) -> None:
    """Without a load every place of a pendulum is an equilibrium, and none of them is left."""
    frame = Frame()
    frame.node("O", (0.0, 0.0, 0.0))
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("pin", Joint((INF,) * (6 - free) + (0.0,) * free), "O", "A")
    frame.add("AB", Beam(Circle(diameter=0.05), STEEL), "A", "B")
    frame.fix("O")
    frame.load("B", fz=0.0)
    solution = frame.solve(large=True)
    assert (str(solution.status), bool(solution.stable)) == ("statically consistent mechanism", True)
    assert not solution.displacement("B").any()
