"""Beyond a buckling load linear results do not hold, even where nothing moves that linear mechanics could see.

Columns: Timoshenko & Gere, *Theory of Elastic Stability*, 2nd ed., ch. 2.
"""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame
from linkframe.framework.results.validity import beyond_linear
from numpy.testing import assert_array_equal
from numpy.typing import ArrayLike

INF = np.inf
STEEL = Material(E=200e9, nu=0.3)
ROUND = Circle(diameter=0.02)
EULER = np.pi**2 * 200e9 * np.pi * 0.02**4 / 64.0
SHARES = np.array([0.0, 0.5, 0.99, 1.01, 1.1, 50.0])


def bar(push: ArrayLike, beam: bool) -> Frame:
    """A bar on a rotational spring of 100, pushed exactly along its axis."""
    frame = Frame()
    for name, x in {"G": 0.0, "A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.fix("G")
    frame.add("hinge", Joint((INF,) * 5 + (100.0,)), "G", "A")
    if beam:
        frame.add("bar", Beam(Circle(diameter=0.1), Material(E=1e13, nu=0.3)), "A", "B")
    else:
        frame.rigid("A", "B")
    frame.load("B", fx=-np.asarray(push))
    return frame


@pytest.mark.parametrize("beam", [False, True])
def test_a_perfect_bar_beyond_its_buckling_load(beam: bool) -> None:
    solution = bar(100.0 * SHARES, beam).solve()
    assert np.abs(solution.displacement("B")[:, 1:]).max() == 0.0
    assert_array_equal(solution.linear, SHARES < 1.0)
    assert_array_equal(np.isinf(solution.nonlinearity()), SHARES > 1.0)
    assert [bool(bar(100.0 * share, beam).solve().linear) for share in SHARES] == solution.linear.tolist()
    assert bar(-100.0 * SHARES, beam).solve().linear.all()


def column(top: tuple[str, ...], foot: tuple[str, ...], push: ArrayLike, segments: int = 8) -> Frame:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.0, 0.0, 1.0))
    frame.add("AB", Beam(ROUND, STEEL, segments=segments), "A", "B")
    frame.fix("A", *foot)
    frame.fix("B", *top)
    frame.load("B", fz=-np.asarray(push))
    return frame


ALL, PINNED = ("ux", "uy", "uz", "rx", "ry", "rz"), ("ux", "uy", "uz", "rz")


@pytest.mark.parametrize(
    ("top", "foot", "factor"),
    [
        (("rz",), ALL, 0.25),
        (("ux", "uy"), PINNED, 1.0),
        (("ux", "uy"), ALL, 2.0457),
        (("ux", "uy", "rx", "ry"), ALL, 4.0),
    ],
    ids=["free", "pinned", "propped", "clamped"],
)
def test_columns(top: tuple[str, ...], foot: tuple[str, ...], factor: float) -> None:
    """Statics takes each as one piece; here its segments bend between its ends."""
    shares = np.array([0.98, 1.03])
    assert column(top, foot, factor * EULER * shares).solve().linear.tolist() == [True, False]


@pytest.mark.parametrize("method", ["broadcast", "sparse", "banded", "iterative"])
def test_every_way_of_solving(method: str) -> None:
    push = 2.0 * np.array([[0.95], [1.05], [0.0]]) * EULER / 8.0
    solution = column(("rz",), ALL, push).copy().solve(method=method)
    assert solution.linear.tolist() == [[True], [False], [True]]


@pytest.mark.parametrize("method", ["sparse", "banded", "iterative"])
def test_a_long_row_of_members(method: str) -> None:
    """More unknowns than go the dense way, and two load cases."""
    count = 100
    frame = Frame()
    for k in range(count + 1):
        frame.node(f"n{k}", (0.0, 0.0, k / count))
    beam = Beam(ROUND, STEEL)
    for k in range(count):
        frame.add(f"m{k}", beam, f"n{k}", f"n{k + 1}")
    frame.fix("n0")
    frame.load(f"n{count}", fz=-0.25 * EULER * np.array([0.99, 1.01]))
    assert frame.solve(method=method).linear.tolist() == [True, False]


def test_stability_is_a_function_of_the_entry_alone() -> None:
    """Batches over loads, joints and sections, in parts, against buckling's factors."""
    stiffness = np.linspace(50.0, 150.0, 40)
    push = np.linspace(10.0, 160.0, 60)[:, None]
    frame = Frame()
    for name, x in {"G": 0.0, "A": 0.0, "B": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.fix("G")
    six = np.broadcast_to(INF, (40, 6)).copy()
    six[:, 5] = stiffness
    frame.add("hinge", Joint(six), "G", "A")
    frame.add("bar", Beam(Circle(diameter=0.1), Material(E=1e13, nu=0.3)), "A", "B")
    frame.load("B", fx=-push)
    assert_array_equal(frame.solve().linear, push < stiffness * (1.0 - 1e-6))
    assert_array_equal(frame.solve().linear, frame.buckling(1).factors[..., 0] > 1.0)


def test_an_empty_batch_and_a_frame_at_rest() -> None:
    assert bar(np.zeros((0, 3)), beam=True).solve().linear.shape == (0, 3)
    assert bool(bar(0.0, beam=True).solve().linear)


def test_what_is_read_of_an_unstable_equilibrium() -> None:
    assert beyond_linear(INF) == "outside the linear range: unstable under its load"
    assert beyond_linear(0.123) == "outside the linear range: estimated error 12 %"
