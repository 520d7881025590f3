"""Timoshenko beams: Huang, J. Appl. Mech. 28 (1961) 579-584, the frequency equation of the cantilever."""

from __future__ import annotations

import mpmath
import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH = 1.0
ALLOY = Material(E=70e9, nu=0.3, density=2700.0)
# 0.1 m wide and 0.2 m deep: r/L = 0.058, where the slender beam is wrong by 2 % to 40 %.
DEEP = Section(A=0.02, Iy=0.2 * 0.1**3 / 12, Iz=0.1 * 0.2**3 / 12, J=4.6e-5, ky=5 / 6, kz=5 / 6)


def huang(b: mpmath.mpf) -> mpmath.mpf:
    """Huang's equation for the clamped-free beam, zero at b = omega L^2 sqrt(rho A/EI).

    2 + (b^2 (r^2-s^2)^2 + 2) cosh b alpha cos b beta - b (r^2+s^2)/sqrt(1 - b^2 r^2 s^2) sinh b alpha sin b beta = 0.
    """
    r2 = mpmath.mpf(DEEP.Iz) / DEEP.A / LENGTH**2
    s2 = mpmath.mpf(ALLOY.E) * DEEP.Iz / (mpmath.mpf(5) / 6 * ALLOY.G * DEEP.A * LENGTH**2)
    root = mpmath.sqrt((r2 - s2) ** 2 + 4 / b**2)
    alpha, beta = mpmath.sqrt((root - r2 - s2) / 2), mpmath.sqrt((root + r2 + s2) / 2)
    value = (
        2
        + (b**2 * (r2 - s2) ** 2 + 2) * mpmath.cosh(b * alpha) * mpmath.cos(b * beta)
        - b * (r2 + s2) / mpmath.sqrt(1 - b**2 * r2 * s2) * mpmath.sinh(b * alpha) * mpmath.sin(b * beta)
    )
    return mpmath.re(value)


def frequencies(segments: int) -> Array:
    """Three bending frequencies b of the cantilever in the xy plane."""
    frame = Frame()
    for i in range(segments + 1):
        frame.node(f"{i}", (LENGTH * i / segments, 0.0, 0.0))
        frame.fix(f"{i}", "ux", "uz", "rx", "ry")
        if i:
            frame.add(f"{i}", Beam(DEEP, ALLOY, shear=True), f"{i - 1}", f"{i}")
    frame.fix("0")
    omega = 2 * np.pi * frame.modes(3).frequencies
    factors: Array = omega * LENGTH**2 * np.sqrt(ALLOY.density * DEEP.A / (ALLOY.E * DEEP.Iz))
    return factors


def test_deep_cantilever() -> None:
    """Three frequencies, the error falling as n^-2, so that two meshes extrapolate to 2e-6.

    The element's shear strain is constant, as static equilibrium has it, while the true one varies with the inertia
    forces: what is of fourth order for a slender beam is of second order in the shear. A slender beam's
    3.516 is 3 % off.
    """
    exact = np.array([float(mpmath.findroot(huang, start)) for start in (3.3, 16.4, 37.0)])
    assert exact[0] < 3.516 * 0.98
    assert np.all(np.diff(exact) > 5)
    coarse, fine = frequencies(32) ** 2, frequencies(64) ** 2
    assert_allclose(np.log2((coarse / exact**2 - 1) / (fine / exact**2 - 1)), 2.0, atol=0.1)
    assert np.all(np.abs(fine / exact**2 - 1) < [4e-6, 1e-4, 5e-4])
    assert_allclose((4 * fine - coarse) / 3, exact**2, rtol=4e-6)
