"""McGuire, Gallagher and Ziemian's continuous beam with an inclined load."""

from __future__ import annotations

from math import sqrt

from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose


def test_two_members_in_line() -> None:
    """McGuire, Gallagher, Ziemian, Matrix Structural Analysis, 2nd ed., example 4.8.

    ab: 8 m, A = 6e3 mm2, Iz = 200e6 mm4; bc: 5 m, A = 4e3 mm2, Iz = 50e6 mm4; E = 200 kN/mm2 (units kN, mm). a fixed,
    b on a roller, 5 kN at c at 45 degrees. Printed: u_b = 0.024, theta_b = -0.00088, u_c = 0.046, v_c = -19.15,
    theta_c = -0.00530: half a unit of the last printed digit of each. To all digits by hand:
    u_b = F 8000/(E A), theta_b = -F 5000 8000/(4 E I), with F = 5/sqrt(2).
    """
    steel = Material(E=200.0, nu=0.3)
    frame = Frame()
    for name, x in {"a": 0.0, "b": 8000.0, "c": 13000.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("ab", Beam(Section(A=6e3, Iy=700e6, Iz=200e6, J=300e3), steel), "a", "b")
    frame.add("bc", Beam(Section(A=4e3, Iy=540e6, Iz=50e6, J=100e3), steel), "b", "c")
    frame.fix("a")
    frame.fix("b", "uy", "uz", "rx")
    force = 5.0 / sqrt(2.0)
    frame.load("c", fx=force, fy=-force)
    solution = frame.solve()
    b, c = solution.displacement("b"), solution.displacement("c")
    computed = [*b[[0, 5]], *c[[0, 1, 5]]]
    printed = {0.024: 0.5e-3, -0.00088: 0.5e-5, 0.046: 0.5e-3, -19.15: 0.5e-2, -0.00530: 0.5e-5}
    for value, (digits, unit) in zip(computed, printed.items(), strict=True):
        assert_allclose(value, digits, rtol=0, atol=unit)
    # Statics and beam theory exactly, to rounding.
    turn = -force * 5000.0 * 8000.0 / (4 * 200.0 * 200e6)
    assert_allclose(b[[0, 5]], [force * 8000.0 / (200.0 * 6e3), turn], rtol=1e-12)
    assert_allclose(c[1], 5000.0 * turn - force * 5000.0**3 / (3 * 200.0 * 50e6), rtol=1e-12)
    assert_allclose(solution.reaction("a")[5], -force * 5000.0 / 2, rtol=1e-12)
