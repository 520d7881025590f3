"""Condition numbers against NumPy's of the same matrices, for small frames and for large ones."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.framework.results import dense
from linkframe.framework.results.spectrum import DENSE
from numpy.testing import assert_allclose

BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3))


def equilibrated(matrix: np.ndarray) -> np.ndarray:
    root = 1.0 / np.sqrt(matrix.diagonal())
    return root[:, None] * matrix * root


def chain(count: int) -> Frame:
    """Bars in a zigzag, clamped at one end."""
    frame = Frame()
    for k in range(count + 1):
        frame.node(str(k), (0.5 * k, 0.1 * (k % 2), 0.05 * (k % 3)))
    for k in range(count):
        frame.add(f"bar {k}", BEAM, str(k), str(k + 1))
    frame.fix("0")
    frame.load(str(count), fy=1.0)
    return frame


def test_one_bar_against_its_matrix() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", [(1.0, 0.0, 0.0), (3.0, 0.0, 0.0)])
    frame.add("AB", BEAM, "A", "B")
    frame.fix("A")
    solution = frame.solve()
    free = [BEAM.stiffness_matrix(length)[6:, 6:] for length in (1.0, 3.0)]
    assert_allclose(solution.condition_number(), [np.linalg.cond(k) for k in free], rtol=1e-9)
    assert_allclose(solution.scaled_condition_number(), [np.linalg.cond(equilibrated(k)) for k in free], rtol=1e-9)


def test_a_joint_is_a_spring_between_twins_in_the_usual_matrix_only() -> None:
    """A stiff joint between a bar and the ground: K = [[k + c, -c], [-c, c + ...]] beside a coordinate of its own."""
    springs = np.array([2e11, 3e11, 4e11, 5e6, 6e6, 7e6])
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BEAM, "A", "B")
    frame.add("BC", Joint(stiffness=springs), "B", "C")
    frame.fix("A")
    solution = frame.solve()
    bar, joint = BEAM.stiffness_matrix(1.0)[6:, 6:], np.diag(springs)
    usual = np.block([[bar + joint, -joint], [-joint, joint]])
    relative = np.block([[bar, np.zeros((6, 6))], [np.zeros((6, 6)), joint]])
    assert_allclose(solution.condition_number(), np.linalg.cond(usual), rtol=1e-6)
    assert_allclose(solution.scaled_condition_number(), np.linalg.cond(equilibrated(relative)), rtol=1e-9)
    frame.tie("A", "C", "ux")
    with pytest.raises(FrameError, match="scaled_condition_number"):
        frame.solve().condition_number()


def test_one_large_frame_by_lanczos() -> None:
    solution = chain(DENSE // 6 + 10).solve()
    assert len(solution.plan.unknowns) > DENSE
    matrix = dense.stiffness(solution.plan)
    assert_allclose(solution.condition_number(), np.linalg.cond(matrix), rtol=1e-4)
    assert_allclose(solution.scaled_condition_number(), np.linalg.cond(equilibrated(matrix)), rtol=1e-4)
