"""Natural frequencies of uniform beams: Blevins, Formulas for Natural Frequency and Mode Shape, tables 8-1 and 8-16.

A mesh of n cubic elements with consistent mass gives each frequency too high by an error that falls as n^-4, one
of linear elements (rods) as n^-2. Slender beams: rotary inertia, which Blevins leaves out, would lower a frequency by
about (beta L)^2 r^2/(2 L^2); the sections make that smaller than the tolerance by two orders.
"""

from __future__ import annotations

from itertools import pairwise

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH = 3.0
STEEL = Material(E=210e9, nu=0.3, density=7800.0)
# Radii of gyration of 1e-5 m: thinner than any wire, so that rotary inertia is below 1e-9.
WIRE = Section(A=1e-4, Iy=1e-14, Iz=1e-14, J=1e-14)
PLANE = ("uz", "rx", "ry")


def planar(segments: int, left: tuple[str, ...], right: tuple[str, ...], section: Section = WIRE) -> Frame:
    """A beam of equal elements, each node held in the xy plane and along x."""
    frame = Frame()
    for i in range(segments + 1):
        frame.node(f"{i}", (LENGTH * i / segments, 0.0, 0.0))
        frame.fix(f"{i}", "ux", *PLANE, *(left if i == 0 else right if i == segments else ()))
        if i:
            frame.add(f"{i}", Beam(section, STEEL), f"{i - 1}", f"{i}")
    return frame


def wave_numbers(frequencies: Array, section: Section = WIRE) -> Array:
    """beta L of bending frequencies in Hz."""
    omega = 2 * np.pi * frequencies
    beta: Array = np.sqrt(omega * np.sqrt(STEEL.density * section.A / (STEEL.E * section.Iz)))
    return beta * LENGTH


def roots(sign: int, count: int) -> Array:
    """Roots of cos x cosh x + sign = 0 beyond zero."""
    start = [(i + 0.5) * np.pi if sign == 1 else (i + 1.5) * np.pi for i in range(count)]
    return np.array([float(mpmath.findroot(lambda x: mpmath.cos(x) + sign / mpmath.cosh(x), x0)) for x0 in start])


CLAMPED, PINNED, FREE = ("uy", "rz"), ("uy",), ()
CASES = {
    "cantilever": (CLAMPED, FREE, 0, roots(1, 3)),
    "clamped": (CLAMPED, CLAMPED, 0, roots(-1, 3)),
    "simply supported": (PINNED, PINNED, 0, np.pi * np.arange(1, 4)),
    "free": (FREE, FREE, 2, roots(-1, 3)),
}


def test_first_root_of_the_cantilever() -> None:
    """The well-known 1.87510406871196, 4.69409113297417, 7.85475743823761 and 4.73004074486270."""
    assert_allclose(roots(1, 3), [1.87510406871196, 4.69409113297417, 7.85475743823761], rtol=1e-14)
    assert_allclose(roots(-1, 1), [4.73004074486270], rtol=1e-14)


@pytest.mark.parametrize("case", CASES)
def test_bending(case: str) -> None:
    """Three squared frequencies to 1e-4 with 24 elements, and the error falls as n^-4 (observed from 12)."""
    left, right, rigid, exact = CASES[case]
    errors = []
    for segments in (12, 24):
        frequencies = planar(segments, left, right).modes(3 + rigid).frequencies
        assert_allclose(frequencies[:rigid], 0.0, atol=1e-4 * frequencies[-1])
        errors.append((wave_numbers(frequencies[rigid:]) / exact) ** 2 - 1)
    coarse, fine = np.array(errors)
    assert np.all(fine > 0)
    assert np.all(fine < 1e-4)
    assert_allclose(np.log2(coarse / fine), 4.0, atol=0.12)


def test_segments_refine_as_nodes_do() -> None:
    """One member with segments=8 has the frequencies of eight members, and in the stiffer plane twice those."""
    section = Section(A=1e-4, Iy=4e-10, Iz=1e-10, J=1e-10)
    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    frame.node("1", (LENGTH, 0.0, 0.0))
    frame.add("beam", Beam(section, STEEL, segments=8), "0", "1")
    frame.fix("0")
    weak, stiff, second = frame.modes(3).frequencies
    first, third = planar(8, CLAMPED, FREE, section).modes(2).frequencies
    assert_allclose([weak, second], [first, third], rtol=1e-9)
    # The stiffer plane's rotary inertia, r^2 = 4e-6 m2, takes (beta L)^2 r^2/L^2 = 1e-6.
    assert_allclose(stiff, 2 * weak, rtol=5e-6)


@pytest.mark.parametrize("wave", ["axial", "torsion"])
def test_rods(wave: str) -> None:
    """Clamped-free rod: f = (2i-1) c/(4L), c^2 = E/rho along, G J/(rho (Iy+Iz)) in torsion (not G/rho: J is not Ip).

    Linear elements with consistent mass: (omega h/c)^2 = 6 (1 - cos kh)/(2 + cos kh), known in closed form.
    """
    section = Section(A=1e-4, Iy=5e-10, Iz=8e-10, J=4e-10)
    stiffness, inertia = (STEEL.E * 1e-4, 1e-4) if wave == "axial" else (STEEL.G * 4e-10, 13e-10)
    c = np.sqrt(stiffness / (STEEL.density * inertia))
    segments = 10
    frame = Frame()
    for i in range(segments + 1):
        frame.node(f"{i}", (LENGTH * i / segments, 0.0, 0.0))
        frame.fix(f"{i}", "uy", "uz", "ry", "rz", "rx" if wave == "axial" else "ux")
        if i:
            frame.add(f"{i}", Beam(section, STEEL), f"{i - 1}", f"{i}")
    frame.fix("0")
    order = 2 * np.arange(1, 4) - 1
    kh = order * np.pi / (2 * segments)
    discrete = np.sqrt(6 * (1 - np.cos(kh)) / (2 + np.cos(kh))) * c * segments / LENGTH / (2 * np.pi)
    frequencies = frame.modes(3).frequencies
    assert_allclose(frequencies, discrete, rtol=1e-10)
    assert_allclose(frequencies, order * c / (4 * LENGTH), rtol=0.03)


def test_two_storey_frame() -> None:
    """Piranda's two-storey plane frame: VPCS guide, test SDLX 01/89, computed there by the dynamic stiffness method.

    Bars 29 mm x 4.8 mm bending over the thin side, E = 2.1e11 Pa, rho = 7850 kg/m3, storeys of 0.36 m and 0.45 m, 0.6 m
    wide. The guide states an uncertainty of 0.5 %; the printed digits alone leave 0.06 %, eight elements a bar 0.04 %.
    """
    steel = Material(E=2.1e11, nu=0.3, density=7850.0)
    b, h = 29.0e-3, 4.8e-3
    bar = Beam(Section(A=b * h, Iy=h * b**3 / 12, Iz=b * h**3 / 12, J=3e-9), steel)
    corners = {
        f"{side}{level}": (x, y) for side, x in (("l", 0), ("r", 0.6)) for level, y in enumerate((0, 0.36, 0.81))
    }
    bars = [("l0", "l1"), ("l1", "l2"), ("r0", "r1"), ("r1", "r2"), ("l1", "r1"), ("l2", "r2")]
    frame = Frame()

    def place(name: str, x: float, y: float) -> None:
        frame.node(name, (x, y, 0.0))
        frame.fix(name, "uz", "rx", "ry")

    for name, (x, y) in corners.items():
        place(name, x, y)
    for start, end in bars:
        names = [start, *(f"{start}-{end} {i}" for i in range(1, 8)), end]
        places = np.linspace(corners[start], corners[end], 9)
        for name, (x, y) in list(zip(names, places, strict=True))[1:-1]:
            place(name, x, y)
        for one, other in pairwise(names):
            frame.add(f"{one}:{other}", bar, one, other)
    frame.fix("l0")
    frame.fix("r0")
    published = [8.75, 29.34, 43.71, 56.12, 95.86, 102.37, 146.64, 174.39, 178.36]
    assert_allclose(frame.modes(9).frequencies, published, rtol=1e-3)
