"""Consistent mass: exact rigid motion, exact frequencies in the limit and the rate at which they come."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.elements import Beam, ISection, Material, Rectangle
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.linalg import eigh

Array = NDArray[np.float64]
E, NU, RHO, L = 200e9, 0.3, 7850.0, 1.1
STEEL = Material(E=E, nu=NU, density=RHO)
BAR = Rectangle(y=0.12, z=0.07)
Chain = Callable[[Beam, float, int], tuple[Array, Array, Array]]


@given(y=st.floats(0.01, 0.5), length=st.floats(0.5, 4.0), shear=st.booleans())
def test_rigid_motion_has_the_inertia_of_the_bar(y: float, length: float, shear: bool) -> None:
    """m, m L / 2, m L^2 / 3 + rho I L, and rho (Iy + Iz) L about the axis: the polar moment, not J."""
    bar = Rectangle(y=y, z=0.07)
    M = Beam(bar, STEEL, shear=shear).mass_matrix(length)
    rigid = np.tile(np.eye(6), (2, 1))
    rigid[8, 4], rigid[7, 5] = -length, length
    m = RHO * y * 0.07 * length
    expected = np.diag(
        [m, m, m, m * (y**2 + 0.07**2) / 12, m * (length**2 / 3 + 0.07**2 / 12), m * (length**2 / 3 + y**2 / 12)]
    )
    expected[1, 5] = expected[5, 1] = m * length / 2
    expected[2, 4] = expected[4, 2] = -m * length / 2
    assert_allclose(rigid.T @ M @ rigid, expected, rtol=1e-12, atol=1e-13 * m * (1 + length**2))
    assert np.array_equal(M, M.T)
    assert np.linalg.eigvalsh(M)[0] > 0.0


def test_printed_matrix() -> None:
    """Przemieniecki (1968), ch. 11, without shear: rho A L (13/35 + 6 I / 5 A L^2) and so on, row by row."""
    M = Beam(BAR, STEEL).mass_matrix(L)
    m = RHO * BAR.A * L
    for (v1, r1, v2, r2), sign, inertia in (((1, 5, 7, 11), 1, BAR.Iz), ((2, 4, 8, 10), -1, BAR.Iy)):
        i = inertia / (BAR.A * L**2)
        expected = [
            [13 / 35 + 6 * i / 5, sign * (11 / 210 + i / 10) * L, 9 / 70 - 6 * i / 5, sign * (i / 10 - 13 / 420) * L],
            [
                sign * (11 / 210 + i / 10) * L,
                (1 / 105 + 2 * i / 15) * L**2,
                sign * (13 / 420 - i / 10) * L,
                -(1 / 140 + i / 30) * L**2,
            ],
        ]
        assert_allclose(M[np.ix_((v1, r1), (v1, r1, v2, r2))], m * np.array(expected), rtol=1e-13)
    assert_allclose(M[np.ix_((0, 6), (0, 6))], m * np.array([[2, 1], [1, 2]]) / 6, rtol=1e-14)
    polar = RHO * (BAR.Iy + BAR.Iz) * L
    assert_allclose(M[np.ix_((3, 9), (3, 9))], polar * np.array([[2, 1], [1, 2]]) / 6, rtol=1e-14)


def frequency(shear: bool) -> float:
    """First root of a simply supported beam with rotary inertia, v = sin(k x) and r = cos(k x): det(K - w^2 M) = 0.

    Timoshenko, Young & Weaver, Vibration Problems in Engineering, 4th ed., ch. 5.
    """
    k, A, inertia = np.pi / L, BAR.A, BAR.Iz
    if not shear:
        return float(np.sqrt(E * inertia * k**4 / (RHO * A + RHO * inertia * k**2)))
    rigidity = 5 / 6 * STEEL.G * A
    # (kGA k^2 - rho A s) (E I k^2 + kGA - rho I s) - (kGA k)^2 = 0
    a, b = RHO * A * RHO * inertia, -(RHO * A * (E * inertia * k**2 + rigidity) + RHO * inertia * rigidity * k**2)
    c = rigidity * k**2 * E * inertia * k**2
    return float(np.sqrt(2 * c / (-b + np.sqrt(b**2 - 4 * a * c))))


def supported(count: int) -> Array:
    """Degrees of freedom uy and rz of a simply supported chain, in its own plane."""
    kept = np.sort(np.concatenate([np.arange(6 * (count + 1))[1::6], np.arange(6 * (count + 1))[5::6]]))
    return np.setdiff1d(kept, [1, 6 * count + 1])


@pytest.mark.parametrize(("shear", "rate"), [(False, 4.0), (True, 2.0)], ids=["rayleigh", "timoshenko"])
def test_frequency_of_a_simply_supported_beam(chain: Chain, shear: bool, rate: float) -> None:
    """Errors fall with the fourth power of the element's length; with shear, constant in it, with the second."""
    errors = []
    for count in (8, 16):
        K, M, _ = chain(Beam(BAR, STEEL, shear=shear), L, count)
        kept = np.ix_(supported(count), supported(count))
        lowest = eigh(K[kept], M[kept], eigvals_only=True, subset_by_index=(0, 0))[0]
        errors.append(np.sqrt(lowest) / frequency(shear) - 1)
    assert 0.0 < errors[-1] < 1e-4
    assert np.log2(errors[0] / errors[1]) == pytest.approx(rate, abs=0.1)


def test_torsion_bar(chain: Chain) -> None:
    """Clamped and free: w = pi / 2L sqrt(G J / rho Ip) (Rao, Mechanical Vibrations, 5th ed., art. 8.4)."""
    section = ISection(height=0.2, width=0.1, web=0.006, flange=0.009)
    exact = np.pi / (2 * L) * np.sqrt(STEEL.G * section.J / (RHO * (section.Iy + section.Iz)))
    errors = []
    for count in (4, 8, 16):
        K, M, _ = chain(Beam(section, STEEL), L, count)
        kept = np.ix_(*[np.arange(9, 6 * (count + 1), 6)] * 2)
        errors.append(np.sqrt(eigh(K[kept], M[kept], eigvals_only=True)[0]) / exact - 1)
    assert_allclose(np.log2(np.array(errors[:-1]) / errors[1:]), 2.0, atol=0.02)


def test_wedge(chain: Chain) -> None:
    """Cantilever of constant width, its depth falling to a point: w = 5.315 sqrt(E I0 / (rho A0 L^4)) (Kirchhoff 1879).

    Timoshenko, Young & Weaver, 4th ed., ch. 5. This wedge ends at a thousandth of its depth, 0.2 per cent short.
    """
    deep, count = 0.01, 16
    beam = Beam(Rectangle(y=deep, z=0.02), STEEL, end=Rectangle(y=deep / 1000, z=0.02))
    K, M, _ = chain(beam, L, count)
    kept = np.ix_(*[[*np.setdiff1d(supported(count), [5]), 6 * count + 1]] * 2)
    lowest = np.sqrt(eigh(K[kept], M[kept], eigvals_only=True)[0])
    assert lowest / np.sqrt(E * deep**2 / 12 / (RHO * L**4)) == pytest.approx(5.315, rel=3e-3)
