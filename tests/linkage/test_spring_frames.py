"""The frame of a spring-loaded linkage: linear about the linkage without loads, exact at large displacement."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Circle, Material, Rectangle, Spring
from linkframe.framework import Frame
from linkframe.framework.batched.plan import Plan
from linkframe.framework.large.equations import EquilibriumEquations
from linkframe.framework.large.model import Model
from linkframe.framework.large.state import DisplacedState
from linkframe.models import Linkage
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import brentq

Array = NDArray[np.float64]
INF = np.inf
CRANK, ROD, DRAWN, RATE, FREE, ANCHOR = 0.1, 0.25, 0.9, 1000.0, 0.2, (0.5, 0.1)
TURNED = np.array([0.0, 0.5, 1.0, 2.0, 3.0])


def slider_crank(drive: float) -> Linkage:
    """A spring from the slider to the ground."""
    pin = CRANK * np.cos(DRAWN), CRANK * np.sin(DRAWN)
    linkage = Linkage(A=(0, 0), B=pin, C=(pin[0] + np.sqrt(ROD**2 - pin[1] ** 2), 0.0), Q=ANCHOR)
    linkage.link("crank", "A", "B")
    linkage.link("rod", "B", "C")
    linkage.link("slider", "C")
    linkage.revolute("A", "ground", "crank", stiffness=(INF,) * 5 + (drive,), drive=True)
    linkage.revolute("B", "crank", "rod")
    linkage.revolute("C", "rod", "slider")
    linkage.prismatic("C", "ground", "slider", axis=(1, 0), name="S")
    linkage.spring("C", ("ground", "Q"), stiffness=RATE, length=FREE)
    return linkage


def stretch(angle: object) -> object:
    """Of the spring, by the crank's angle."""
    slider = CRANK * mpmath.cos(angle) + mpmath.sqrt(ROD**2 - (CRANK * mpmath.sin(angle)) ** 2)
    return mpmath.sqrt((ANCHOR[0] - slider) ** 2 + ANCHOR[1] ** 2) - FREE


def by_pose(of_angle: object, order: int) -> Array:
    with mpmath.workdps(30):
        return np.array([float(mpmath.diff(of_angle, DRAWN + turn, order)) for turn in TURNED])


def energy(angle: object) -> object:
    return RATE / 2 * stretch(angle) ** 2  # type: ignore[operator]


def test_linear_displacement_under_the_force_at_rest() -> None:
    """What the spring exerts, by the stiffness of drive and spring along the motion, without that of turning."""
    frame = slider_crank(30.0).move(A=TURNED).frame()
    bare = 30.0 + RATE * by_pose(stretch, 1) ** 2
    assert_allclose(frame.solve().displacement("B")[:, 5], -by_pose(energy, 1) / bare, rtol=1e-9)
    more = frame.copy()
    more.load("B", mz=1e-3)
    gained = more.solve().displacement("B")[:, 5] - frame.solve().displacement("B")[:, 5]
    assert_allclose(gained, 1e-3 / bare, rtol=1e-9)


def test_large_displacement_is_the_equilibrium_of_the_potential() -> None:
    """The spring pulls along its line wherever it is; without loads it is slack, and nothing moves."""
    motion = slider_crank(30.0).move(A=TURNED)
    found = motion.frame().solve(large=True)
    wanted = [
        brentq(lambda d, t=turn: 30.0 * d + float(mpmath.diff(energy, DRAWN + t + d)), -1.0, 1.0, xtol=1e-14)
        for turn in TURNED
    ]
    assert found.stable.all()
    assert_allclose(found.displacement("B")[:, 5], wanted, rtol=1e-9)
    assert_allclose(found.joint_force("A")[:, 5], 30.0 * np.array(wanted), rtol=1e-9)
    assert not motion.frame(loads=False).solve(large=True).displacement("B").any()


def test_buckling_counts_that_the_spring_turns() -> None:
    """A stiff drive gives way where its stiffness is that of the loads: of spring, rod and crank together."""
    frame = slider_crank(1e9).move(A=TURNED).frame()
    taken = -RATE * np.array([float(mpmath.diff(stretch, DRAWN + t, 2) * stretch(DRAWN + t)) for t in TURNED])
    assert taken.max() > 1.0 > -1.0 > taken.min()
    wanted = np.where(taken > 0.0, 1e9 / np.abs(taken), INF)
    assert_allclose(frame.buckling(1).factors[:, 0], wanted, rtol=1e-6)


def loaded(seed: int, elastic: bool, free: ArrayLike | None = None) -> tuple[Linkage, list[str]]:
    """A four-bar with two springs, of random lengths without force where `free` does not give them."""
    rng = np.random.default_rng(seed)
    points = {
        "A": (0, 0, 0),
        "B": (0.1 + 0.05 * rng.random(), 0.2 + 0.1 * rng.random(), 0),
        "P": (0.3, 0.5 + 0.1 * rng.random(), 0),
        "C": (0.5 + 0.1 * rng.random(), 0.3, 0),
        "D": (0.6, 0, 0),
        "Q": tuple(rng.uniform(-0.5, 1.0, 3)),
    }
    linkage = Linkage(**points)
    bar = Beam(Rectangle(y=0.02, z=0.015), Material(E=200e9, nu=0.3)) if elastic else None
    linkage.link("crank", "A", "B", beam=bar)
    linkage.link("coupler", "B", "P", "C", beam=bar)
    linkage.link("rocker", "C", "D", beam=bar)
    linkage.revolute("A", "ground", "crank", stiffness=(INF,) * 5 + (rng.uniform(20.0, 200.0),), drive=True)
    pin = (1e7,) * 3 + (1e4, 1e4, 0.0)
    linkage.revolute("B", "crank", "coupler", stiffness=pin)
    linkage.revolute("C", "coupler", "rocker", stiffness=pin)
    linkage.revolute("D", "rocker", "ground", stiffness=pin)
    some = rng.uniform(0.1, 0.5, 2)
    given = some if free is None else np.asarray(free)
    linkage.spring(("coupler", "P"), ("ground", "Q"), stiffness=rng.uniform(100.0, 2e3), length=given[..., 0])
    linkage.spring(("crank", "B"), ("rocker", "D"), stiffness=rng.uniform(100.0, 2e3), length=given[..., 1])
    return linkage, ["B", "P", "C"]


def lengths(seed: int, turned: Array) -> Array:
    """Of both springs at every pose, (..., 2)."""
    linkage, _ = loaded(seed, elastic=False)
    motion = linkage.move(A=turned)
    spans = [motion.position("Q") - motion.position("P", "coupler"), motion.position("D") - motion.position("B")]
    return np.stack([np.linalg.norm(span, axis=-1) for span in np.broadcast_arrays(*spans)], axis=-1)


@settings(max_examples=8, deadline=None, derandomize=True)
@given(st.integers(0, 10_000), st.booleans())
def test_the_stiffness_of_the_frame_is_that_of_springs_without_force(seed: int, elastic: bool) -> None:
    turned = np.array([-0.1, 0.0, 0.1])
    linkage, points = loaded(seed, elastic)
    frame = linkage.move(A=turned).frame()
    slack, _ = loaded(seed, elastic, lengths(seed, turned))
    motion = slack.move(A=turned)
    assert np.abs(motion.frame().solve().displacement("P")).max() < 1e-12
    for point in points:
        wanted = motion.compliance_matrix(point)
        units = frame.copy()
        unit = np.eye(6).reshape(6, 1, 6)
        units.load(point, **{name: unit[..., k] for k, name in enumerate(("fx", "fy", "fz", "mx", "my", "mz"))})
        found = units.solve().displacement(point) - frame.solve().displacement(point)
        assert_allclose(np.moveaxis(found, 0, -1), wanted, atol=1e-8 * np.abs(wanted).max())


@settings(max_examples=4, deadline=None, derandomize=True)
@given(st.integers(0, 10_000))
def test_little_forces_at_large_displacement_are_linear(seed: int) -> None:
    turned = np.array([-0.1, 0.1])
    linkage, points = loaded(seed, True, lengths(seed, turned) - 1e-6 * np.array([1.0, -2.0]))
    frame = linkage.move(A=turned).frame()
    linear, large = frame.solve(), frame.solve(large=True)
    for point in points:
        wanted = linear.displacement(point)
        assert np.abs(wanted).max() > 1e-9
        assert_allclose(large.displacement(point), wanted, atol=1e-4 * np.abs(wanted).max())


def test_forces_and_tangent_of_a_spring_that_turns() -> None:
    """At a state far from rest they are the derivatives of energy and forces."""
    frame = Frame()
    for name, place in {"A": (0, 0, 0), "B": (1, 0.2, 0.1), "C": (0.3, 1, 0.5)}.items():
        frame.node(name, place)
    frame.add("AB", Beam(Circle(diameter=0.1), Material(E=1e5, nu=0.3), segments=2), "A", "B")
    frame.add("CB", Spring(100.0, [50.0, -30.0], applied=True), "C", "B")
    frame.fix("A")
    frame.fix("C")
    chord = np.array([0.7, -0.8, -0.4]) / np.linalg.norm([0.7, -0.8, -0.4])
    frame.load(
        "B", **{name: -np.array([50.0, -30.0]) * part for name, part in zip(("fx", "fy", "fz"), chord, strict=True)}
    )
    model = Model(Plan(frame, cut=True))
    equations = EquilibriumEquations(model, (np.arange(2),), 2)
    step = 0.3 * np.random.default_rng(1).standard_normal((model.size, 2))
    state = equations.advanced(DisplacedState.start(model, 2), step)
    at = equations.linearised(state)
    tangent = np.zeros((model.size, model.size, 2))
    tangent[model.pattern[1:]] = at.values
    for k in range(model.size):
        unit = np.zeros((model.size, 2))
        unit[k] = 1e-6
        near = [equations.advanced(state, sign * unit) for sign in (1.0, -1.0)]
        ahead, behind = (equations.energy(there) for there in near)
        assert (ahead - behind) / 2e-6 == pytest.approx(at.forces[k], abs=1e-7 * np.abs(at.forces).max())
        one, other = (equations.linearised(there).forces for there in near)
        assert (one - other) / 2e-6 == pytest.approx(tangent[:, k], abs=1e-8 * np.abs(tangent).max())
