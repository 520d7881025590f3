"""Contact under loads at the edge of what numbers can be: a load that closes nothing is not lost in a quotient."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

BAR = Beam(Rectangle(y=12.7e-3, z=6.35e-3), Material(E=200e9, nu=0.3))


@pytest.mark.parametrize("clearance", [1e-4, 1e-300])
def test_a_load_next_to_nothing_leaves_the_clearance_open(clearance: float) -> None:
    """Two rods in line, of which one alone bears the load: k ε/F is beyond all numbers for the smallest."""
    force = np.array([1e-300, 1e-305, 1e-307, 3e-308, 1e-310])
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("pin", Joint((1e9, 1e9, 1e9, np.inf, np.inf, 0.0), clearance=clearance), "B", "C")
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    frame.fix("D")
    frame.load("C", fx=force)
    solution = frame.solve()
    assert solution.status.tolist() == ["regular"] * len(force)
    contact = solution.contact("pin")
    assert contact.status.tolist() == ["open"] * len(force)
    assert not contact.force.any()
    exact = force / (200e9 * 12.7e-3 * 6.35e-3)
    assert_allclose(solution.displacement("C")[:, 0], exact, rtol=1e-9, atol=1e-323)
