"""Weaver's frames: a plane and a space frame with published displacements and reactions."""

from __future__ import annotations

import numpy as np
from linkframe.elements import Beam, Material, Section
from linkframe.framework import Frame
from numpy.testing import assert_allclose


def test_plane_frame() -> None:
    """Weaver and Gere, Matrix Analysis of Framed Structures, plane-frame example (2nd ed., p. 243).

    E = 10000 ksi, A = 10 in2, I = 1000 in4, P = 10 kips, L = 100 in; w = 0.24 kip/in on the first member, 2P at the
    middle of the second. Displacements are printed with four significant digits: half a unit of the last one (one for
    the rotation, printed -0.1797E-02, which is cut and not rounded).
    """
    beam = Beam(Section(A=10.0, Iy=1000.0, Iz=1000.0, J=1.0), Material(E=1e4, G=4e3))
    frame = Frame()
    frame.node("left", (0.0, 75.0, 0.0))
    frame.node("corner", (100.0, 75.0, 0.0))
    frame.node("right", (200.0, 0.0, 0.0))
    frame.add("beam", beam, "left", "corner")
    frame.add("strut", beam, "corner", "right")
    frame.fix("left")
    frame.fix("right")
    frame.load("corner", fy=-10.0, mz=-1000.0)
    frame.line_load("beam", fy=-0.24)
    frame.point_load("strut", at=62.5, fy=-20.0)
    solution = frame.solve()
    ux, uy, _, _, _, rz = solution.displacement("corner")
    assert_allclose(ux, -0.02026, rtol=0, atol=0.5e-5)
    assert_allclose(uy, -0.09936, rtol=0, atol=0.5e-5)
    assert_allclose(rz, -0.001797, rtol=0, atol=1e-6)
    left, right = solution.reaction("left"), solution.reaction("right")
    # Statics: 10 + 24 + 20 kips; moments about the left end, the nodal couple included.
    assert_allclose(left[:2] + right[:2], [0.0, 54.0], atol=1e-11)
    moment = (
        left[5] + right[5] + 200.0 * right[1] + 75.0 * right[0] - 100.0 * 10.0 - 50.0 * 24.0 - 150.0 * 20.0 - 1000.0
    )
    assert_allclose(moment, 0.0, atol=1e-9)


def test_space_frame() -> None:
    """Weaver, Computer Programs for Structural Analysis, 1967, p. 146, problem 8; STAAD.Pro verification manual.

    E = 30000 ksi, G = 12000 ksi, A = 11 in2, Iy = Iz = 56 in4, J = 83 in4, L = 120 in. Printed with five decimals:
    half a unit of the last. Reactions as recomputed for the manual, five significant digits.
    """
    length = 120.0
    beam = Beam(Section(A=11.0, Iy=56.0, Iz=56.0, J=83.0), Material(E=30000.0, G=12000.0))
    frame = Frame()
    for name, place in {"1": (0, 1, 0), "2": (2, 1, 0), "3": (0, 0, 0), "4": (3, 0, 1)}.items():
        frame.node(name, length * np.array(place))
    frame.add("girder", beam, "1", "2")
    frame.add("column", beam, "3", "1")
    frame.add("strut", beam, "2", "4")
    frame.fix("3")
    frame.fix("4")
    frame.load("1", fx=2.0)
    frame.load("2", fy=-1.0, mz=-120.0)
    solution = frame.solve()
    printed = {
        "1": [0.22267, 0.00016, -0.17182, -0.00255, 0.00217, -0.00213],
        "2": [0.22202, -0.48119, -0.70161, -0.00802, 0.00101, -0.00435],
    }
    for node, values in printed.items():
        assert_allclose(solution.displacement(node), values, rtol=0, atol=0.51e-5)
    assert_allclose(solution.reaction("3"), [-1.1041, -0.43222, 0.21731, 48.785, -17.973, 96.122], rtol=3e-5)
    assert_allclose(solution.reaction("4"), [-0.89588, 1.4322, -0.21731, 123.08, 47.246, -11.72], rtol=5e-5)
