"""Verdicts on equilibria against critical loads from outside, the same in every axes, units and plane.

Right-angle frame: Argyris et al., Comput. Methods Appl. Mech. Engrg. 20 (1979) 105-131: legs 240, section 30 by 0.6,
E 71240, Poisson's ratio 0.31, loaded in its plane at the free end; critical at 1.09 and -0.68. Strip under a force at
its end: 4.0126 sqrt(B C) / L^2 (Timoshenko & Gere, Theory of Elastic Stability, 2nd ed., art. 6.3).
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose

PLANE = np.eye(3)
TURNED = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
TURNED = TURNED * np.sign(np.linalg.det(TURNED))


def right_angle(axes: np.ndarray, load: np.ndarray, segments: int, unit: float = 1.0) -> Frame:
    """The frame, its plane spanned by the first two axes, in units of length so many times smaller."""
    leg, thin, high = 240.0 * unit, 0.6 * unit, 30.0 * unit
    section = Section(A=thin * high, Iy=high * thin**3 / 12, Iz=thin * high**3 / 12, J=high * thin**3 / 3)
    beam = Beam(section, Material(E=71240.0 / unit**2, nu=0.31), segments=segments, up=axes[:, 2])
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (leg, 0, 0), "C": (leg, -leg, 0)}.items():
        frame.node(name, axes @ place)
    frame.add("AB", beam, "A", "B")
    frame.add("BC", beam, "B", "C")
    frame.fix("A")
    push = np.multiply.outer(load, axes[:, 0])
    frame.load("C", fx=push[..., 0], fy=push[..., 1], fz=push[..., 2])
    return frame


def rod(axes: np.ndarray, section: Section, segments: int = 16, **load: np.ndarray) -> Frame:
    """A cantilever of length 1 with E = 1 and G = 1/2 under a force or moment (..., 3) at its end, in these axes."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", axes[:, 0])
    frame.add("AB", Beam(section, Material(E=1.0, nu=0.0), segments=segments, up=axes[:, 2]), "A", "B")
    frame.fix("A")
    for kind, given in load.items():
        frame.load("B", **{kind + name: value for name, value in zip("xyz", (given @ axes.T).T, strict=True)})
    return frame


@pytest.mark.parametrize(("segments", "unit"), [(8, 1.0), (8, 1e-3), (16, 1.0)])
def test_the_right_angle_frame_is_stable_up_to_its_critical_loads(segments: int, unit: float) -> None:
    """In its plane; turned, it is in that plane exactly where it is stable there, and beyond leaves it."""
    load = np.array([-0.75, -0.70, -0.66, 1.05, 1.13])
    stable = [False, False, True, True, False]
    flat = right_angle(PLANE, load, segments, unit).solve(large=True)
    assert flat.stable.tolist() == stable
    assert flat.converged.all()
    turned = right_angle(TURNED, load, segments, unit).solve(large=True)
    assert turned.stable.all()
    across = turned.displacement("C")[:, :3] @ TURNED[:, 2] / unit
    assert (np.abs(across) < 1e-6).tolist() == stable
    assert (np.abs(across)[~np.array(stable)] > 1.0).all()


@pytest.mark.parametrize("axes", [PLANE, TURNED], ids=["plane", "turned"])
def test_a_strip_under_a_force_at_its_end(axes: np.ndarray) -> None:
    share = np.array([0.5, 0.99, 1.01, 1.1])
    section = Section(A=1e4, Iy=1.0, Iz=1e4, J=2.0)
    force = np.multiply.outer(share, [0.0, -4.0126, 0.0])
    solution = rod(axes, section, f=force).solve(large=True)
    assert solution.converged.all()
    across = np.abs(solution.displacement("B")[:, :3] @ axes[:, 2])
    inside = across < 1e-9
    assert (inside & solution.stable).tolist() == [True, True, False, False]
    # beyond, what is kept to the plane is unstable there, and the rest is stable out of it
    assert (inside == (axes is PLANE))[2:].all()
    assert (inside == ~solution.stable)[2:].all()


@pytest.mark.parametrize("axes", [PLANE, TURNED], ids=["plane", "turned"])
def test_a_round_rod_under_a_moment_of_fixed_axis(axes: np.ndarray) -> None:
    """Bent into a circle, and stable up to ``x tan(x) = 1`` where the rod turns by 2 x.

    For a moment M that counts as semitangential, with bending stiffness 1 and torsional stiffness 1/2, neighbouring
    shapes satisfy ``t' = -M n, n' = 0`` for the spin less half its end value, in axes that turn with the rod by M; from
    minus to plus half the end value they lead only where ``tan(M / 2) = 2 / M``.
    """
    critical = 2.0 * 0.8603335890193798
    turn = critical * np.array([0.5, 0.98, 1.02, np.pi / critical, 2.0 * np.pi / critical])
    moment = np.multiply.outer(turn, [0.0, 0.0, 1.0])
    solution = rod(axes, Section(A=1e6, Iy=1.0, Iz=1.0, J=1.0), m=moment).solve(large=True)
    assert solution.converged.all()
    assert solution.stable.tolist() == [True, True, False, False, False]
    moved = solution.displacement("B")[:, :3] @ axes
    circle = np.stack([np.sin(turn) / turn - 1.0, (1.0 - np.cos(turn)) / turn, 0.0 * turn], axis=-1)
    assert_allclose(moved, circle, atol=1e-4)


@pytest.mark.parametrize("area", [1e-4, 10.0, 1e3])
def test_a_hinge_of_any_axis_under_a_force_on_a_stiff_rod(area: float) -> None:
    """Angles at which ``k p`` is the moment of the force about the axis, for rods that hardly bend and not at all."""
    axis = np.array([1.0, 2.0, 2.0]) / 3.0
    across = np.array([0.0, 1.0, -1.0]) / np.sqrt(2.0)
    axes = np.stack([across, np.cross(axis, across), axis], axis=-1)
    arm, force, stiffness = np.array([1.0, 0.0, 0.5]), np.array([0.0, 40.0, 10.0]), 5.0
    frame = Frame()
    for name, place in {"G": (0, 0, 0), "A": (0, 0, 0), "B": arm}.items():
        frame.node(name, place)
    section = Section(A=area, Iy=area, Iz=area, J=area)
    frame.add("AB", Beam(section, Material(E=200e9, nu=0.3)), "A", "B")
    frame.add("hinge", Joint((np.inf,) * 5 + (stiffness,), axes=axes), "G", "A")
    frame.fix("G")
    frame.load("B", fx=force[0], fy=force[1], fz=force[2])
    solution = frame.solve(large=True)
    assert solution.stable
    angle = float(solution.joint_displacement("hinge")[5])
    out = np.cross(axis, arm)
    turned = arm * np.cos(angle) + out * np.sin(angle) + axis * (axis @ arm) * (1.0 - np.cos(angle))
    assert stiffness * angle == pytest.approx(axis @ np.cross(turned, force), abs=2e-5)


def test_a_ball_joint_turned_by_more_than_half_a_turn() -> None:
    """A dead moment along the rod turns its ball joint by moment over stiffness."""
    moment = np.array([1.0, 15.0, 16.0, 40.0])
    frame = Frame()
    for name, x in {"A": 0.0, "B": 0.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("ball", Joint((np.inf,) * 3 + (5.0,) * 3), "A", "B")
    frame.add("BC", Beam(Section(A=8e-5, Iy=3e-10, Iz=1e-9, J=8e-10), Material(E=200e9, nu=0.3)), "B", "C")
    frame.fix("A")
    frame.load("C", mx=moment)
    solution = frame.solve(large=True)
    assert solution.converged.all()
    assert_allclose(
        solution.joint_displacement("ball")[:, 3:], np.multiply.outer(moment / 5.0, [1.0, 0.0, 0.0]), atol=1e-9
    )


@pytest.mark.parametrize("scale", [1e-20, 1e-100, 1e-250])
def test_tiny_loads_have_all_digits_of_the_linear_solution(scale: float) -> None:
    """A slender rod in space, askew: twelve digits, and not those of one elimination."""
    frame = rod(TURNED, Section(A=1e6, Iy=1.0, Iz=2.0, J=1.0), f=scale * np.array([0.3, -0.2, 0.1]))
    linear, large = frame.solve(), frame.solve(large=True)
    expected = linear.displacement("B")
    assert large.status == "stable"
    assert_allclose(large.displacement("B"), expected, rtol=0.0, atol=1e-11 * np.abs(expected).max())
