"""The spring: energy, equilibrium, a string's transverse stiffness, and use in a frame."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from linkframe.elements.spring import Spring
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose

K, S, L = 2000.0, 50.0, 0.5


def potential(ends: np.ndarray) -> float:
    """Energy of a spring of stiffness K that carries S at length L, its ends displaced by (u1, u2) each (3,)."""
    length = np.linalg.norm(np.array([L, 0, 0]) + ends[3:] - ends[:3])
    return float(S * (length - L) + K * (length - L) ** 2 / 2)


def test_stiffness_is_the_hessian_of_the_energy() -> None:
    """Second differences of the exact, large-displacement energy, less the work of the force at rest."""
    h = 1e-4
    dofs = [0, 1, 2, 6, 7, 8]
    found = Spring(K, S).stiffness_matrix(L)
    assert not np.delete(found, dofs, axis=0).any()
    for i in range(6):
        for j in range(6):
            e, f = h * np.eye(6)[i], h * np.eye(6)[j]
            second = potential(e + f) - potential(e - f) - potential(f - e) + potential(-e - f)
            assert_allclose(second / (4 * h * h), found[dofs[i], dofs[j]], rtol=0.0, atol=2e-4 * K)


def test_springs_and_forces_agree_with_the_matrix() -> None:
    spring, length = Spring([K, 3 * K], [S, -S]), np.array([L, 2 * L])
    stiffness, rows = spring.springs(length)
    matrix = spring.stiffness_matrix(length)
    assert_allclose(np.einsum("...i,...ij,...ik->...jk", stiffness, rows, rows), matrix, rtol=1e-15)
    moved = np.random.default_rng(0).normal(size=(2, 12))
    assert_allclose(spring.end_forces(length, moved), (matrix @ moved[..., None])[..., 0], rtol=1e-12)
    assert_allclose(Spring(0.0).geometric_matrix(L, S), Spring(0.0, S).stiffness_matrix(L))
    assert not spring.mass_matrix(length).any()


def test_a_cantilever_propped_by_a_spring() -> None:
    """Tip of a cantilever on a spring: F / (3EI/l^3 + k)."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "C": (1, 1, 0)}.items():
        frame.node(name, place)
    beam = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3, density=7800.0))
    frame.add("AB", beam, "A", "B")
    frame.add("spring", Spring(K), "B", "C")
    frame.fix("A")
    frame.fix("C")
    frame.load("B", fy=-10.0)
    solution = frame.solve()
    bending = 3 * 200e9 * 0.01 * 0.02**3 / 12
    assert_allclose(solution.displacement("B")[1], -10.0 / (bending + K), rtol=1e-12)
    assert_allclose(solution.forces("spring", [0.0, 0.5, 1.0])[:, 0], 10.0 * K / (bending + K), rtol=1e-12)
    assert_allclose(solution.reaction("C")[1], 10.0 * K / (bending + K), rtol=1e-12)
    along = solution.displacement_along("spring", [0.0, 0.25, 1.0])[:, 1]
    assert_allclose(along, solution.displacement("B")[1] * np.array([1.0, 0.75, 0.0]), atol=1e-18)
    # The spring weighs nothing, and makes the beam's first mode faster.
    loose = frame.copy()
    del loose.members["spring"]
    assert frame.modes(2).frequencies[1] > loose.modes(2).frequencies[1]


def test_a_string_carries_no_moment() -> None:
    """Its force goes with its turned line: N = S, V = S / L times how far its ends are apart across, M = 0."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (L, 0.0, 0.0))
    frame.add("string", Spring(K, [S, 2.0 * S]), "A", "B")
    frame.fix("A")
    frame.fix("B", "ux", "rx", "ry", "rz")
    frame.load("B", fy=3.0, fz=-2.0)
    found = frame.solve().forces("string", [0.0, 0.4 * L, L])
    assert_allclose(found[..., 1:3], np.broadcast_to([3.0, -2.0], (2, 3, 2)), rtol=1e-12)
    assert_allclose(found[..., 3:], 0.0, atol=1e-12)


def test_a_row_of_parts_is_the_spring() -> None:
    assert Spring(K, S).part(1, 4).stiffness == 4 * K
    assert Spring(K, S).part(0, 1).force == S


def test_what_cannot_be_is_refused() -> None:
    with pytest.raises(FrameError, match="Spring: stiffness = -1"):
        Spring(-1.0)
    with pytest.raises(FrameError, match="Spring: force = inf"):
        Spring(1.0, np.inf)
    with pytest.raises(FrameError, match=r"stiffness \(2,\), force \(3,\)"):
        Spring([1.0, 2.0], [1.0, 2.0, 3.0])
    with pytest.raises(FrameError, match="stress needs a section"):
        Spring(1.0).stress(0.5, np.zeros(6))


def test_displacements_may_be_a_list() -> None:
    stretched = Spring(stiffness=2e3).end_forces(0.5, [0.0] * 6 + [0.1] + [0.0] * 5)  # type: ignore[arg-type]
    assert_allclose(stretched[[0, 6]], [-200.0, 200.0])
