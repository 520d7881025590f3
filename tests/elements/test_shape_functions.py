"""Shape functions: they satisfy the beam's differential equations, and their work gives the textbook's end forces."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, Material, Rectangle
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3)
L = 1.9
BEAMS = [
    Beam(Rectangle(y=0.3, z=0.2), STEEL, end=end, shear=shear)
    for end in (None, Rectangle(y=0.1, z=0.3))
    for shear in (False, True)
]
IDS = ["bernoulli", "timoshenko", "tapered bernoulli", "tapered timoshenko"]


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
def test_they_are_one_at_their_own_component_and_zero_at_the_others(beam: Beam) -> None:
    ends = beam.shape_functions(L, np.array([0.0, L]))
    assert_allclose(ends.reshape(12, 12), np.eye(12), atol=2e-15)


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
@given(fraction=st.floats(0.05, 0.95))
def test_gradients_are_derivatives(beam: Beam, fraction: float) -> None:
    """Central differences with Richardson's step."""

    def slope(h: float) -> Array:
        return (beam.shape_functions(L, fraction * L + h) - beam.shape_functions(L, fraction * L - h)) / (2 * h)

    assert_allclose(beam.shape_gradients(L, fraction * L), (4 * slope(5e-4) - slope(1e-3)) / 3, atol=1e-8)


@pytest.mark.parametrize("beam", BEAMS, ids=IDS)
def test_section_forces_are_in_equilibrium(beam: Beam) -> None:
    """From the strains at any x follow the end forces: N, V, T constant, M linear."""
    x = np.linspace(0.0, L, 9)
    u = np.random.default_rng(4).normal(size=12)
    values, slopes = beam.shape_functions(L, x) @ u, beam.shape_gradients(L, x) @ u
    flexibility, f = beam.section_flexibility(x / L), beam.end_forces(L, u)
    strain = slopes + np.stack([0 * x, -values[:, 5], values[:, 4], 0 * x, 0 * x, 0 * x], axis=-1)
    forces = np.stack(
        [0 * x - f[0], 0 * x - f[1], 0 * x - f[2], 0 * x - f[3], -f[4] - x * f[2], x * f[1] - f[5]], axis=-1
    )
    size = np.abs(flexibility * forces).max(axis=0)
    size[size == 0.0] = 1.0
    assert_allclose(strain / size, flexibility * forces / size, atol=1e-11)
    # at x = L they are the forces of the second end
    assert_allclose(forces[-1], f[6:], atol=1e-12 * np.abs(f).max())


@pytest.mark.parametrize("shear", [False, True])
def test_equivalent_end_forces_of_a_load(shear: bool) -> None:
    """Roark, 7th ed., table 8.1, case 2d: q L / 2 and q L^2 / 12, whatever the shear stiffness; and a triangle."""
    beam = Beam(Rectangle(y=0.3, z=0.2), STEEL, shear=shear)
    x, w = np.polynomial.legendre.leggauss(4)
    x, w = (x + 1) / 2 * L, w / 2 * L
    N = beam.shape_functions(L, x)
    uniform = np.einsum("q,qi->i", w, N[:, 1])[[1, 5, 7, 11]]
    assert_allclose(uniform, [L / 2, L**2 / 12, L / 2, -(L**2) / 12], rtol=1e-13)
    if not shear:
        triangle = np.einsum("q,qi->i", w * x / L, N[:, 1])[[1, 5, 7, 11]]
        assert_allclose(triangle, [3 * L / 20, L**2 / 30, 7 * L / 20, -(L**2) / 20], rtol=1e-13)


def test_hermite() -> None:
    """Without shear they are Hermite's cubics (Przemieniecki 1968, ch. 11), in xz with rotations reversed."""
    t = np.linspace(0.0, 1.0, 7)
    cubic = np.stack([1 - 3 * t**2 + 2 * t**3, L * t * (1 - t) ** 2, t**2 * (3 - 2 * t), L * t**2 * (t - 1)], axis=-1)
    N = BEAMS[0].shape_functions(L, t * L)
    assert_allclose(N[:, 1][:, [1, 5, 7, 11]], cubic, atol=1e-15)
    assert_allclose(N[:, 2][:, [2, 4, 8, 10]], cubic * [1, -1, 1, -1], atol=1e-15)


def test_interdependent_cubics() -> None:
    """Friedman & Kosmatka (1993): deflection by the first displacement and rotation."""
    beam = BEAMS[1]
    phi = 12 * 200e9 * beam.section.Iz / (5 / 6 * STEEL.G * beam.section.A * L**2)
    t = np.linspace(0.0, 1.0, 7)
    N = beam.shape_functions(L, t * L)
    assert_allclose(N[:, 1, 1], (2 * t**3 - 3 * t**2 - phi * t + 1 + phi) / (1 + phi), atol=1e-14)
    first = L * (t**3 - (2 + phi / 2) * t**2 + (1 + phi / 2) * t) / (1 + phi)
    assert_allclose(N[:, 1, 5], first, atol=1e-14)
    assert_allclose(N[:, 5, 1], 6 * (t**2 - t) / (L * (1 + phi)), atol=1e-14)
    assert_allclose(N[:, 5, 5], (3 * t**2 - (4 + phi) * t + 1 + phi) / (1 + phi), atol=1e-14)


def test_lengths_and_stations_broadcast() -> None:
    beam = BEAMS[2]
    lengths, fractions = np.array([[1.0], [2.0]]), np.linspace(0.0, 1.0, 5)
    N = beam.shape_functions(lengths, lengths * fractions)
    assert N.shape == (2, 5, 6, 12)
    assert_allclose(N[1, 3], beam.shape_functions(2.0, 1.5), atol=1e-15)
