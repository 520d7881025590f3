"""Beams that deform in shear: Timoshenko, Strength of Materials I, 3rd ed., article 39; Przemieniecki (1968), table 5.

The element carries the exact solution of the differential equations, so that one element gives the closed form
to rounding.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose

E, G = 70e9, 26e9
DEEP = Section(A=0.02, Iy=1.5e-5, Iz=6.5e-5, J=4e-5, ky=5 / 6, kz=0.7)
LENGTH = 0.5


def deep(shear: bool = True, segments: int = 1) -> Frame:
    """A beam two and a half times as long as deep."""
    frame = Frame()
    frame.node("wall", (0.0, 0.0, 0.0))
    frame.node("tip", (LENGTH, 0.0, 0.0))
    frame.add("beam", Beam(DEEP, Material(E=E, G=G), shear=shear, segments=segments), "wall", "tip")
    frame.fix("wall")
    return frame


@pytest.mark.parametrize("segments", [1, 4])
def test_tip_load(segments: int) -> None:
    """w = F L^3/3EI + F L/kGA in both planes; the section turns by F L^2/2EI only."""
    frame = deep(segments=segments)
    frame.load("tip", fy=1e5, fz=-2e5)
    tip = frame.solve().displacement("tip")
    bending = np.array([1e5 * LENGTH**3 / (3 * E * DEEP.Iz), -2e5 * LENGTH**3 / (3 * E * DEEP.Iy)])
    shear = np.array([1e5 * LENGTH / (5 / 6 * G * DEEP.A), -2e5 * LENGTH / (0.7 * G * DEEP.A)])
    assert_allclose(tip[1:3], bending + shear, rtol=1e-12)
    assert_allclose(tip[4:], [2e5 * LENGTH**2 / (2 * E * DEEP.Iy), 1e5 * LENGTH**2 / (2 * E * DEEP.Iz)], rtol=1e-12)
    assert np.all(np.abs(shear) > 0.03 * np.abs(bending))


def test_without_shear() -> None:
    """The same beam with shear=False keeps F L^3/3EI."""
    frame = deep(shear=False)
    frame.load("tip", fy=1e5)
    assert_allclose(frame.solve().displacement("tip")[1], 1e5 * LENGTH**3 / (3 * E * DEEP.Iz), rtol=1e-12)


def test_uniform_load_along_the_beam() -> None:
    """EI y = w x^2 (6 L^2 - 4 L x + x^2)/24 and shear adds w (2 L x - x^2)/(2 kGA), at any distance in one element."""
    line = -3e5
    frame = deep()
    frame.line_load("beam", fy=line)
    x = np.linspace(0.0, LENGTH, 9)
    bending = line * x**2 * (6 * LENGTH**2 - 4 * LENGTH * x + x**2) / (24 * E * DEEP.Iz)
    shear = line * (2 * LENGTH * x - x**2) / (2 * 5 / 6 * G * DEEP.A)
    got = frame.solve().displacement_along("beam", x)[:, 1]
    assert_allclose(got, bending + shear, rtol=1e-11, atol=1e-20)


def test_far_end_settles() -> None:
    """Both ends clamped, one settling by d: shear 12 EI d/((1 + phi) L^3), moments 6 EI d/((1 + phi) L^2).

    Przemieniecki, table 5.1 (equation 5.116): phi = 12 EI/(kGA L^2).
    """
    frame = deep()
    frame.fix("tip")
    frame.prescribe("tip", uy=-1e-3)
    solution = frame.solve()
    phi = 12 * E * DEEP.Iz / (5 / 6 * G * DEEP.A * LENGTH**2)
    stiffness = E * DEEP.Iz / (1 + phi)
    assert_allclose(
        solution.reaction("wall")[[1, 5]], [12e-3 * stiffness / LENGTH**3, 6e-3 * stiffness / LENGTH**2], rtol=1e-12
    )


def test_fixed_ends_of_a_uniform_load_do_not_depend_on_shear() -> None:
    """By symmetry w L^2/12 with shear and without; the middle sags by w L^4/384EI + w L^2/8kGA."""
    frame = deep()
    frame.fix("tip")
    frame.line_load("beam", fy=-3e5)
    solution = frame.solve()
    assert_allclose(solution.reaction("wall")[5], 3e5 * LENGTH**2 / 12, rtol=1e-12)
    sag = 3e5 * LENGTH**4 / (384 * E * DEEP.Iz) + 3e5 * LENGTH**2 / (8 * 5 / 6 * G * DEEP.A)
    assert_allclose(solution.displacement_along("beam", np.array([LENGTH / 2]))[0, 1], -sag, rtol=1e-12)
