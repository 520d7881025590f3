"""One degree of freedom: the shallow truss of von Mises and a single spring along their whole paths, and what it takes.

Two rods of stiffness k between feet 2 apart meet at height h; lowered by v, they carry ``2 k (l0 - l) (h - v) / l``.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle, Section, Spring
from linkframe.framework import Frame, FrameError, PathWarning
from numpy.testing import assert_allclose

HEIGHT, STIFFNESS = 0.1, 1e4
LENGTH = float(np.hypot(1.0, HEIGHT))


def carried(lowered: np.ndarray) -> np.ndarray:
    """Load of the truss."""
    left = HEIGHT - lowered
    length = np.hypot(1.0, left)
    return np.asarray(2.0 * STIFFNESS * (LENGTH - length) * left / length)


def truss(kind: str, load: float = 1.0) -> Frame:
    """Of springs, or of beams that are pinned at both ends."""
    frame = Frame()
    for name, place in {"A": (0.0, 0.0), "B": (1.0, HEIGHT), "C": (2.0, 0.0)}.items():
        frame.node(name, (*place, 0.0))
    area = STIFFNESS * LENGTH / 200e9
    section = Section(A=area, Iy=1e-4 * area, Iz=1e-4 * area, J=1e-4 * area)
    beam = Beam(section, Material(E=200e9, nu=0.3), release=("start rz", "end rz"))
    for ends in ("AB", "BC"):
        frame.add(ends, Spring(STIFFNESS) if kind == "spring" else beam, *ends)
    frame.fix("A")
    frame.fix("C")
    frame.fix("B", "uz", "rx", "ry", "rz")
    frame.load("B", fy=-load)
    return frame


@pytest.mark.parametrize("kind", ["spring", "beam"])
def test_a_truss_of_one_freedom_snaps_through(kind: str) -> None:
    path = truss(kind).path("B", "uy", -2.5 * HEIGHT)
    lowered = -path.displacement("B")[:, 1]
    assert path.reached
    assert lowered[-1] >= 2.5 * HEIGHT
    assert_allclose(path.factor, carried(lowered), rtol=1e-9, atol=1e-12)
    turn = HEIGHT - np.sqrt(LENGTH ** (2 / 3) - 1.0)  # where the load is largest, rods are as long as LENGTH^(1/3)
    largest = float(carried(turn))
    assert path.limits[0] == pytest.approx([largest, -largest], rel=1e-11)
    assert (path.stable == ((lowered < turn) | (lowered > 2.0 * HEIGHT - turn))).all()


@pytest.mark.parametrize("spread", [0.004, 0.05])
def test_a_truss_snaps_through_while_a_foot_moves(spread: float) -> None:
    """A foot moves outwards in proportion to the load; the apex is where its own springs balance that."""
    frame = truss("spring")
    frame.prescribe("C", ux=spread)
    frame.load("B", fx=0.3)
    path = frame.path("B", "uy", -2.5 * HEIGHT)
    assert path.reached
    assert len(path.factor) < 40
    place = np.array([1.0, HEIGHT]) + path.displacement("B")[:, :2]
    unbalanced = path.factor[:, None] * np.array([0.3, -1.0])
    for foot in (np.zeros((1, 2)), np.array([[2.0, 0.0]]) + path.factor[:, None] * np.array([[spread, 0.0]])):
        chord = foot - place
        length = np.linalg.norm(chord, axis=-1, keepdims=True)
        unbalanced = unbalanced + STIFFNESS * (length - LENGTH) * chord / length
    assert_allclose(unbalanced, 0.0, atol=1e-8)


def test_a_single_spring_is_followed() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Spring(10.0), "A", "B")
    frame.fix("A")
    frame.fix("B", "uy", "uz", "rx", "ry", "rz")
    frame.load("B", fx=1.0)
    path = frame.path("B", "ux", 0.5)
    assert path.reached
    assert_allclose(path.displacement("B")[:, 0], path.factor / 10.0, rtol=1e-12)


def test_a_path_that_ends_too_early_says_so() -> None:
    with pytest.warns(PathWarning, match=r"uy = -0.25 of 'B' ended after 4 points"):
        path = truss("spring").path("B", "uy", -0.25, steps=3)
    assert not path.reached


@pytest.mark.parametrize(
    ("given", "told"),
    [
        ({"steps": 0}, "steps of the path of 'B' is 0"),
        ({"steps": True}, "steps of the path of 'B' is True"),
        ({"first": -1.0}, "first = -1.0"),
    ],
)
def test_paths_refuse_steps_that_cannot_be(given: dict[str, float], told: str) -> None:
    with pytest.raises(FrameError, match=told):
        truss("spring").path("B", "uy", -0.25, **given)


def test_truth_is_no_number_of_steps() -> None:
    with pytest.raises(FrameError, match="steps is True"):
        truss("spring").solve(large=True, steps=True)


@pytest.mark.parametrize("steps", [1, 4])
def test_strain_energy_is_that_of_the_state(steps: int) -> None:
    """For any number of steps: of both rods, by their lengths; and the work of the load by the trapezoidal rule."""
    frame = truss("spring", load=3.0)
    solution = frame.solve(large=True, steps=steps)
    lowered = -solution.displacement("B")[1]
    assert carried(lowered) == pytest.approx(3.0, rel=1e-12)
    energy = STIFFNESS * (LENGTH - np.hypot(1.0, HEIGHT - lowered)) ** 2
    assert solution.strain_energy.shape == (steps,)
    assert solution.strain_energy[-1] == pytest.approx(energy, rel=1e-12)
    if steps == 1:
        assert solution.work[0] == pytest.approx(0.5 * 3.0 * lowered, rel=1e-12)


def test_energy_of_a_cantilever_in_one_step_is_its_work() -> None:
    """Nearly linear: half the load times the deflection, P^2 L^3 / (6 E I); NaN where the entry is left out."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=0.01, z=0.01), Material(E=200e9, nu=0.3), segments=4), "A", "B")
    frame.fix("A")
    frame.load("B", fy=np.array([0.01, 0.02, 0.03]))
    frame.exclude(np.array([False, True, False]))
    solution = frame.solve(large=True)
    expected = np.array([0.01, np.nan, 0.03]) ** 2 / (6.0 * 200e9 * 0.01**4 / 12.0)
    assert_allclose(solution.strain_energy[0], expected, rtol=1e-6)
    assert_allclose(solution.work[0], expected, rtol=1e-6)


@pytest.mark.parametrize("fixed", [False, True])
def test_a_spring_pushed_along_its_axis_swings_round(fixed: bool) -> None:
    """Pushed by F, a spring of length 1 is stable only where it pulls back: swung round, 1 + F / k long."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("AB", Spring(100.0), "A", "B")
    frame.fix("A")
    if fixed:
        frame.fix("B", "rx", "ry", "rz")
    frame.load("B", fx=-1.0)
    solution = frame.solve(large=True)
    assert solution.status == "stable beyond a saddle"
    assert_allclose(solution.displacement("B")[:3], [-2.01, 0.0, 0.0], atol=1e-9)
