"""A joint next to nothing beside stiff ones: soft, and no mechanism, however the frame is solved."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from numpy.testing import assert_allclose

BAR, BENDING = Beam(Rectangle(y=0.02, z=0.02), Material(E=200e9, nu=0.3)), 200e9 * 0.02**4 / 12.0


@pytest.mark.parametrize("method", ["broadcast", "banded", "sparse"])
@pytest.mark.parametrize("soft", [1e-30, 1e-12])
def test_the_softest_hinge_is_no_mechanism(soft: float, method: str) -> None:
    """F L²/k + F (2 L)³/3EI + F/K, under loads of a batch and alone; without the spring it is one."""
    for force in (2.0, np.array([2.0, -1.0])):
        frame = Frame()
        for name, x in {"A": 0.0, "B": 1.0, "C": 1.0, "D": 2.0}.items():
            frame.node(name, (x, 0.0, 0.0))
        frame.add("AB", BAR, "A", "B")
        frame.add("hinge", Joint((1e8,) * 5 + (soft,)), "B", "C")
        frame.add("CD", BAR, "C", "D")
        frame.fix("A")
        frame.load("D", fy=force)
        solution = frame.solve(method=method)
        assert np.all(solution.status == "regular")
        exact = force * (1.0 / soft + 8.0 / (3.0 * BENDING) + 1e-8)
        assert_allclose(solution.displacement("D")[..., 1], exact, rtol=1e-12)
        bound = solution.error_bound("D")[..., 1]
        assert np.all(bound >= np.abs(solution.displacement("D")[..., 1] - exact))
        assert np.all(bound <= 1e-12 * np.abs(exact))
        assert_allclose(solution.joint_force("hinge")[..., 5], force, rtol=1e-12)
