"""Euler loads: Timoshenko and Gere, Theory of Elastic Stability, 2nd ed., articles 2.1 to 2.3.

Cubic elements give a critical load too high by an error that falls as n^-4 (observed between 4 and 8 elements).
"""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose

LENGTH = 2.5
STEEL = Material(E=200e9, nu=0.3)
COLUMN = Section(A=2e-3, Iy=8e-7, Iz=3e-7, J=5e-7)
# The fixed-pinned column: tan x = x, P = 2.0457 pi^2 EI/L^2.
TANGENT = float(mpmath.findroot(lambda x: mpmath.sin(x) - x * mpmath.cos(x), 4.49))
CLAMPED, PINNED = ("uy", "rz"), ("uy",)
CASES = {
    "fixed-free": (CLAMPED, (), np.pi / 2),
    "pinned": (PINNED, PINNED, np.pi),
    "fixed-pinned": (CLAMPED, PINNED, TANGENT),
    "fixed": (CLAMPED, CLAMPED, 2 * np.pi),
}


def column(segments: int, left: tuple[str, ...], right: tuple[str, ...], load: float) -> Frame:
    """A column along x that may buckle in the xy plane, pressed by `load` at its right end."""
    frame = Frame()
    for i in range(segments + 1):
        frame.node(f"{i}", (LENGTH * i / segments, 0.0, 0.0))
        frame.fix(f"{i}", "uz", "rx", "ry", *(left if i == 0 else right if i == segments else ()))
        if i:
            frame.add(f"{i}", Beam(COLUMN, STEEL), f"{i - 1}", f"{i}")
    frame.fix("0", "ux")
    frame.load(f"{segments}", fx=-load)
    return frame


@pytest.mark.parametrize("case", CASES)
def test_critical_load(case: str) -> None:
    """P = x^2 EI/L^2, x = pi/2, pi, 4.4934, 2 pi, by eight elements, and the order of the error."""
    left, right, root = CASES[case]
    load = 1234.5
    euler = root**2 * 200e9 * COLUMN.Iz / LENGTH**2 / load
    factors = [float(column(n, left, right, load).buckling(1).factors[0]) for n in (4, 8)]
    assert_allclose(factors[1] * load, euler * load, rtol=3e-3)
    coarse, fine = (factor / euler - 1 for factor in factors)
    assert 0 < fine < coarse < 0.03
    assert abs(np.log2(coarse / fine) - 4.0) < 0.3


def test_the_weaker_plane_and_the_higher_loads() -> None:
    """Free to buckle in both planes, a pinned column gives pi^2 E I/L^2 (1, 8/3, 4) in order: Iz, Iy, Iz again."""
    frame = Frame()
    frame.node("foot", (0.0, 0.0, 0.0))
    frame.node("head", (LENGTH, 0.0, 0.0))
    frame.add("column", Beam(COLUMN, STEEL, segments=16), "foot", "head")
    frame.fix("foot", "ux", "uy", "uz", "rx")
    frame.fix("head", "uy", "uz", "rx")
    euler = np.pi**2 * 200e9 * COLUMN.Iz / LENGTH**2
    frame.load("head", fx=-euler)
    assert_allclose(frame.buckling(3).factors, [1.0, 8 / 3, 4.0], rtol=1e-4)


def test_a_batch_of_loads() -> None:
    """The factor is inversely proportional to the load."""
    loads = np.array([1e3, 2e3, 5e3])
    frame = Frame()
    frame.node("foot", (0.0, 0.0, 0.0))
    frame.node("head", (LENGTH, 0.0, 0.0))
    frame.add("column", Beam(COLUMN, STEEL, segments=4), "foot", "head")
    frame.fix("foot")
    frame.load("head", fx=-loads)
    factors = frame.buckling(1).factors
    assert factors.shape == (3, 1)
    assert_allclose(factors[:, 0] * loads, np.pi**2 * 200e9 * COLUMN.Iz / (4 * LENGTH**2), rtol=1e-4)
