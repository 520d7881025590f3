"""Rigid links, ideal joints and supports that close loops, against very stiff springs in 50 digits."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from reference.as_frame import as_frame
from reference.compare import FORCES, allowed, apart, stacked
from reference.random_structures import constrained, few
from reference.stiffness_method import solve
from reference.structure import Structure

Array = NDArray[np.float64]
BEAM = Beam(Rectangle(y=0.03, z=0.02), Material(E=200e9, nu=0.3))
INF = np.inf


@few
@given(constrained)
def test_constrained_frames_agree_with_fifty_digits(structure: Structure) -> None:
    """Displacements to the numerical contract; reactions in equilibrium; joints and rigid links in any loops.

    The reference's constraints are springs 10^20 times stiffer than the rest: what moves by less than 1e-20 stands
    still. How redundant ideal joints and supports share a force is undetermined, so only its sum is asked for.
    """
    solution, truth = as_frame(structure).solve(), solve(structure)
    bound = allowed(solution.scaled_condition_number())
    exact = stacked(truth.displacement)
    exact[np.abs(exact) < 1e-20] = 0.0
    assert solution.status == "regular"
    assert apart(stacked({name: solution.displacement(name) for name in structure.nodes}), exact) <= bound
    acting = [(node, np.array(load)) for node, load in structure.loads.items()]
    acting += [(node, solution.reaction(node)) for node in structure.supports]
    total = np.sum([force for _, force in acting], axis=0)
    total[3:] += np.sum([np.cross(structure.nodes[node], force[:3]) for node, force in acting], axis=0)
    assert_allclose(total, 0.0, atol=float(FORCES * bound) * max(np.abs(force).max() for _, force in acting))


def lever(*links: tuple[str, str]) -> Frame:
    """Two cantilevers side by side whose tips and a third point are joined by rigid links."""
    frame = Frame()
    for name, y in {"low": 0.0, "high": 0.5}.items():
        frame.node(f"{name} wall", (0.0, y, 0.0))
        frame.node(name, (1.0, y, 0.1))
        frame.add(f"{name} beam", BEAM, f"{name} wall", name)
        frame.fix(f"{name} wall")
    frame.node("end", (1.5, 0.2, 0.0))
    for master, slave in links:
        frame.rigid(master, slave)
    frame.load("end", fx=10.0, fy=-200.0, fz=30.0, mx=4.0, my=-5.0, mz=6.0)
    return frame


@pytest.mark.parametrize(
    "links",
    [
        (("low", "high"), ("high", "end")),
        (("end", "low"), ("end", "high")),
        (("low", "high"), ("high", "end"), ("end", "low")),
        (("low", "high"), ("high", "low"), ("low", "end"), ("end", "high")),
    ],
    ids=["chain", "star", "ring", "doubled"],
)
def test_a_rigid_body_however_it_is_linked(links: tuple[tuple[str, str], ...]) -> None:
    """Chain, star, ring and doubled links describe one body: the same displacements and reactions."""
    solution, plain = lever(*links).solve(), lever(("low", "high"), ("low", "end")).solve()
    names = ("low", "high", "end")
    ours, theirs = (np.stack([s.displacement(name) for name in names]) for s in (solution, plain))
    assert apart(ours, theirs) < 1e-12
    walls = ("low wall", "high wall")
    ours, theirs = (np.stack([s.reaction(name) for name in walls]) for s in (solution, plain))
    assert apart(ours, theirs) < 1e-11
    assert_allclose(ours[:, :3].sum(axis=0), [-10.0, 200.0, -30.0], rtol=0, atol=1e-12 * np.abs(ours).max())


@pytest.mark.parametrize("turned", [False, True])
def test_two_equal_joints_side_by_side_are_one(turned: bool) -> None:
    """Ideal components given twice are redundant, springs add up; in turned axes too, where rounding hides it."""
    c, s = np.cos(0.3), np.sin(0.3)
    axes = np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]]) if turned else np.eye(3)

    def pair(*stiffness: tuple[float, ...]) -> Array:
        frame = Frame()
        for name, place in {"wall": (0, 0, 0), "a": (1, 0, 0), "b": (1, 0, 0), "tip": (2, 0.3, 0)}.items():
            frame.node(name, place)
        frame.add("in", BEAM, "wall", "a")
        frame.add("out", BEAM, "b", "tip")
        frame.fix("wall")
        for i, springs in enumerate(stiffness):
            frame.add(f"joint {i}", Joint(stiffness=springs, axes=axes), "a", "b")
        frame.load("tip", fx=10.0, fy=-20.0, fz=30.0, mx=4.0, my=-5.0, mz=6.0)
        solution = frame.solve()
        return np.stack([solution.displacement(name) for name in ("a", "b", "tip")])

    twice = pair((INF, 1e6, 2e6, 3e4, INF, 1e4), (INF, 2e6, INF, 1e4, INF, 3e4))
    assert apart(twice, pair((INF, 3e6, INF, 4e4, INF, 4e4))) < 1e-12


def test_supports_of_a_rigid_link_at_both_ends() -> None:
    """A beam on a rigid foot on two rollers: reactions by statics, no rotation of the foot."""
    frame = Frame()
    for name, place in {"left": (-0.5, 0, 0), "foot": (0, 0, 0), "right": (0.5, 0, 0), "tip": (0, 2, 0)}.items():
        frame.node(name, place)
    frame.add("mast", BEAM, "foot", "tip")
    frame.rigid("foot", "left", "right")
    frame.fix("left", "ux", "uy", "uz", "rx", "ry")
    frame.fix("right", "uy")
    frame.load("tip", fx=100.0, fy=-50.0)
    solution = frame.solve()
    assert_allclose(solution.reaction("left")[:2], [-100.0, 25.0 - 200.0], rtol=1e-12)
    assert_allclose(solution.reaction("right")[1], 25.0 + 200.0, rtol=1e-12)
    assert_allclose(solution.displacement("foot"), 0.0, atol=1e-18)
    assert_allclose(solution.displacement("tip")[0], 100.0 * 8 / (3 * 200e9 * 0.02 * 0.03**3 / 12), rtol=1e-12)


def test_contradicting_supports_of_a_rigid_link_are_refused() -> None:
    """Two ends of a rigid link prescribed to move apart: refused, naming the support and the amount."""
    frame = lever(("low", "high"), ("low", "end"))
    frame.prescribe("low", ux=0.0, uy=0.0)
    frame.prescribe("high", ux=0.0, uy=2e-3)
    with pytest.raises(FrameError) as error:
        frame.solve().displacement("end")
    for part in ("support", "contradicts", "0.002"):
        assert part in str(error.value)
