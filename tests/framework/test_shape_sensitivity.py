"""Sensitivities to coordinates of nodes, sizes of sections and moduli: closed forms, and differences of solutions."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material, Rectangle, Spring
from linkframe.framework import Frame, FrameError, Solution
from numpy.testing import assert_allclose

STEEL = Material(E=2e11, nu=0.3, density=7800.0)
PLACES = np.array(
    [(0, 0, 0), (1, 0.2, 0.1), (1, 0.2, 0.1), (1.8, 0.5, 0.6), (0.4, 1.0, 0.2), (2.0, 0.7, 0.5), (2.6, 0.1, 0.9)]
)
RESULTS: dict[tuple[str, str, str], Callable[[Solution], np.ndarray]] = {
    ("G", "uy", "displacement"): lambda solution: solution.displacement("G")[:, 1],
    ("A", "mz", "reaction"): lambda solution: solution.reaction("A")[:, 5],
    ("hinge", "fx", "joint_force"): lambda solution: solution.joint_force("hinge")[:, 0],
}


def test_a_cantilever_in_closed_form() -> None:
    """u = F L^3 / 3 E I of random cantilevers: 3 u / L by its length, -3 u / y and -u / z by its sizes, -u / E."""
    rng = np.random.default_rng(0)
    length, y, z, force = (rng.uniform(0.5, 1.5, 10_000) for _ in range(4))
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", np.stack([length, 0.0 * length, 0.0 * length], axis=-1))
    frame.add("AB", Beam(Rectangle(y=0.02 * y, z=0.02 * z), STEEL), "A", "B")
    frame.fix("A")
    frame.load("B", fy=force)
    solution = frame.solve()
    found, u = solution.sensitivity("B", "uy"), solution.displacement("B")[:, 1]
    assert_allclose(found.nodes["B"][:, 0], 3.0 * u / length, rtol=1e-12)
    assert_allclose(found.nodes["A"][:, 0], -3.0 * u / length, rtol=1e-12)
    assert_allclose(found.sections["AB"]["y"], -3.0 * u / (0.02 * y), rtol=1e-12)
    assert_allclose(found.sections["AB"]["z"], -u / (0.02 * z), rtol=1e-12)
    assert_allclose(found.moduli["AB"], -u / 2e11, rtol=1e-12)
    # What turns it lets the force bend and stretch it.
    assert_allclose(found.nodes["B"][:, 1], 0.0, atol=1e-12 * np.abs(u).max())


def structure(places: np.ndarray, y: np.ndarray, z: np.ndarray) -> Frame:
    """Beams, one with shear, one in segments; a hinge, a rigid link; loads on nodes and along members."""
    frame = Frame()
    for k, name in enumerate("ABCDEFG"):
        frame.node(name, places[:, k])
    frame.add("AB", Beam(Rectangle(y=y, z=0.03), STEEL), "A", "B")
    frame.add("CD", Beam(Rectangle(y=0.02, z=z), STEEL), "C", "D")
    frame.add("BE", Beam(Circle(diameter=0.04), STEEL, shear=True), "B", "E")
    frame.add("hinge", Joint((1e8, 1e8, 1e8, 1e5, 1e5, 1e3)), "B", "C")
    frame.rigid("D", "F")
    frame.add("FG", Beam(Circle(diameter=0.03), STEEL, segments=2), "F", "G")
    frame.fix("A")
    frame.fix("E")
    frame.load("G", fx=30.0, fy=100.0, fz=20.0, mx=3.0)
    frame.line_load("AB", fy=-100.0)
    frame.gravity((0, 0, -9.81))
    return frame


def test_differences_of_solutions() -> None:
    """All neighbours in one batch, of which each input has four; both nodes of a joint move together."""
    inputs = [(nodes, k, 1e-4) for nodes in ("BC", "F", "D", "G") for k in range(3)] + [
        ("y", 0, 1e-5),
        ("z", 0, 1e-5),
    ]
    count = 1 + 4 * len(inputs)
    places, y, z = np.tile(PLACES, (count, 1, 1)), np.full(count, 0.05), np.full(count, 0.03)
    for at, (what, k, step) in enumerate(inputs):
        steps = step * np.array([1.0, -1.0, 2.0, -2.0])
        own = slice(1 + 4 * at, 5 + 4 * at)
        if what in ("y", "z"):
            (y if what == "y" else z)[own] += steps
        else:
            for node in what:
                places[own, "ABCDEFG".index(node), k] += steps
    solution = structure(places, y, z).solve()
    for result, read in RESULTS.items():
        found, values = solution.sensitivity(*result), read(solution)
        for at, (what, k, step) in enumerate(inputs):
            a, b, c, d = values[1 + 4 * at : 5 + 4 * at]
            expected = (8.0 * (a - b) - (c - d)) / (12.0 * step)
            if what in ("y", "z"):
                mine = found.sections["AB"]["y"] if what == "y" else found.sections["CD"]["z"]
                assert_allclose(mine[0], expected, rtol=1e-8, atol=1e-7 * abs(values[0]))
            else:
                mine = np.sum([found.nodes[node][0, k] for node in what])
                assert_allclose(mine, expected, rtol=1e-8, atol=1e-9 * abs(values[0]))


def test_a_taper() -> None:
    """Differences by the size of its far end, and by the place of its near one."""
    steps = np.array([0.0, 1.0, -1.0, 2.0, -2.0])
    for far, near in ((1e-5 * steps, 0.0 * steps), (0.0 * steps, 1e-4 * steps)):
        frame = Frame()
        frame.node("A", np.stack([near, near, 0.0 * near], axis=-1))
        frame.node("B", (1.0, 0.3, 0.2))
        frame.add("AB", Beam(Circle(diameter=0.03), STEEL, end=Circle(diameter=0.02 + far)), "A", "B")
        frame.fix("A")
        frame.load("B", fy=10.0, fz=3.0)
        solution = frame.solve()
        found, u = solution.sensitivity("B", "uy"), solution.displacement("B")[:, 1]
        own = found.sections["AB"]["end.diameter"][0] if far.any() else found.nodes["A"][0, :2].sum()
        step = (far + near)[1]
        assert_allclose(own, (8.0 * (u[1] - u[2]) - (u[3] - u[4])) / (12.0 * step), rtol=1e-8)


def test_a_member_with_a_force_at_rest_is_refused() -> None:
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (1.0, 0.0, 0.0))
    frame.add("spring", Spring(100.0, 5.0, applied=True), "A", "B")
    frame.fix("A")
    frame.fix("B", "uy", "uz", "rx", "ry", "rz")
    frame.load("B", fx=1.0)
    with pytest.raises(FrameError, match="member 'spring' has a force at rest"):
        frame.solve().sensitivity("B", "ux").nodes  # noqa: B018
