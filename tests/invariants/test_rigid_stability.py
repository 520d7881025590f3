"""Rigid links, joints and moments carry geometric stiffness: buckling, its limit in beams, the range of linear results.

Closed forms of rigid chains: Bažant & Cedolin, *Stability of Structures*, 1991, ch. 4; Ziegler, *Principles of
Structural Stability*, 1968. Strips: Timoshenko & Gere, *Theory of Elastic Stability*, 2nd ed., ch. 6. Right-angle
frame: Argyris et al., Comput. Methods Appl. Mech. Engrg. 20 (1979) 105-131.
"""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Joint, Material, PointMass, Section
from linkframe.framework import Frame
from linkframe.models.paper.inputs import Inputs
from linkframe.models.paper.result import compute
from numpy.testing import assert_allclose
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
INF = np.inf
STEEL = Material(E=200e9, nu=0.3)
FORCES, MOMENTS = ("fx", "fy", "fz"), ("mx", "my", "mz")


def turn(seed: int) -> Array:
    return np.asarray(Rotation.random(random_state=seed).as_matrix())


def load(frame: Frame, node: str, force: Array, moment: Array | None = None) -> None:
    frame.load(node, **dict(zip(FORCES, force, strict=True)))
    if moment is not None:
        frame.load(node, **dict(zip(MOMENTS, moment, strict=True)))


def chain(
    stiffness: list[float], axes: Array, push: float | Array = 1.0, beam: Beam | None = None, backward: bool = False
) -> Frame:
    """Bars of length 1 in line, a rotational spring about z at the foot of each, pushed along the line."""
    frame = Frame()
    frame.node("foot", (0.0, 0.0, 0.0))
    frame.fix("foot")
    before = "foot"
    for k, spring in enumerate(stiffness):
        start, end = f"a{k}", f"b{k}"
        frame.node(start, axes[:, 0] * k)
        frame.node(end, axes[:, 0] * (k + 1))
        frame.add(f"hinge{k}", Joint((INF,) * 5 + (spring,), axes=axes), before, start)
        if beam is not None:
            frame.add(f"bar{k}", beam, start, end)
        else:
            frame.rigid(*((end, start) if backward else (start, end)))
        before = end
    load(frame, before, -np.multiply.outer(axes[:, 0], push))
    return frame


def closed_form(stiffness: list[float]) -> Array:
    """Factors of a pushed chain: springs on differences of the bars' angles against the shortening of the bars."""
    count = len(stiffness)
    change = np.eye(count) - np.eye(count, k=-1)
    return np.sort(np.linalg.eigvalsh(change.T @ np.diag(stiffness) @ change))


@pytest.mark.parametrize("backward", [False, True])
@pytest.mark.parametrize("axes", [np.eye(3), turn(1)], ids=["level", "turned"])
def test_rigid_chains(axes: Array, backward: bool) -> None:
    """A bar on a spring; two bars, (3 -+ sqrt 5) / 2 times k / l; three bars on unequal springs."""
    assert_allclose(chain([100.0], axes, backward=backward).buckling(1).factors, [100.0], rtol=1e-12)
    golden = (3.0 + np.array([-1.0, 1.0]) * np.sqrt(5.0)) / 2.0
    assert_allclose(chain([7.0, 7.0], axes, backward=backward).buckling(2).factors, 7.0 * golden, rtol=1e-12)
    springs = [3.0, 50.0, 0.2]
    found = chain(springs, axes, backward=backward).buckling(3).factors
    assert_allclose(found, closed_form(springs), rtol=1e-11)


def test_a_pulled_chain_does_not_buckle_and_loads_are_a_batch() -> None:
    factors = chain([100.0], turn(2), push=np.array([-1.0, 0.0, 50.0])).buckling(1).factors
    assert_allclose(factors[:, 0], [INF, INF, 2.0], rtol=1e-12)


def test_a_large_frame_of_rigid_bars() -> None:
    """Eighty bars, more unknowns than go the dense way where each joint has six springs."""
    count = 80
    frame = Frame()
    frame.node("foot", (0.0, 0.0, 0.0))
    frame.fix("foot")
    for k in range(count):
        frame.node(f"a{k}", (k, 0.0, 0.0))
        frame.node(f"b{k}", (k + 1.0, 0.0, 0.0))
        frame.add(f"hinge{k}", Joint((1e6,) * 3 + (1e6, 1e6, 10.0)), f"b{k - 1}" if k else "foot", f"a{k}")
        frame.rigid(f"a{k}", f"b{k}")
    frame.load(f"b{count - 1}", fx=-1.0)
    assert_allclose(frame.buckling(1).factors, closed_form([10.0] * count)[:1], rtol=1e-3)


@pytest.mark.parametrize("seed", range(3))
def test_a_rigid_arm_on_six_springs_in_space(seed: int) -> None:
    """An arm off every axis: the potential's second differences, with the rotation as a matrix, say the same."""
    rng = np.random.default_rng(seed)
    arm, force = rng.normal(size=3), rng.normal(size=3)
    frame = Frame()
    for name, place in {"G": np.zeros(3), "A": np.zeros(3), "B": arm}.items():
        frame.node(name, place)
    frame.fix("G")
    frame.add("ball", Joint((INF,) * 3 + (200.0,) * 3), "G", "A")
    frame.rigid("A", "B")
    load(frame, "B", force)

    def work(vector: Array) -> float:
        return float(force @ (Rotation.from_rotvec(vector).apply(arm) - arm))

    h, basis = 1e-3, np.eye(3)
    second = np.array(
        [
            [sum(s * t * work(h * (s * a + t * b)) for s in (1, -1) for t in (1, -1)) / (4 * h * h) for b in basis]
            for a in basis
        ]
    )
    taken = np.sort(np.linalg.eigvalsh(second))[::-1]
    found = frame.buckling(3).factors
    assert_allclose(found, np.where(taken > 0.0, 200.0 / np.abs(taken), INF), rtol=1e-5)


def random_model(seed: int, modulus: float | None, axes: Array) -> Frame:
    """A path, perhaps closed, of arms in any direction on joints of any axes and stiffness, with slender beams between.

    Arms are rigid links, or beams of `modulus`.
    """
    rng = np.random.default_rng(seed)
    soft = Beam(Circle(diameter=0.02), STEEL, segments=2)
    frame, place = Frame(), np.zeros(3)

    def node(name: str, at: Array) -> None:
        frame.node(name, axes @ at)

    node("r0", place)
    frame.fix("r0")
    count = int(rng.integers(2, 4))
    for k in range(count):
        end = place + 0.3 * rng.normal(size=3)
        node(f"a{k}", place)
        node(f"b{k}", end)
        springs = 10.0 ** rng.uniform(2.0, 3.0, 6)
        springs[:3] = INF if rng.random() < 0.5 else 1e6
        springs[3:][rng.random(3) < 0.3] = INF
        own = axes @ Rotation.random(random_state=int(rng.integers(1000))).as_matrix()
        frame.add(f"joint{k}", Joint(springs, axes=own), f"r{k}", f"a{k}")
        forward = rng.random() < 0.5
        if modulus is not None:
            frame.add(f"arm{k}", Beam(Circle(diameter=0.05), Material(E=modulus, nu=0.3)), f"a{k}", f"b{k}")
        else:
            frame.rigid(*((f"a{k}", f"b{k}") if forward else (f"b{k}", f"a{k}")))
        place = end + 0.3 * rng.normal(size=3)
        node(f"r{k + 1}", place)
        frame.add(f"member{k}", soft, f"b{k}", f"r{k + 1}")
    load(frame, f"r{count}", axes @ rng.normal(size=3), axes @ (0.1 * rng.normal(size=3)))
    if rng.random() < 0.5:
        node("held", place + np.array([0.1, 0.2, 0.3]))
        frame.fix("held")
        frame.add("closing", soft, f"r{count}", "held")
    return frame


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_rigid_links_are_the_limit_of_stiff_beams(seed: int) -> None:
    """Factors and estimates of linearity converge like one over the modulus; and turning the model changes nothing."""
    rigid = random_model(seed, None, np.eye(3))
    factors = rigid.buckling(2).factors
    assert np.isfinite(factors[0])
    off = [
        np.abs(random_model(seed, modulus, np.eye(3)).buckling(2).factors / factors - 1.0).max()
        for modulus in (1e13, 1e15)
    ]
    assert off[1] < 1e-4
    assert off[1] < 0.05 * off[0] + 1e-7
    assert_allclose(random_model(seed, None, turn(seed)).buckling(2).factors, factors, rtol=1e-6)
    estimate = rigid.solve().nonlinearity()
    assert random_model(seed, 1e15, np.eye(3)).solve().nonlinearity() == pytest.approx(estimate, rel=0.5)
    assert estimate > 0.0


@settings(max_examples=6, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_linear_results_end_at_the_first_buckling_load(seed: int) -> None:
    """Of any model, whatever is displaced on the way: by its factor, and alike for rigid links and for stiff beams."""
    for modulus in (None, 1e13):
        frame = random_model(seed, modulus, np.eye(3))
        shares = frame.buckling(1).factors[0] * np.array([0.1, 0.98, 1.02, 3.0])
        (node, given), *_ = frame.copy().loads.items()
        frame.loads.clear()
        for k, value in given:
            frame.load(node, **{(FORCES + MOMENTS)[k]: shares * value})
        assert np.isinf(frame.solve().nonlinearity()).tolist() == [False, False, True, True]


@pytest.mark.parametrize("axes", [np.eye(3), turn(3)], ids=["level", "turned"])
def test_strips_buckle_sideways(axes: Array) -> None:
    """A force or a semitangential moment at the end, a load along it: 4.0126, pi, 12.85 (of length and stiffness 1)."""
    strip = Section(A=1e4, Iy=1.0, Iz=1e4, J=2.0)
    least = []
    for kind, vector in (("f", [0.0, -1.0, 0.0]), ("m", [0.0, 0.0, 1.0]), ("line", [0.0, -1.0, 0.0])):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", axes[:, 0])
        frame.add("AB", Beam(strip, Material(E=1.0, nu=0.0), segments=16, up=axes[:, 2]), "A", "B")
        frame.fix("A")
        given_load = axes @ np.array(vector)
        if kind == "line":
            frame.line_load("AB", **dict(zip(FORCES, given_load, strict=True)))
        else:
            frame.load("B", **{kind + name: value for name, value in zip("xyz", given_load, strict=True)})
        least.append(frame.buckling(1).factors[0])
    assert_allclose(least, [4.0126, np.pi, 12.85], rtol=6e-3)


def test_the_right_angle_frame() -> None:
    """1.09 and 0.68, pushed either way."""
    section = Section(A=18.0, Iy=30.0 * 0.6**3 / 12, Iz=0.6 * 30.0**3 / 12, J=30.0 * 0.6**3 / 3)
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (240, 0, 0), "C": (240, -240, 0)}.items():
        frame.node(name, place)
    for name in ("AB", "BC"):
        frame.add(name, Beam(section, Material(E=71240.0, nu=0.31), segments=16, up=(0, 0, 1)), *name)
    frame.fix("A")
    frame.load("C", fx=np.array([1.0, -1.0]))
    assert_allclose(frame.buckling(1).factors[:, 0], [1.088, 0.680], rtol=2e-3)


def test_factors_are_where_the_large_displacement_tangent_gives_way() -> None:
    """A rigid cross of arms on a ball of springs under loads in equilibrium: stable below the factor, not above it."""
    rng = np.random.default_rng(5)
    for _ in range(3):
        axes, arms = turn(int(rng.integers(1000))), rng.normal(size=(2, 3))
        frame = Frame()
        for name, place in {"G": np.zeros(3), "A": np.zeros(3), "B": arms[0], "C": -arms[0], "D": arms[1]}.items():
            frame.node(name, place)
        frame.fix("G")
        frame.add("ball", Joint((1e9,) * 3 + tuple(rng.uniform(50.0, 90.0, 3)), axes=axes), "G", "A")
        for name in "BCD":
            frame.rigid("A", name)
        # opposite forces along and across the arms, without a resultant moment
        force = -10.0 * arms[0]
        load(frame, "B", force)
        load(frame, "C", -force)
        load(frame, "D", -5.0 * arms[1])
        factor = frame.buckling(1).factors[0]
        for share, stable in ((0.99, True), (1.01, False)):
            scaled = frame.copy()
            scaled.loads.clear()
            load(scaled, "B", share * factor * force)
            load(scaled, "C", -share * factor * force)
            load(scaled, "D", -5.0 * share * factor * arms[1])
            solution = scaled.solve(large=True)
            assert (str(solution.status) == "stable") == stable


def test_weights_on_arms_and_sliders_push_over() -> None:
    """A weight on an arm above a spring: m g h; on a slider across a turning guide, its share of the swing."""
    frame = Frame()
    for name in ("G", "A"):
        frame.node(name, (0.0, 0.0, 0.0))
    frame.fix("G")
    frame.add("hinge", Joint((INF,) * 5 + (100.0,)), "G", "A")
    frame.add("weight", PointMass(2.0, offset=(0.0, 0.5, 0.0)), "A")
    frame.gravity((0.0, -10.0, 0.0))
    assert_allclose(frame.buckling(1).factors, [100.0 / (2.0 * 10.0 * 0.5)], rtol=1e-12)
    # V = c a^2 / 2 + k t^2 / 2 - P (t sin a): the slider's t and the guide's angle a, coupled by the force across
    frame = Frame()
    for name in ("G", "A", "B"):
        frame.node(name, (0.0, 0.0, 0.0))
    frame.fix("G")
    frame.add("hinge", Joint((INF,) * 5 + (100.0,)), "G", "A")
    frame.add("slider", Joint((400.0,) + (INF,) * 5), "A", "B")
    frame.load("B", fy=1.0)
    assert_allclose(frame.buckling(1).factors, [np.sqrt(100.0 * 400.0)], rtol=1e-12)


def test_linear_results_of_rigid_links_say_where_they_end() -> None:
    """Near its buckling load a bar moves 1 / (1 - share) times as far as linear mechanics says."""
    share = np.array([1e-4, 0.01, 0.2, 0.9])
    frame = chain([100.0], np.eye(3), push=100.0 * share)
    frame.load("b0", fy=1e-3)
    solution = frame.solve()
    large = frame.solve(large=True).displacement("b0")[:, 1]
    assert_allclose(solution.nonlinearity(), 1.0 - solution.displacement("b0")[:, 1] / large, rtol=1e-3, atol=1e-6)
    assert solution.linear.tolist() == [True, True, False, False]


@pytest.mark.parametrize("seed", range(4))
def test_displacements_that_are_rounding_are_not_beyond_linear(seed: int) -> None:
    """A bar pushed exactly along its axis, which lies askew: what moves is rounding, however near it is to buckling.

    Beyond that load it is unstable, which its displacement does not tell.
    """
    axes, share = turn(seed), np.array([0.5, 0.9, 0.99, 1.01, 7.5])
    frame = Frame()
    for name, place in {"G": np.zeros(3), "A": np.zeros(3), "B": axes[:, 0]}.items():
        frame.node(name, place)
    frame.fix("G")
    frame.add("ball", Joint((INF,) * 3 + (100.0,) * 3), "G", "A")
    frame.rigid("A", "B")
    load(frame, "B", -100.0 * np.multiply.outer(axes[:, 0], share))
    solution = frame.solve()
    assert np.abs(solution.displacement("B")).max() < 1e-13
    assert_allclose(solution.nonlinearity(), np.where(share < 1.0, 0.0, INF), atol=1e-13)
    assert_allclose(frame.buckling(1).factors[:, 0] * share, 1.0, rtol=1e-9)


def test_a_spread_that_is_rounding_is_not_beyond_linear() -> None:
    """At 90 degrees the parallelogram's P moves along y alone: in x there is a spread of second order only."""
    inputs = Inputs(samples=20, clearance=0.0, clearance_sd=0.0, load=1e-6, poses=(60.0, 120.0, 30.0))
    result = compute(inputs)
    assert result.std[1, 0] < 1e-12
    assert result.marked_status.tolist() == ["regular"] * 3


def bar_on_hinge(direction: Array, across: Array, push: float, side: float, beam: bool, swapped: bool) -> Frame:
    """A bar pushed along its axis with a little force across."""
    frame = Frame()
    for name, place in {"G": np.zeros(3), "A": np.zeros(3), "B": direction}.items():
        frame.node(name, place)
    axes = np.stack([direction, across, np.cross(direction, across)], axis=-1)
    frame.fix("G")
    frame.add("hinge", Joint((INF,) * 5 + (100.0,), axes=axes), *(("A", "G") if swapped else ("G", "A")))
    if beam:
        frame.add("bar", Beam(Circle(diameter=0.1), Material(E=1e10, nu=0.3)), "A", "B")
    else:
        frame.rigid("A", "B")
    load(frame, "B", side * across - push * direction)
    return frame


@pytest.mark.parametrize("direction", [0, 1])
@pytest.mark.parametrize("side", [0.0, 1e-5, -1e-5])
def test_beyond_buckling_rigid_links_and_beams_go_to_one_side(direction: int, side: float) -> None:
    """To that of the load across, however small; without one to a side that does not depend on what the bar is."""
    axes = np.roll(np.eye(3), direction, axis=1)
    ways = [(False, False), (False, True), (True, False), (True, True)]
    frames = [bar_on_hinge(axes[:, 0], axes[:, 1], 110.0, side, beam, swapped) for beam, swapped in ways]
    found = np.array([float(frame.solve(large=True).displacement("B")[:3] @ axes[:, 1]) for frame in frames])
    assert_allclose(found, found[0], rtol=2e-2)
    assert abs(found[0]) == pytest.approx(0.68090, rel=1e-4)
    if side:
        assert np.sign(found[0]) == np.sign(side)


@pytest.mark.parametrize("seed", range(4))
def test_a_rigid_bar_askew_leaves_its_unstable_equilibrium(seed: int) -> None:
    """Beyond buckling it does not stay where only rounding moves it, and a load across tells its side."""
    axes = turn(seed)
    for side in (0.0, 1e-5, -1e-5):
        solution = bar_on_hinge(axes[:, 0], axes[:, 1], 110.0, side, beam=False, swapped=False).solve(large=True)
        moved = float(solution.displacement("B")[:3] @ axes[:, 1])
        assert solution.stable
        assert abs(moved) == pytest.approx(0.68090, rel=1e-4)
        assert np.sign(moved) == np.sign(side) or not side
