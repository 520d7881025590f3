"""Geometric stiffness: Euler loads and the rate at which they come, shear, torsional buckling, energy."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.linalg import eigh
from scipy.optimize import brentq

Array = NDArray[np.float64]
E, L = 200e9, 2.0
STEEL = Material(E=E, nu=0.3)
BAR = Rectangle(y=0.12, z=0.07)
EULER = np.pi**2 * E * BAR.Iz / L**2
Chain = Callable[[Beam, float, int], tuple[Array, Array, Array]]
# fixed components of the start and of the end, and the critical load over Euler's (Timoshenko & Gere,
# Theory of Elastic Stability, 2nd ed., ch. 2): the clamped-pinned one from tan(k L) = k L
PROPPED = brentq(lambda t: np.tan(t) - t, 4.4, 4.6) ** 2 / np.pi**2
SUPPORTS = [((1,), (1,), 1.0), ((1, 5), (), 0.25), ((1, 5), (1, 5), 4.0), ((1, 5), (1,), PROPPED)]


def critical(beam: Beam, chain: Chain, count: int, start: tuple[int, ...], end: tuple[int, ...]) -> float:
    """Least critical load in the xy plane."""
    K, _, compressed = chain(beam, L, count)
    plane = np.sort(np.concatenate([np.arange(1, 6 * (count + 1), 6), np.arange(5, 6 * (count + 1), 6)]))
    kept = np.setdiff1d(plane, [*start, *[6 * count + component for component in end]])
    index = np.ix_(kept, kept)
    return float(1 / eigh(-compressed[index], K[index], eigvals_only=True)[-1])


@pytest.mark.parametrize(("start", "end", "factor"), SUPPORTS)
def test_euler(chain: Chain, start: tuple[int, ...], end: tuple[int, ...], factor: float) -> None:
    """Four cases, errors falling with the fourth power of the element's length."""
    errors = np.array([critical(Beam(BAR, STEEL), chain, n, start, end) for n in (4, 8, 16)]) / (factor * EULER) - 1
    assert np.all(errors > 0.0)
    assert errors[-1] < 1e-4
    assert_allclose(np.log2(errors[:-1] / errors[1:]), 4.0, atol=0.15)


def test_shear_lowers_the_load(chain: Chain) -> None:
    """Engesser: P / (1 + P / kGA) (Timoshenko & Gere, art. 2.17, Eq. 2-57).

    The shear force is constant along an element, so that errors are of second order.
    """
    exact = EULER / (1 + EULER / (5 / 6 * STEEL.G * BAR.A))
    errors = np.array([critical(Beam(BAR, STEEL, shear=True), chain, n, (1,), (1,)) for n in (16, 32)]) / exact - 1
    assert 0.0 < errors[-1] < 1e-5
    assert np.log2(errors[0] / errors[1]) == pytest.approx(2.0, abs=0.1)


def test_torsional_buckling(chain: Chain) -> None:
    """G J A / (Iy + Iz), whatever the length (Timoshenko & Gere, art. 5.3, without warping)."""
    K, _, compressed = chain(Beam(BAR, STEEL), L, 3)
    kept = np.ix_(*[np.arange(9, 24, 6)] * 2)
    loads = 1 / eigh(-compressed[kept], K[kept], eigvals_only=True)
    assert_allclose(loads, STEEL.G * BAR.J * BAR.A / (BAR.Iy + BAR.Iz), rtol=1e-12)


def test_printed_matrix() -> None:
    """Przemieniecki (1968), ch. 15: N / L (6/5, L/10, 2 L^2 / 15, -L^2 / 30)."""
    Kg = Beam(BAR, STEEL).geometric_matrix(L, 7.0)
    expected = np.array([
        [6 / 5, L / 10, -6 / 5, L / 10],
        [L / 10, 2 * L**2 / 15, -L / 10, -(L**2) / 30],
        [-6 / 5, -L / 10, 6 / 5, -L / 10],
        [L / 10, -(L**2) / 30, -L / 10, 2 * L**2 / 15],
    ]) * 7.0 / L  # fmt: skip
    turn = np.diag([1.0, -1.0, 1.0, -1.0])
    assert_allclose(Kg[np.ix_((1, 5, 7, 11), (1, 5, 7, 11))], expected, rtol=1e-13)
    assert_allclose(Kg[np.ix_((2, 4, 8, 10), (2, 4, 8, 10))], turn @ expected @ turn, rtol=1e-13)


@pytest.mark.parametrize("shear", [False, True])
@pytest.mark.parametrize("end", [None, Rectangle(y=0.06, z=0.1)], ids=["prismatic", "taper"])
def test_energy_of_the_axial_force(shear: bool, end: Rectangle | None) -> None:
    """u K u = N int uy'^2 + uz'^2 + (Iy + Iz) / A rx'^2 dx, with derivatives by differences."""
    beam = Beam(BAR, STEEL, end=end, shear=shear)
    u = np.random.default_rng(5).normal(size=12)
    x, w = np.polynomial.legendre.leggauss(30)
    x, w = (x + 1) / 2 * L, w / 2 * L
    h = 1e-4
    slope = (beam.shape_functions(L, x + h) - beam.shape_functions(L, x - h)) @ u / (2 * h)
    section = BAR if end is None else BAR.between(end, x / L)
    work = slope[:, 1] ** 2 + slope[:, 2] ** 2 + (section.Iy + section.Iz) / section.A * slope[:, 3] ** 2
    Kg = beam.geometric_matrix(L, -3.0)
    assert np.array_equal(Kg, Kg.T)
    assert u @ Kg @ u == pytest.approx(-3.0 * (w @ work), rel=1e-6)


def test_a_tapered_column(chain: Chain) -> None:
    """Clamped and free, its depth linear: E I y'' + P y = 0 shot from the tip (Timoshenko & Gere, ch. 2)."""
    thick, thin = 0.12, 0.072
    beam = Beam(Rectangle(y=thick, z=0.07), STEEL, end=Rectangle(y=thin, z=0.07))
    found = critical(beam, chain, 8, (1, 5), ())

    def tip_slope(load: float) -> float:
        """y'' = -P y / E I from the free tip (y = 0, y' = 1), by Runge-Kutta: y' at the clamp."""

        def rate(s: float, y: Array) -> Array:
            depth = thin + (thick - thin) * s / L
            return np.array([y[1], -load * y[0] / (E * 0.07 * depth**3 / 12)])

        y, h = np.array([0.0, 1.0]), L / 200
        for step in range(200):
            s = step * h
            a = rate(s, y)
            b = rate(s + h / 2, y + h / 2 * a)
            c = rate(s + h / 2, y + h / 2 * b)
            d = rate(s + h, y + h * c)
            y = y + h / 6 * (a + 2 * b + 2 * c + d)
        return float(y[1])

    assert found == pytest.approx(brentq(tip_slope, 0.02 * EULER, 0.3 * EULER), rel=1e-5)
