"""A joint with two free rotations, and two joints in series, at large displacement: what each is."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Joint
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

TIP, FORCE, SPRING = np.array([0.2, 0.1, 0.8]), np.array([40.0, -35.0, 15.0]), 60.0
INF = np.inf


def displaced(*joints: Joint) -> NDArray[np.float64]:
    """Displacement and rotation of the tip of a rigid rod on joints in series."""
    frame = Frame()
    for k in range(len(joints) + 1):
        frame.node(f"N{k}", (0.0, 0.0, 0.0))
    frame.node("tip", TIP)
    for k, joint in enumerate(joints):
        frame.add(f"joint{k}", joint, f"N{k}", f"N{k + 1}")
    frame.rigid(f"N{len(joints)}", "tip")
    frame.fix("N0")
    frame.load("tip", **dict(zip(("fx", "fy", "fz"), FORCE, strict=True)))
    return np.asarray(frame.solve(large=True).displacement("tip"))


def test_two_joints_in_series_are_a_universal_joint() -> None:
    """Its energy is least by turns about z of the ground and then about x of the cross, which goes with the rod."""

    def turned(turn: NDArray[np.float64]) -> Rotation:
        return Rotation.from_euler("ZX", turn)

    def energy(turn: NDArray[np.float64]) -> float:
        return float(0.5 * SPRING * (turn @ turn) - FORCE @ (turned(turn).apply(TIP) - TIP))

    least = minimize(energy, np.zeros(2), tol=1e-13).x
    found = displaced(Joint((INF,) * 5 + (SPRING,)), Joint((INF, INF, INF, SPRING, INF, INF)))
    assert_allclose(found[:3], turned(least).apply(TIP) - TIP, atol=1e-6)


def test_two_free_rotations_of_one_joint_never_twist() -> None:
    """It is a constant-velocity joint: one rotation vector across the third axis, of least energy."""

    def turned(turn: NDArray[np.float64]) -> Rotation:
        return Rotation.from_rotvec((turn[0], 0.0, turn[1]))

    def energy(turn: NDArray[np.float64]) -> float:
        return float(0.5 * SPRING * (turn @ turn) - FORCE @ (turned(turn).apply(TIP) - TIP))

    least = minimize(energy, np.zeros(2), tol=1e-13).x
    found = displaced(Joint((INF, INF, INF, SPRING, INF, SPRING)))
    assert_allclose(found[:3], turned(least).apply(TIP) - TIP, atol=1e-6)
    assert_allclose(found[3:], (least[0], 0.0, least[1]), atol=1e-6)
