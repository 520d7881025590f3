"""Frames that are singular to double precision and not to extended precision, in planes that no load reaches too.

A cantilever of n beams resists the motion of its tip by 1 / n^4 of what its nodes resist; of 2400 the stiffness, which
squares what deformations know, has nothing but rounding left.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import Frame, MechanismWarning

E, D = 2e11, 0.1
LONG = 2400


def chain(count: int, *, modulus: object = E, hinge: int | None = None, release: str = "start rz") -> Frame:
    """A cantilever along x of beams of one metre, one of which may be hinged."""
    frame = Frame()
    beam = Beam(Circle(diameter=D), Material(E=modulus, nu=0.3))
    names = [f"n{k}" for k in range(count + 1)]
    frame.add_nodes(names, np.outer(np.arange(count + 1.0), [1.0, 0.0, 0.0]))
    pairs = list(pairwise(names))
    if hinge is not None:
        frame.add("hinged", Beam(beam.section, beam.material, release=(release,)), *pairs.pop(hinge))
    for pair in pairs:
        frame.add("-".join(pair), beam, *pair)
    frame.fix("n0")
    return frame


def deflection(count: int, modulus: object = E) -> np.ndarray:
    """F L^3 / (3 E I) for F of 1 N."""
    return count**3 / (3.0 * np.asarray(modulus) * np.pi * D**4 / 64.0)


@pytest.mark.parametrize("loads", ["fy", "mx"])
def test_a_soft_plane_is_no_mechanism(loads: str) -> None:
    frame = chain(LONG)
    frame.load(f"n{LONG}", **dict.fromkeys(loads.split(), 1.0))
    solution = frame.solve()
    assert solution.status == "regular"
    assert solution.free_motion().count == 0
    moved = solution.displacement(f"n{LONG}")
    for k, load in enumerate(["fy", "fz"], start=1):
        expected = deflection(LONG) if load in loads.split() else 0.0
        assert moved[k] == pytest.approx(expected, rel=1e-14, abs=1e-15)


def test_a_soft_plane_whose_support_settles() -> None:
    """The support's own displacement and rotation carry the tip along, and the load bends the chain."""
    frame = chain(LONG)
    frame.prescribe("n0", uy=0.25, rz=1e-3)
    frame.load(f"n{LONG}", fy=1e-9)
    solution = frame.solve()
    assert solution.status == "regular"
    expected = 0.25 + 1e-3 * LONG + 1e-9 * deflection(LONG)
    assert solution.displacement(f"n{LONG}")[1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("method", ["sparse", "banded", "broadcast"])
def test_a_mechanism_whose_support_settles(method: str) -> None:
    frame = chain(6, hinge=3)
    frame.prescribe("n0", uy=0.25)
    frame.load("n6", fz=1.0)
    solution = frame.solve(method)
    assert solution.status == "statically consistent mechanism"
    with pytest.warns(MechanismWarning):
        assert solution.displacement("n6")[2] == pytest.approx(deflection(6), rel=1e-12)
    frame.load("n6", fy=1.0)
    assert frame.solve(method).status == "mechanism"


def test_a_hinge_beside_soft_planes_is_found_alone() -> None:
    hinge = LONG // 2
    frame = chain(LONG, hinge=hinge)
    frame.load(f"n{LONG}", fz=1.0)
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    motion = solution.free_motion()
    assert motion.count == 1
    shape = np.array([motion.displacement(f"n{k}")[0] for k in range(0, LONG + 1, 100)])
    expected = np.maximum(np.arange(0.0, LONG + 1, 100.0) - hinge, 0.0) / (LONG - hinge)
    assert np.sign(shape[-1, 1]) * shape[:, 1] == pytest.approx(expected, abs=1e-9)
    assert np.delete(shape, [1, 5], axis=1) == pytest.approx(0.0, abs=1e-9)


def test_what_turns_about_itself() -> None:
    frame = chain(LONG, hinge=LONG // 2, release="start rx")
    frame.load(f"n{LONG}", fy=1.0)
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    motion = solution.free_motion()
    assert motion.count == 1
    ends = [motion.displacement(f"n{k}")[0, 3] for k in (LONG // 2, LONG)]
    assert ends[0] == pytest.approx(0.0, abs=1e-9)
    assert abs(ends[1]) == pytest.approx(1.0, abs=1e-9)


def test_soft_entries_of_a_batch() -> None:
    modulus = np.array([E, 2 * E, 3 * E])
    frame = chain(LONG, modulus=modulus)
    frame.load(f"n{LONG}", fy=1.0)
    solution = frame.solve()
    assert (solution.status == "regular").all()
    assert solution.displacement(f"n{LONG}")[:, 1] == pytest.approx(deflection(LONG, modulus), rel=1e-14)


def hinged(springs: np.ndarray) -> Frame:
    """Two chains in line, of 1200 beams each, with a hinge about z between them."""
    count = LONG // 2
    frame, other = chain(count), [f"m{k}" for k in range(count + 1)]
    frame.add_nodes(other, np.outer(count + np.arange(count + 1.0), [1.0, 0.0, 0.0]))
    frame.add_many(Beam(Circle(diameter=D), Material(E=E, nu=0.3)), list(pairwise(other)))
    stiffness = np.stack([np.full(len(springs), np.inf)] * 5 + [springs], axis=-1)
    frame.add("hinge", Joint(stiffness=stiffness), f"n{count}", "m0")
    return frame


def test_a_mechanism_beside_soft_entries_of_a_batch() -> None:
    springs, tip = np.array([0.0, 1.0, 1e9]), f"m{LONG // 2}"
    frame = hinged(springs)
    frame.load(tip, fz=1.0)
    solution = frame.solve()
    assert solution.status.tolist() == ["statically consistent mechanism", "regular", "regular"]
    assert solution.displacement(tip)[:, 2] == pytest.approx(np.full(3, deflection(LONG)), rel=1e-13)
    frame.load(tip, fy=1.0)
    assert frame.solve().status.tolist() == ["mechanism", "regular", "regular"]


def ratio(count: int, soft: float) -> tuple[Frame, float]:
    """A chain of which the half at the support is softer; and how far a force of 1 N moves its tip."""
    frame, half, stiff = chain(count), count // 2, np.pi * D**4 / 64.0 * E
    for k in range(half):
        frame.change(f"n{k}-n{k + 1}", Beam(Circle(diameter=D), Material(E=soft * E, nu=0.3)))
    return frame, ((count**3 - half**3) / soft + half**3) / (3.0 * stiff)


@pytest.mark.parametrize("soft", [1e-10, 1e-12])
def test_ratios_of_stiffness(soft: float) -> None:
    frame, expected = ratio(50, soft)
    frame.load("n50", fy=1.0)
    solution = frame.solve()
    assert solution.status == "regular"
    assert solution.displacement("n50")[1] == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("height", [1e-7, 1e-9])
def test_a_truss_that_is_all_but_flat(height: float) -> None:
    """Two bars of stiffness k in line but for their height: F / (2 k h^2), with the bending of neither."""
    count, frame = 40, Frame()
    rod = Beam(Circle(diameter=D), Material(E=E, nu=0.3))
    x = np.linspace(-1.0, 1.0, 2 * count + 1)
    names = [f"n{k}" for k in range(2 * count + 1)]
    frame.add_nodes(names, np.stack([x, (1.0 - np.abs(x)) * height, 0.0 * x], axis=-1))
    pairs = list(pairwise(names))
    for k in (0, count, 2 * count - 1):
        release = "start rz" if k < 2 * count - 1 else "end rz"
        frame.add(f"hinged {k}", Beam(rod.section, rod.material, release=(release,)), *pairs[k])
    frame.add_many(rod, [pair for k, pair in enumerate(pairs) if k not in (0, count, 2 * count - 1)])
    frame.fix("n0")
    frame.fix(names[-1])
    frame.load(f"n{count}", fy=1.0)
    solution = frame.solve()
    assert solution.status == "regular"
    stiffness = E * np.pi * D**2 / 4.0
    # what bends are the bars' ends at the supports, three inertias of a rod over its length
    assert solution.displacement(f"n{count}")[1] == pytest.approx(1.0 / (2.0 * stiffness * height**2), rel=1e-5)


def test_an_end_that_turns_freely_in_a_batch() -> None:
    """Nothing resists its rotation at any entry, though the pattern of the band couples it with what is loaded."""
    frame = chain(4, modulus=np.array([E, 2 * E, 3 * E]), hinge=3, release="end rz")
    frame.load("n4", fy=1.0)
    solution = frame.solve(method="banded")
    assert (solution.status == "statically consistent mechanism").all()
    assert solution.free_motion(1).count == 1
    assert abs(solution.free_motion(1).displacement("n4")[0, 5]) == pytest.approx(1.0)
