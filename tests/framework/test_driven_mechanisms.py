"""Mechanisms with an imposed displacement: every way of solving names their motion."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Section
from linkframe.framework import Frame, MechanismWarning
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


def test_a_spring_that_is_soft_is_not_taken_for_one_that_is_not_there() -> None:
    """Though another entry of the same geometry has none: F L^2 / k beside what bends, however soft it is."""
    turning = np.array([0.0, 1e-9, 1e-5, 10.0])
    stiffness = np.concatenate([np.full((4, 5), 1e9), turning[:, None]], axis=1)
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BEAM, "A", "B")
    frame.add("CD", BEAM, "C", "D")
    frame.add("pin", Joint(stiffness=stiffness), "B", "C")
    frame.fix("A")
    frame.load("D", fy=1.0)
    solution = frame.solve()
    assert solution.status.tolist() == ["mechanism", "regular", "regular", "regular"]
    bent = 8.0 / (3.0 * 2e11 * 2e-5) + 1e-9
    with pytest.warns(MechanismWarning):
        moved = solution.displacement("D")[:, 1]
    np.testing.assert_allclose(moved[1:], 1.0 / turning[1:] + bent, rtol=1e-10)
