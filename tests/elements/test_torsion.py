"""Saint-Venant torsion: a printed table, the series in 30 digits and the other way round, finite elements."""

from __future__ import annotations

from itertools import pairwise

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import ISection, Rectangle
from numpy.testing import assert_allclose
from skfem import Basis, ElementQuad2, MeshQuad, condense, solve
from skfem.models.poisson import laplace, unit_load

# Timoshenko & Goodier, Theory of Elasticity, 3rd ed., art. 109, p. 312: b/a, k1 = J / (a^3 b), k2 = T / (a^2 b tau)
TABLE = [
    (1.0, 0.1406, 0.208),
    (1.2, 0.166, 0.219),
    (1.5, 0.196, 0.231),
    (2.0, 0.229, 0.246),
    (2.5, 0.249, 0.258),
    (3.0, 0.263, 0.267),
    (4.0, 0.281, 0.282),
    (5.0, 0.291, 0.291),
    (10.0, 0.312, 0.312),
]


@pytest.mark.parametrize(("ratio", "k1", "k2"), TABLE)
def test_timoshenko_goodier(ratio: float, k1: float, k2: float) -> None:
    """Three printed digits."""
    for section in (Rectangle(y=2.0, z=2.0 * ratio), Rectangle(y=2.0 * ratio, z=2.0)):
        assert 16.0 * ratio * k1 == pytest.approx(section.J, abs=16.0 * ratio * 6e-4)
        assert 8.0 * ratio * k2 == pytest.approx(min(section.torsion_moduli), abs=8.0 * ratio * 6e-4)


def series(short: mp.mpf, long: mp.mpf) -> mp.mpf:
    """J of art. 109 with its own slowly converging sum."""
    total = mp.nsum(lambda k: mp.tanh((2 * k + 1) * mp.pi * long / (2 * short)) / (2 * k + 1) ** 5, [0, mp.inf])
    return long * short**3 / 3 * (1 - 192 / mp.pi**5 * short / long * total)


@pytest.mark.parametrize("ratio", [1.0, 1.01, 1.5, 3.0, 17.0, 1e3])
def test_thirty_digits(ratio: float) -> None:
    with mp.workdps(30):
        expected = series(mp.mpf(1) / 2, mp.mpf(ratio) / 2)
    assert pytest.approx(float(expected), rel=3e-16) == Rectangle(y=0.5 * ratio, z=0.5).J


@given(ratio=st.floats(0.2, 5.0))
def test_both_directions_of_the_series_agree(ratio: float) -> None:
    """The expansion across the other pair of sides is another series for the same J and stresses."""
    n = np.arange(1.0, 400.0, 2.0)
    section = Rectangle(y=1.0, z=ratio)
    # tanh differs from 1 beyond n = 400 by nothing, so that the tail is one of powers
    tail = 31 / 32 * 1.03692775514337 - np.sum(1 / n**5)
    J = ratio**3 / 3 * (1 - 192 / np.pi**5 * ratio * (np.sum(np.tanh(n * np.pi / (2 * ratio)) / n**5) + tail))
    assert_allclose(section.J, J, rtol=1e-12)
    bow = np.array([np.sum(1 / (n**2 * np.cosh(np.minimum(n * np.pi * r / 2, 300.0)))) for r in (ratio, 1 / ratio)])
    # T / tau where the distance to the side is 1/2 (sides y = const) and ratio/2 (sides z = const)
    assert_allclose(section.torsion_moduli, section.J / (np.array([1.0, ratio]) * (1 - 8 / np.pi**2 * bow)), rtol=1e-12)


def prandtl(ys: np.ndarray, zs: np.ndarray, inside: object) -> float:
    """J = 4 int phi of a quarter of a doubly symmetric section, four times, with -laplace(phi) = 1 (art. 104)."""
    mesh = MeshQuad.init_tensor(ys, zs)
    mesh = mesh.restrict(np.nonzero(inside(*mesh.p[:, mesh.t].mean(axis=1)))[0])  # type: ignore[operator]
    basis = Basis(mesh, ElementQuad2())
    facets = mesh.boundary_facets()
    rim = facets[np.all(mesh.p[:, mesh.facets[:, facets]].mean(axis=1) > 1e-12, axis=0)]
    source = unit_load.assemble(basis)
    phi = solve(*condense(laplace.assemble(basis), source, D=basis.get_dofs(rim)))
    return 16.0 * float(source @ phi)


def graded(*marks: float, step: float) -> np.ndarray:
    parts = [np.linspace(a, b, 1 + int(np.ceil((b - a) / step))) for a, b in pairwise(marks)]
    return np.unique(np.concatenate(parts))


def test_rectangle_against_finite_elements() -> None:
    ys, zs = np.linspace(0.0, 0.5, 25), np.linspace(0.0, 0.8, 33)
    assert pytest.approx(prandtl(ys, zs, lambda y, z: y > -1), rel=1e-5) == Rectangle(y=1.0, z=1.6).J


@pytest.mark.parametrize(("web", "tolerance"), [(0.3, 5e-3), (0.66, 5e-3), (1.0, 5e-3), (1.5, 5e-3), (2.0, 2.5e-2)])
def test_i_section_against_finite_elements(web: float, tolerance: float) -> None:
    """The tolerances that the docstring states."""
    h, b, tf = 20.0, 12.0, 1.0
    step = min(web, tf) / 6.0
    ys, zs = graded(0.0, web / 2, b / 2, step=step), graded(0.0, h / 2 - tf, h / 2, step=step)
    J = prandtl(ys, zs, lambda y, z: (y < web / 2) | (z > h / 2 - tf))
    assert pytest.approx(J, rel=tolerance) == ISection(height=h, width=b, web=web, flange=tf).J


def test_a_long_strip() -> None:
    """J -> b a^3 / 3 (1 - 0.630 a / b) (Timoshenko & Goodier, art. 109)."""
    strip = Rectangle(y=1.0, z=1e6)
    assert pytest.approx(1e6 / 3 * (1 - 0.63025 * 1e-6), rel=1e-11) == strip.J
