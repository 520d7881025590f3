"""Logan's space frame."""

from __future__ import annotations

from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose


def test_space_frame() -> None:
    """Logan, A First Course in the Finite Element Method, 4th ed., example 5.8.

    Three members of 100 in along the axes; E = 30000 ksi, G = 10000 ksi, J = 50, Iy = Iz = 100 in4, A = 10 in2;
    -50 kips and -1000 kip in at their common node. Printed as 7.098e-5, -0.014, -2.352e-3 in and -3.996e-3, 1.78e-5,
    -1.033e-4 rad: half a unit of the last printed digit of each.
    """
    beam = Beam(Section(A=10.0, Iy=100.0, Iz=100.0, J=50.0), Material(E=30000.0, G=10000.0))
    frame = Frame()
    frame.node("1", (0.0, 0.0, 0.0))
    for name, place in {"2": (-100.0, 0.0, 0.0), "3": (0.0, 0.0, -100.0), "4": (0.0, -100.0, 0.0)}.items():
        frame.node(name, place)
        frame.add(f"member {name}", beam, name, "1")
        frame.fix(name)
    frame.load("1", fy=-50.0, mx=-1000.0)
    displacement = frame.solve().displacement("1")
    printed = {
        7.098e-5: 0.5e-8,
        -0.014: 0.5e-3,
        -2.352e-3: 0.5e-6,
        -3.996e-3: 0.5e-6,
        1.78e-5: 0.5e-7,
        -1.033e-4: 0.5e-7,
    }
    for value, (digits, unit) in zip(displacement, printed.items(), strict=True):
        assert_allclose(value, digits, rtol=0, atol=unit)
