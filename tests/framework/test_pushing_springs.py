"""Springs that push at rest take stiffness off across their line: bounds, mechanisms and distance to singularity.

A cantilever AB along x with a spring BG in line with it that carries the force S: across its line the spring has the
stiffness ``S / L`` of a string, so that the tip's is ``3 E I / l^3 + S / L``.
"""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest
from linkframe.elements import Beam, Material, Rectangle, Spring
from linkframe.framework import Frame

HEIGHT, E, LOAD, FAR = 0.01, 200e9, 3.0, 0.7
METHODS = ("broadcast", "banded", "sparse", "iterative")


def cantilever(force: object, *, hinged: bool = False) -> Frame:
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "G": 1.0 + FAR}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", Beam(Rectangle(y=HEIGHT, z=HEIGHT), Material(E=E, nu=0.3)), "A", "B")
    frame.add("BG", Spring(stiffness=1e4, force=force), "B", "G")
    if hinged:
        frame.node("C", (1.0, 1.0, 0.0))
        frame.add("BC", Beam(Rectangle(y=HEIGHT, z=HEIGHT), Material(E=E, nu=0.3), release="start rz"), "B", "C")
        frame.load("C", fz=LOAD)
    frame.fix("A")
    frame.fix("G")
    frame.load("B", fy=LOAD)
    return frame


def tip_stiffness() -> mp.mpf:
    return 3 * mp.mpf(E) * mp.mpf(HEIGHT) ** 4 / 12


def across(force: float) -> mp.mpf:
    return mp.mpf(force) / (mp.mpf(1.0 + FAR) - 1)


CRITICAL = -float(tip_stiffness()) * FAR


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("share", [0.01, 1.0 - 1e-6, 3.0])
def test_bounds_hold(share: float, method: str) -> None:
    """Against forty digits, up to close to the force that pushes the cantilever over, and beyond it."""
    solution = cantilever(share * CRITICAL).solve(method)
    with mp.workdps(40):
        k = tip_stiffness()
        tip = mp.mpf(LOAD) / (k + across(share * CRITICAL))
        expected = {("B", "displacement", 1): tip, ("B", "displacement", 5): 3 * tip / 2}
        expected |= {("A", "reaction", 1): -k * tip, ("A", "reaction", 5): -k * tip, ("A", "reaction", 0): mp.mpf(0)}
        results = {"displacement": solution.displacement, "reaction": solution.reaction}
        for (node, kind, component), exact in expected.items():
            bound = solution.error_bound(node, kind)[component]
            error = abs(mp.mpf(float(results[kind](node)[component])) - exact)
            assert error <= bound
            assert bound >= 0.0
            if share < 0.99:
                assert bound <= 1e-12 * (abs(float(exact)) + LOAD)


@pytest.mark.parametrize("method", METHODS)
def test_a_mechanism_beside_a_spring_that_pushes(method: str) -> None:
    """BC turns about its hinge, which no load drives: the tip deflects as without it; a load that drives it is told."""
    frame = cantilever(0.5 * CRITICAL, hinged=True)
    solution = frame.solve(method)
    assert solution.status == "statically consistent mechanism"
    motion = solution.free_motion()
    assert motion.count == 1
    assert np.abs(motion.displacement("C")[0, 0]) == pytest.approx(1.0)
    assert solution.displacement("B")[1] == pytest.approx(2.0 * LOAD / float(tip_stiffness()), rel=1e-9)
    frame.load("C", fx=1.0)
    assert frame.solve(method).status == "mechanism"


@pytest.mark.parametrize("method", METHODS)
def test_a_load_that_turns_with_a_free_motion_is_outside_the_linear_range(method: str) -> None:
    """On the displaced shape the load does work on the free motion, which nothing resists, whatever rounding is."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0, 0), "G": (1, 0.7, 0.2), "C": (2, 0.3, 0.1)}.items():
        frame.node(name, place)
    beam = Beam(Rectangle(y=0.02, z=0.03), Material(E=210e9, nu=0.3))
    frame.add("AB", beam, "A", "B")
    frame.add("BC", Beam(beam.section, beam.material, release="start rz"), "B", "C")
    frame.add("s", Spring(stiffness=1e4, force=-50.0), "B", "G")
    frame.fix("A")
    frame.fix("G")
    frame.load("C", fz=5.0)
    solution = frame.solve(method)
    assert solution.status == "statically consistent mechanism"
    assert not solution.linear


@pytest.mark.parametrize("share", [1.001, 3.0, 30.0])
def test_beyond_the_force_that_pushes_it_over_all_methods_say_alike(share: float) -> None:
    """The equilibrium is there, and unstable: outside the linear range."""
    for method in METHODS:
        solution = cantilever(share * CRITICAL).solve(method)
        assert solution.status == "regular"
        assert not solution.linear
        exact = LOAD / float(tip_stiffness() + across(share * CRITICAL))
        assert solution.displacement("B")[1] == pytest.approx(exact, rel=1e-9)


def test_entries_that_push_and_entries_that_pull() -> None:
    forces = np.array([0.5, -0.5, 0.0]) * CRITICAL
    found = cantilever(forces, hinged=True).solve().status
    assert (found == "statically consistent mechanism").all()


def test_distance_is_the_root_of_the_least_eigenvalue() -> None:
    """Of the stiffness scaled to unit diagonal: in the bending planes [[a, c], [c, b]] of uy and rz at the tip."""
    shares = np.array([0.0, 0.5, 0.99])
    solution = cantilever(shares * CRITICAL).solve()
    tip = float(tip_stiffness())
    a, b, c = 4.0 * tip - shares * tip, 4.0 * tip / 3.0, -2.0 * tip
    assert solution.distance_to_singularity() == pytest.approx(np.sqrt(1.0 - np.abs(c) / np.sqrt(a * b)), rel=1e-9)
    assert solution.free_motion(2).count == 0
