"""Tapered cantilevers: Gere and Goodno, Mechanics of Materials, examples 2-4 and 3-5, and logarithms by hand.

With h the depth, c = L/(h0 - h1) and dx = -c dh, the tip deflection is an elementary integral over h. One element
integrates the section's flexibility to rounding: 1e-12.
"""

from __future__ import annotations

from math import log, pi

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

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
def test_clamped_taper_under_a_uniform_load(segments: int) -> None:
    """Force method: the far end's shear V and moment M make its deflection and slope vanish.

    With M(x) = M + V (L-x) + w (L-x)^2/2, the integrals of M(x)/EI and of M(x) (L-x)/EI are zero; by quadrature.
    """
    thick, thin, line = Rectangle(y=0.06, z=0.03), Rectangle(y=0.024, z=0.02), -50.0

    def integral(power: int) -> float:
        def density(x: float) -> mpmath.mpf:
            y, z = 0.06 - 0.036 * x / LENGTH, 0.03 - 0.01 * x / LENGTH
            return (LENGTH - x) ** power / (E * z * y**3 / 12)

        return float(mpmath.quad(density, mpmath.linspace(0, LENGTH, 5)))

    i0, i1, i2, i3 = (integral(power) for power in range(4))
    shear, moment = np.linalg.solve([[i1, i0], [i2, i1]], [-line * i2 / 2, -line * i3 / 2])
    frame = Frame()
    frame.node("0", (0.0, 0.0, 0.0))
    frame.node("1", (LENGTH, 0.0, 0.0))
    frame.add("beam", Beam(thick, Material(E=E, nu=NU), end=thin, segments=segments), "0", "1")
    frame.line_load("beam", fy=line)
    frame.fix("0")
    frame.fix("1")
    solution = frame.solve()
    assert_allclose(solution.reaction("1")[[1, 5]], [shear, moment], rtol=1e-10)
    near = moment + shear * LENGTH + line * LENGTH**2 / 2
    assert_allclose(solution.forces("beam", np.array([0.0, LENGTH]))[:, 5], [near, moment], rtol=1e-10)
