"""Tapered cantilevers: Gere and Goodno, Mechanics of Materials, examples 2-4 and 3-5, and logarithms by hand.

With h the depth, c = L/(h0 - h1) and dx = -c dh, the tip deflection is an elementary integral over h. One element
integrates the section's flexibility to rounding: 1e-12.
"""

from __future__ import annotations

from math import log, pi

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import Frame
from numpy.polynomial import Polynomial
from numpy.testing import assert_allclose

NODES, WEIGHTS = np.polynomial.legendre.leggauss(40)
LENGTH, E, NU = 1.8, 110e9, 0.34
G = E / (2 * (1 + NU))
LOAD = {"fx": 300.0, "fy": 20.0, "mx": 7.0}


def cantilever(beam: Beam) -> Frame:
    """The wall at the thick end."""
    frame = Frame()
    frame.node("wall", (0.0, 0.0, 0.0))
    frame.node("tip", (LENGTH, 0.0, 0.0))
    frame.add("beam", beam, "wall", "tip")
    frame.fix("wall")
    frame.load("tip", **LOAD)
    return frame


@pytest.mark.parametrize("segments", [1, 3])
def test_wedge(segments: int) -> None:
    """Depth h0 to h1, width b, s = h1/h0: axial -c ln s/(E b), bending 12 c^3 (-ln s - 3/2 + 2 s - s^2/2)/(E b)."""
    h0, h1, b = 0.06, 0.024, 0.03
    beam = Beam(Rectangle(y=h0, z=b), Material(E=E, nu=NU), end=Rectangle(y=h1, z=b), segments=segments)
    tip = cantilever(beam).solve().displacement("tip")
    c, s = LENGTH / (h0 - h1), h1 / h0
    assert_allclose(tip[0], LOAD["fx"] * c * log(h0 / h1) / (E * b), rtol=1e-12)
    bend = 12 * c**3 * (log(h0 / h1) - 1.5 + 2 * s - s**2 / 2) / (E * b)
    assert_allclose(tip[1], LOAD["fy"] * bend, rtol=1e-12)
    turn = 12 * c**2 * (1 / h1 - 2 / h0 + h1 / h0**2) / (2 * E * b)
    assert_allclose(tip[5], LOAD["fy"] * turn, rtol=1e-12)


@pytest.mark.parametrize("segments", [1, 3])
def test_cone(segments: int) -> None:
    """Examples 2-4, 4 F L/(pi E d0 d1), and 3-5, 32 T L (1/d1^3 - 1/d0^3)/(3 pi G (d0 - d1)).

    Bending by hand: the integral of (d - d1)^2/d^4 from d1 to d0 is 1/(3 d1) - 1/d0 + d1/d0^2 - d1^2/(3 d0^3).
    """
    d0, d1 = 0.05, 0.02
    beam = Beam(Circle(0.05), Material(E=E, nu=NU), end=Circle(0.02), segments=segments)
    tip = cantilever(beam).solve().displacement("tip")
    c = LENGTH / (d0 - d1)
    assert_allclose(tip[0], 4 * LOAD["fx"] * LENGTH / (pi * E * d0 * d1), rtol=1e-12)
    assert_allclose(tip[3], 32 * LOAD["mx"] * c * (1 / d1**3 - 1 / d0**3) / (3 * pi * G), rtol=1e-12)
    bend = 1 / (3 * d1) - 1 / d0 + d1 / d0**2 - d1**2 / (3 * d0**3)
    assert_allclose(tip[1], LOAD["fy"] * 64 * c**3 * bend / (pi * E), rtol=1e-12)


@pytest.mark.parametrize("segments", [1, 4])
@pytest.mark.parametrize("ratio", [0.4, 2.5, 0.1])
@pytest.mark.parametrize("load", ["line", "weight"])
def test_clamped_taper_under_a_load_along_it(load: str, ratio: float, segments: int) -> None:
    """Force method: the far end's shear V and moment M make its deflection and slope vanish.

    With M(x) = M + V (L-x) + m(x), m'' = q and m(L) = m'(L) = 0, the integrals of M(x)/EI and M(x) (L-x)/EI are zero,
    and the deflection at a is the integral of M(x) (a-x)/EI up to a; by quadrature.
    """
    y, z, line, at = 0.06, 0.03, -50.0, 0.7
    size = Polynomial([1.0, (ratio - 1.0) / LENGTH])
    pull = (Polynomial([line]) if load == "line" else 7800.0 * line * y * z * size**2).integ(2, lbnd=LENGTH)

    def integral(moment: Polynomial, end: float = LENGTH) -> float:
        x = end * (0.5 * NODES + 0.5 + np.arange(8)[:, None]) / 8  # in eight pieces
        return float(np.sum(WEIGHTS * moment(x) / size(x) ** 4) * end / (16 * E * z * y**3 / 12))

    arm, one = Polynomial([LENGTH, -1.0]), Polynomial([1.0])
    matrix = [[integral(arm * a), integral(one * a)] for a in (one, arm)]
    shear, couple = np.linalg.solve(matrix, [-integral(pull * a) for a in (one, arm)])
    moment = couple * one + shear * arm + pull
    sag = integral(moment * Polynomial([at, -1.0]), at)

    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    frame.node("1", (LENGTH, 0.0, 0.0))
    thick, thin = Rectangle(y=y, z=z), Rectangle(y=y * ratio, z=z * ratio)
    frame.add("beam", Beam(thick, Material(E=E, nu=NU, density=7800.0), end=thin, segments=segments), "0", "1")
    if load == "line":
        frame.line_load("beam", fy=line)
    else:
        frame.gravity((0.0, line, 0.0))
    frame.fix("0")
    frame.fix("1")
    solution = frame.solve()
    assert_allclose(solution.reaction("1")[[1, 5]], [shear, couple], rtol=1e-10)
    assert_allclose(solution.forces("beam", np.array([0.0, at]))[:, 5], moment(np.array([0.0, at])), rtol=1e-10)
    assert_allclose(solution.displacement_along("beam", np.array([at]))[0, 1], sag, rtol=1e-10)
