"""Single-span beams of Roark's Formulas for Stress and Strain, 7th ed., table 8.1 (p. 189 ff.).

Every case is in closed form, and the cubic beam with exact load vectors reproduces it at any distance: tolerance 1e-12
of the greatest value, which leaves the rounding of a few dozen operations. Two members make the
beam, so that loads cross a node; spans of loads do not end at it.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose
from numpy.typing import NDArray

Array = NDArray[np.float64]

LENGTH, CUT = 2.0, 0.75
STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=0.04, z=0.02)
EI = 200e9 * 0.02 * 0.04**3 / 12
ENDS = {
    "clamped": ("ux", "uy", "uz", "rx", "ry", "rz"),
    "pinned": ("ux", "uy", "uz", "rx", "ry"),
    "free": (),
}
STATIONS = np.linspace(0.0, LENGTH, 17)


def beam(left: str, right: str) -> Frame:
    """A beam in two members along x."""
    frame = Frame()
    for name, x in {"left": 0.0, "cut": CUT, "right": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("I", Beam(BAR, STEEL), "left", "cut")
    frame.add("II", Beam(BAR, STEEL), "cut", "right")
    for node, kind in (("left", left), ("right", right)):
        if ENDS[kind]:
            frame.fix(node, *ENDS[kind])
    return frame


def partial_load(frame: Frame, a: float, b: float, start: float, end: float) -> None:
    """Linear load from `start` at a to `end` at b, cut at the node between the members."""
    at_cut = start + (end - start) * (CUT - a) / (b - a)
    if a < CUT:
        frame.line_load("I", fy=(start, at_cut if b > CUT else end), span=(a, min(b, CUT)))
    if b > CUT:
        frame.line_load("II", fy=(at_cut if a < CUT else start, end), span=(max(a - CUT, 0.0), b - CUT))


def along(frame: Frame, what: str) -> Array:
    """Values at the stations, (k, 6); the first member gives those up to the cut."""
    solution = frame.solve()
    reader = solution.displacement_along if what == "displacement" else solution.forces
    return np.concatenate(
        [reader("I", STATIONS[STATIONS <= CUT]), reader("II", STATIONS[STATIONS > CUT] - CUT)], axis=0
    )


def bracket(x: Array, power: int) -> Array:
    """Macaulay's <x>^power."""
    return np.where(x > 0, np.abs(x) ** power, 0.0)


def deflection(ra: float, ma: float, slope: float, load: Array) -> Array:
    """y = slope x + Ma x^2/2EI + Ra x^3/6EI + load terms (table 8.1, general equation)."""
    x = STATIONS
    return slope * x + ma * x**2 / (2 * EI) + ra * x**3 / (6 * EI) + load


def partial_terms(a: float, b: float, wa: float, wb: float, x: Array) -> tuple[Array, Array, Array, Array]:
    """Shear, moment, slope and deflection (times EI) of a linear load over a..b, acting towards +y, by Macaulay.

    The load that starts at a and never ends, less that which starts at b.
    """
    rate = (wb - wa) / (b - a)
    out = []
    for order in (1, 2, 3, 4):
        factorial = float(np.prod(np.arange(1, order + 1)))
        start = wa * bracket(x - a, order) / factorial + rate * bracket(x - a, order + 1) / (factorial * (order + 1))
        stop = wb * bracket(x - b, order) / factorial + rate * bracket(x - b, order + 1) / (factorial * (order + 1))
        out.append(start - stop)
    return out[0], out[1], out[2], out[3]


def fixed_ends(shear: float, moment: float, slope: float, sag: float) -> tuple[float, float]:
    """Ra and Ma of a clamped beam, from EI slope and EI deflection that the load alone gives the far end."""
    # slope: Ma L + Ra L^2/2 + slope = 0; deflection: Ma L^2/2 + Ra L^3/6 + sag = 0
    matrix = np.array([[LENGTH, LENGTH**2 / 2], [LENGTH**2 / 2, LENGTH**3 / 6]])
    ma, ra = np.linalg.solve(matrix, [-slope, -sag])
    return float(ra), float(ma)


@pytest.mark.parametrize("a", [0.5, CUT, 1.375])
def test_point_load_between_clamped_ends(a: float) -> None:
    """Case 1d: Ra = W (L-a)^2 (L+2a)/L^3, Ma = -W a (L-a)^2/L^2; deflection and moment along the beam."""
    force = 1000.0
    frame = beam("clamped", "clamped")
    frame.point_load(*(("I",) if a < CUT else ("II",)), at=a if a < CUT else a - CUT, fy=-force)
    b = LENGTH - a
    ra, ma = force * b**2 * (LENGTH + 2 * a) / LENGTH**3, -force * a * b**2 / LENGTH**2
    assert_allclose(frame.solve().reaction("left")[[1, 5]], [ra, -ma], rtol=1e-12)
    expected = deflection(ra, ma, 0.0, -force * bracket(STATIONS - a, 3) / (6 * EI))
    assert_allclose(along(frame, "displacement")[:, 1], expected, rtol=0, atol=1e-12 * np.abs(expected).max())
    moment = ma + ra * STATIONS - force * bracket(STATIONS - a, 1)
    assert_allclose(along(frame, "forces")[:, 5], moment, rtol=0, atol=1e-12 * np.abs(moment).max())


@pytest.mark.parametrize(
    ("a", "b", "wa", "wb"),
    [
        pytest.param(0.0, LENGTH, -500.0, -500.0, id="uniform"),
        pytest.param(0.0, LENGTH, 0.0, -800.0, id="triangle"),
        pytest.param(0.25, 1.5, -300.0, -300.0, id="part"),
        pytest.param(0.125, 0.625, -300.0, 700.0, id="part of the first member, changing sign"),
        pytest.param(0.5, 1.875, -900.0, -100.0, id="trapezium"),
    ],
)
def test_line_load_between_clamped_ends(a: float, b: float, wa: float, wb: float) -> None:
    """Case 2d, and its table of uniform and triangular loads: Ma = -w L^2/12; -w L^2/30 and -w L^2/20."""
    frame = beam("clamped", "clamped")
    partial_load(frame, a, b, wa, wb)
    shear, moment, _, sag = partial_terms(a, b, wa, wb, STATIONS)
    far = [float(term[0]) for term in partial_terms(a, b, wa, wb, np.array([LENGTH]))]
    ra, ma = fixed_ends(*far)
    if wa == wb and b - a == LENGTH:
        assert_allclose([ra, ma], [-wa * LENGTH / 2, wa * LENGTH**2 / 12], rtol=1e-13)
    if wa == 0.0:
        assert_allclose([ra, ma], [-3 * wb * LENGTH / 20, wb * LENGTH**2 / 30], rtol=1e-13)
    solution = frame.solve()
    assert_allclose(solution.reaction("left")[[1, 5]], [ra, -ma], rtol=1e-12)
    for got, expected in (
        (along(frame, "displacement")[:, 1], deflection(ra, ma, 0.0, sag / EI)),
        (along(frame, "forces")[:, 5], ma + ra * STATIONS + moment),
        (along(frame, "forces")[:, 1], -(ra + shear)),
    ):
        assert_allclose(got, expected, rtol=0, atol=1e-12 * np.abs(expected).max())


def test_couple_between_clamped_ends() -> None:
    """Case 3d: Ra = -6 M a (L-a)/L^3, Ma = -M (L^2 - 4 a L + 3 a^2)/L^2 (M turning as Ma does)."""
    couple, a = 120.0, 1.25
    frame = beam("clamped", "clamped")
    frame.point_load("II", at=a - CUT, mz=couple)
    left = frame.solve().reaction("left")
    assert_allclose(left[1], 6 * couple * a * (LENGTH - a) / LENGTH**3, rtol=1e-12)
    assert_allclose(left[5], -couple * (LENGTH**2 - 4 * a * LENGTH + 3 * a**2) / LENGTH**2, rtol=1e-12)


def test_propped_cantilever() -> None:
    """Cases 1c and 2c, clamped on the right: prop W (L-a)^2 (2L+a)/(2 L^3), prop 3 w L/8; slopes at the prop."""
    force, line, a = 700.0, 300.0, 1.0
    b = LENGTH - a
    frame = beam("pinned", "clamped")
    frame.point_load("II", at=a - CUT, fy=[-force, 0.0])
    for member in ("I", "II"):
        frame.line_load(member, fy=[0.0, -line])
    solution = frame.solve()
    prop = [force * b**2 * (2 * LENGTH + a) / (2 * LENGTH**3), 3 * line * LENGTH / 8]
    slope = [-force * a * b**2 / (4 * EI * LENGTH), -line * LENGTH**3 / (48 * EI)]
    assert_allclose(solution.reaction("left")[:, 1], prop, rtol=1e-12)
    assert_allclose(solution.displacement("left")[:, 5], slope, rtol=1e-12)
    wall = [-force * a * (LENGTH**2 - a**2) / (2 * LENGTH**2), -line * LENGTH**2 / 8]
    assert_allclose(solution.reaction("right")[:, 5], wall, rtol=1e-12)


def test_simply_supported() -> None:
    """Case 2e: -5 w L^4/(384 EI) in the middle, -w L^3/(24 EI) at the end; no moment at the ends."""
    line = 300.0
    frame = beam("pinned", "pinned")
    for member in ("I", "II"):
        frame.line_load(member, fy=-line)
    solution = frame.solve()
    middle = solution.displacement_along("II", np.array([LENGTH / 2 - CUT]))[0, 1]
    assert_allclose(middle, -5 * line * LENGTH**4 / (384 * EI), rtol=1e-12)
    assert_allclose(solution.displacement("left")[5], -line * LENGTH**3 / (24 * EI), rtol=1e-12)
    assert_allclose(solution.forces("II", np.array([LENGTH / 2 - CUT]))[0, 5], line * LENGTH**2 / 8, rtol=1e-12)
    assert_allclose(solution.end_forces("I")[5], 0.0, atol=1e-11 * line * LENGTH**2)


def test_cantilever_in_six_loads() -> None:
    """Case 1a and elementary bars: FL/EA, FL^3/3EI, TL/GJ, ML^2/2EI, and the slopes; all six loads as one batch."""
    section = Section(A=8e-4, Iy=2.6e-8, Iz=1.1e-7, J=7e-8)
    E, G = 200e9, 200e9 / 2.6
    frame = Frame()
    frame.node("wall", (0.3, -0.2, 0.5))
    frame.node("tip", (0.3 + LENGTH, -0.2, 0.5))
    frame.add("beam", Beam(section, Material(E=E, nu=0.3)), "wall", "tip")
    frame.fix("wall")
    size = 250.0
    frame.load("tip", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), size * np.eye(6), strict=True)))
    y, z = E * section.Iz, E * section.Iy
    flexibility = np.diag(
        [
            LENGTH / (E * section.A),
            LENGTH**3 / (3 * y),
            LENGTH**3 / (3 * z),
            LENGTH / (G * section.J),
            LENGTH / z,
            LENGTH / y,
        ]
    )
    flexibility[1, 5] = flexibility[5, 1] = LENGTH**2 / (2 * y)
    flexibility[2, 4] = flexibility[4, 2] = -(LENGTH**2) / (2 * z)
    solution = frame.solve()
    assert_allclose(solution.displacement("tip"), size * flexibility, rtol=1e-13, atol=1e-25)
    wall = -size * np.eye(6)
    wall[1, 5], wall[2, 4] = -size * LENGTH, size * LENGTH
    assert_allclose(solution.reaction("wall"), wall, rtol=1e-12, atol=1e-10)


def test_internal_forces_of_a_cantilever_in_six_loads() -> None:
    """N Vy Vz T My Mz: force and moment of the far part on the near part, at any station.

    With the tip loaded by F and M, the part beyond x carries F and M + (L - x) e_x x F.
    """
    frame = Frame()
    frame.node("wall", (0.0, 0.0, 0.0))
    frame.node("tip", (LENGTH, 0.0, 0.0))
    frame.add("beam", Beam(BAR, STEEL, segments=3), "wall", "tip")
    frame.fix("wall")
    load = np.array([10.0, 20.0, -30.0, 4.0, -5.0, 6.0])
    frame.load("tip", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), load, strict=True)))
    expected = np.tile(load, (len(STATIONS), 1))
    arm = np.stack([LENGTH - STATIONS, 0 * STATIONS, 0 * STATIONS], axis=-1)
    expected[:, 3:] += np.cross(arm, load[:3])
    assert_allclose(frame.solve().forces("beam", STATIONS), expected, rtol=1e-11, atol=1e-9)
