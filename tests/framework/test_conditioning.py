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


def equilibrated(matrix: np.ndarray, alike: str = "000111") -> np.ndarray:
    """Six coordinates after six; those of one mark have the mean of their stiffness scaled to one."""
    mean = np.empty(len(matrix))
    for start in range(0, len(matrix), 6):
        for mark in set(alike):
            where = [start + k for k, other in enumerate(alike) if other == mark]
            mean[where] = matrix.diagonal()[where].mean()
    return matrix / np.sqrt(np.outer(mean, mean))


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
    assert_allclose(solution.condition_number(), np.linalg.cond(usual), rtol=1e-6)
    by_hand = np.block([[equilibrated(bar), np.zeros((6, 6))], [np.zeros((6, 6)), np.eye(6)]])
    assert_allclose(solution.scaled_condition_number(), np.linalg.cond(by_hand), rtol=1e-9)
    frame.tie("A", "C", "ux")
    with pytest.raises(FrameError, match="scaled_condition_number"):
        frame.solve().condition_number()


def test_one_large_frame_by_lanczos() -> None:
    solution = chain(DENSE // 6 + 10).solve()
    assert len(solution.plan.unknowns) > DENSE
    matrix = dense.stiffness(solution.plan)
    assert_allclose(solution.condition_number(), np.linalg.cond(matrix), rtol=1e-4)
    assert_allclose(solution.scaled_condition_number(), np.linalg.cond(equilibrated(matrix)), rtol=1e-4)


def test_scaling_does_not_depend_on_the_axes_in_which_a_frame_stands() -> None:
    """Of the whole frame turned, of bodies with axes of their own, of joints of equal springs; nor on the batch."""
    rng = np.random.default_rng(5)

    def scaled(turn: np.ndarray, body: np.ndarray, joint: np.ndarray | None, load: tuple[float, ...] = (1.0,)) -> float:
        frame = Frame()
        frame.body("bent", origin=turn @ [0.2, 0.1, 0.0], axes=body)
        places = {"A": (0.0, 0.0, 0.0), "B": (0.7, 0.2, 0.1), "C": (0.7, 0.2, 0.1), "D": (1.0, 0.9, -0.3)}
        for name, place in places.items():
            on = "bent" if name in "CD" else None
            away = turn @ np.array(place) - (turn @ [0.2, 0.1, 0.0] if on else 0.0)
            frame.node(name, body.T @ away if on else away, body=on)
        for name, up in (("AB", turn[:, 2]), ("CD", body.T @ turn[:, 2])):
            frame.add(name, Beam(BEAM.section, BEAM.material, up=tuple(up)), *name)
        frame.add("pin", Joint(stiffness=(1e9, 1e9, 1e9, 2e4, 2e4, 0.0), axes=joint), "B", "C")
        frame.fix("A")
        frame.fix("D")
        frame.load("B", fy=np.array(load))
        found = frame.solve().scaled_condition_number()
        assert found.shape == np.shape(load)
        return float(found[0])

    def rotation() -> np.ndarray:
        q, r = np.linalg.qr(rng.normal(size=(3, 3)))
        q *= np.sign(np.diagonal(r))
        return q * np.sign(np.linalg.det(q))

    turn, unit = rotation(), np.eye(3)
    about = np.array([[0.6, -0.8, 0.0], [0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])
    drawn = scaled(unit, unit, None)
    assert_allclose(scaled(unit, rotation(), None), drawn, rtol=1e-9)
    assert_allclose(scaled(unit, unit, about), drawn, rtol=1e-9)
    assert_allclose(scaled(turn, rotation(), turn), drawn, rtol=1e-9)
    assert_allclose(scaled(turn, rotation(), turn @ about, (1.0, 2.0)), drawn, rtol=1e-9)


def test_what_nothing_resists_has_no_unit() -> None:
    """A point on springs, one of which is missing at the first entry: infinite there, one where all have their unit."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.0, 0.0, 0.0))
    frame.add("pin", Joint(stiffness=np.array([[1e9] * 5 + [0.0], [1e9] * 5 + [1e3]])), "A", "B")
    frame.fix("A")
    frame.load("B", fx=1.0)
    assert_allclose(frame.solve().scaled_condition_number(), [np.inf, 1.0])
