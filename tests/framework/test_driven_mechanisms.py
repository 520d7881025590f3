"""Mechanisms with an imposed displacement: every way of solving names their motion."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame
from linkframe.framework.solvers.method import METHODS, available

BEAM = Beam(Section(A=1e-2, Iy=1e-5, Iz=2e-5, J=2e-5), Material(E=2e11, nu=0.3))


@pytest.mark.parametrize("method", [name for name in METHODS if name != "cholesky" or available()])
@pytest.mark.parametrize("settles", [False, True])
def test_a_misfit_or_a_settlement_stops_no_mechanism(method: str, settles: bool) -> None:
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BEAM, "A", "B")
    frame.add("CD", BEAM, "C", "D")
    frame.add("pin", Joint(stiffness=(1e9, 1e9, 1e9, 1e6, 1e6, 0.0)), "B", "C")
    frame.fix("A")
    if settles:
        frame.prescribe("A", uy=1e-4)
    else:
        frame.offset("pin", ux=1e-4)
    frame.load("D", fy=1.0)
    solution = frame.solve(method)
    assert solution.status == "mechanism"
    turn = solution.free_motion().displacement("D")[0]
    assert np.argmax(np.abs(turn[:3])) == 1
