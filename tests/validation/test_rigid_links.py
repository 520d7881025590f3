"""Rigid offsets, ties, spring supports and joints, by statics and closed forms worked out in the docstrings."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

LENGTH, ARM = 1.2, 0.3
STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=0.03, z=0.02)
EI, EA = 200e9 * 0.02 * 0.03**3 / 12, 200e9 * 6e-4
INF = np.inf
Array = NDArray[np.float64]


def cantilever() -> Frame:
    """A cantilever along x."""
    frame = Frame()
    frame.node("wall", (0.0, 0.0, 0.0))
    frame.node("tip", (LENGTH, 0.0, 0.0))
    frame.add("beam", Beam(BAR, STEEL), "wall", "tip")
    frame.fix("wall")
    return frame


def test_rigid_offset() -> None:
    """A force F along x on a rigid arm of length a in y from the tip: the tip turns by -F a L/EI.

    The arm's end then moves by F L/EA + F a^2 L/EI along x and -F a L^2/2EI in y.
    """
    frame = cantilever()
    frame.node("arm", (LENGTH, ARM, 0.0))
    frame.rigid("tip", "arm")
    frame.load("arm", fx=500.0)
    solution = frame.solve()
    turn = -500.0 * ARM * LENGTH / EI
    arm = solution.displacement("arm")
    assert_allclose(arm[5], turn, rtol=1e-12)
    assert_allclose(arm[0], 500.0 * LENGTH / EA - ARM * turn, rtol=1e-12)
    assert_allclose(arm[1], turn * LENGTH / 2, rtol=1e-12)
    assert_allclose(solution.displacement("tip")[:2], [500.0 * LENGTH / EA, turn * LENGTH / 2], rtol=1e-12)
    assert_allclose(solution.reaction("wall")[[0, 5]], [-500.0, 500.0 * ARM], rtol=1e-12)


def test_a_rigid_body_of_several_nodes() -> None:
    """Two parallel cantilevers with a rigid head: k = 2 (12 EI/L^3) sideways, plus the turning by the arms.

    With the head free to turn the axial stiffness of the pair counts: for F in y at the head's middle, by symmetry
    about the x axis, [24 EI/L^3, -12 EI/L^2; -12 EI/L^2, 8 EI/L + 2 EA h^2/L] [v, r] = [F, 0].
    """
    frame = Frame()
    for name, y in {"low": -ARM, "high": ARM}.items():
        frame.node(f"{name} wall", (0.0, y, 0.0))
        frame.node(f"{name} tip", (LENGTH, y, 0.0))
        frame.add(name, Beam(BAR, STEEL), f"{name} wall", f"{name} tip")
        frame.fix(f"{name} wall")
    frame.node("head", (LENGTH, 0.0, 0.0))
    frame.rigid("head", "low tip", "high tip")
    frame.load("head", fy=1000.0)
    head = frame.solve().displacement("head")
    coupling = -12 * EI / LENGTH**2
    matrix = [[24 * EI / LENGTH**3, coupling], [coupling, 8 * EI / LENGTH + 2 * EA * ARM**2 / LENGTH]]
    assert_allclose(head[[1, 5]], np.linalg.solve(matrix, [1000.0, 0.0]), rtol=1e-12)
    assert_allclose(head[[0, 2, 3, 4]], 0.0, atol=1e-15)


def test_tie_of_one_component() -> None:
    """Two cantilever tips tied in uy share the load equally and turn alike, without touching ux."""
    frame = cantilever()
    frame.node("far wall", (2 * LENGTH, 0.0, 0.0))
    frame.node("far tip", (LENGTH, 0.0, 0.0))
    frame.add("far", Beam(BAR, STEEL), "far wall", "far tip")
    frame.fix("far wall")
    frame.tie("tip", "far tip", "uy")
    frame.load("tip", fy=800.0, fx=100.0)
    solution = frame.solve()
    tip, far = solution.displacement("tip"), solution.displacement("far tip")
    assert_allclose(
        tip[[0, 1, 5]], [100.0 * LENGTH / EA, 400 * LENGTH**3 / (3 * EI), 400 * LENGTH**2 / (2 * EI)], rtol=1e-12
    )
    assert_allclose(far[[1, 5]], [tip[1], -tip[5]], rtol=1e-12)
    assert_allclose(far[0], 0.0, atol=1e-18)
    assert_allclose(solution.reaction("far wall")[[1, 5]], [-400.0, 400.0 * LENGTH], rtol=1e-12)


@pytest.mark.parametrize("k", [np.array([0.0, 1e3, 1e5, 1e9, 1e15]), np.array([INF])], ids=["springs", "ideal"])
def test_spring_support(k: Array) -> None:
    """A cantilever propped by a spring k: it carries F/(1 + 3EI/(k L^3)), from nothing to the rigid prop's F."""
    frame = cantilever()
    frame.node("ground", (LENGTH, 0.0, 0.0))
    frame.fix("ground")
    zero = np.zeros_like(k)
    frame.add("spring", Joint(stiffness=np.stack([zero, k, zero, zero, zero, zero], axis=-1)), "tip", "ground")
    frame.load("tip", fy=-600.0)
    solution = frame.solve()
    # Both shares without a difference: k/(k + 3EI/L^3) and its complement.
    own = 3 * EI / LENGTH**3
    share = np.where(np.isinf(k), 1.0, k / (np.where(np.isinf(k), 1.0, k) + own))
    sag = np.where(np.isinf(k), 0.0, -600.0 / (k + own))
    assert_allclose(solution.reaction("ground")[:, 1], 600.0 * share, rtol=1e-12, atol=600.0 * 1e-15)
    assert_allclose(solution.displacement("tip")[:, 1], sag, rtol=1e-12)
    assert_allclose(solution.joint_force("spring")[:, 1], 600.0 * share, rtol=1e-12)


def test_joint_force_acts_on_the_first_node() -> None:
    """A joint in series with a clamped stub: K delta pulls the first node after the second; axes at 30 degrees."""
    c, s = np.cos(np.pi / 6), np.sin(np.pi / 6)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])
    k = np.array([1e6, 2e6, 3e6, 4e4, 5e4, 6e4])
    frame = cantilever()
    frame.node("ground", (0.0, 0.0, 0.0))
    frame.node("base", (0.0, 0.0, 0.0))
    frame.node("free", (LENGTH, 0.0, 0.0))
    frame.fix("ground")
    frame.add("hinge", Joint(stiffness=k, axes=axes), "ground", "base")
    frame.add("stub", Beam(BAR, STEEL), "base", "free")
    frame.load("free", fx=10.0, fy=200.0, fz=-30.0, mx=4.0, my=5.0, mz=6.0)
    solution = frame.solve()
    # Force and moment at the joint from the load; the ground, first, is pulled by what acts on the second node.
    force = np.array([10.0, 200.0, -30.0])
    moment = np.array([4.0, 5.0, 6.0]) + np.cross([LENGTH, 0.0, 0.0], force)
    expected = np.concatenate([axes.T @ force, axes.T @ moment])
    assert_allclose(solution.joint_force("hinge"), expected, rtol=1e-12)
    assert_allclose(solution.joint_displacement("hinge"), expected / k, rtol=1e-12)
    base = solution.displacement("base")
    turned = np.concatenate([axes @ (expected[:3] / k[:3]), axes @ (expected[3:] / k[3:])])
    assert_allclose(base, turned, rtol=1e-12)
    assert_allclose(solution.reaction("ground")[:3], -force, rtol=1e-12)


@pytest.mark.parametrize("stiffness", [INF, 1e9])
def test_clearance_in_a_joint(stiffness: float) -> None:
    """An imposed gap g in a joint between two cantilevers in line: each tip gives way by g/2, by 3 EI g/(2 L^3).

    With springs k in the joint the force is g/(2 L^3/3EI + 1/k).
    """
    frame = cantilever()
    frame.node("far wall", (2 * LENGTH, 0.0, 0.0))
    frame.node("far tip", (LENGTH, 0.0, 0.0))
    frame.add("far", Beam(BAR, STEEL), "far tip", "far wall")
    frame.fix("far wall")
    frame.add("pin", Joint(stiffness=(stiffness,) * 5 + (0.0,)), "tip", "far tip")
    gap = 1e-3
    frame.offset("pin", uy=gap)
    solution = frame.solve()
    tip, far = solution.displacement("tip")[1], solution.displacement("far tip")[1]
    force = gap / (2 * LENGTH**3 / (3 * EI) + 1 / stiffness)
    assert_allclose([tip, far], [-force * LENGTH**3 / (3 * EI), force * LENGTH**3 / (3 * EI)], rtol=1e-12)
    assert_allclose(solution.joint_displacement("pin")[1], far - tip, rtol=1e-12)
    assert_allclose(solution.joint_force("pin")[1], -force, rtol=1e-12)
    assert_allclose(solution.reaction("wall")[1], force, rtol=1e-12)
