"""A structure that can move is an answer, not an error: status, what moves and where, NaN, one warning."""

from __future__ import annotations

import warnings
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, PointMass, Rectangle
from linkframe.framework import Frame, FrameError, MechanismWarning, Solution
from numpy.testing import assert_allclose
from numpy.typing import ArrayLike
from reference.as_frame import as_frame
from reference.compare import allowed, apart, stacked
from reference.four_bar import coordinates, four_bar
from reference.stiffness_method import solve

BEAM = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3))
PIN = Joint(stiffness=(np.inf,) * 5 + (0.0,))


def chain(*places: tuple[float, float, float]) -> Frame:
    """Members n0-n1-n2-... one after the other."""
    frame = Frame()
    for i, place in enumerate(places):
        frame.node(f"n{i}", place)
        if i:
            frame.add(f"m{i}", BEAM, f"n{i - 1}", f"n{i}")
    frame.load(f"n{len(places) - 1}", fy=1.0)
    return frame


def floating() -> Frame:
    """A bar without supports."""
    return chain((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))


def sliding() -> Frame:
    """A frame on rollers, free to move along x."""
    frame = chain((0.0, 0.0, 0.0), (0.0, 1.0, 0.0), (1.0, 1.0, 0.0), (1.0, 0.0, 0.0))
    frame.load("n1", fx=1.0)
    for foot in ("n0", "n3"):
        frame.fix(foot, "uy", "uz", "rx", "ry", "rz")
    return frame


def spinning() -> Frame:
    """A bar held at its ends by ball joints, free to turn about itself."""
    frame = chain((0.0, 0.0, 0.0), (0.6, 0.8, 0.0))
    frame.fix("n0", "ux", "uy", "uz")
    frame.fix("n1", "ux", "uy", "uz")
    return frame


def pendulum() -> Frame:
    """A bar on a pin."""
    frame = Frame()
    frame.node("ground", (0.0, 0.0, 0.0))
    frame.node("top", (0.0, 0.0, 0.0))
    frame.node("bob", (0.0, -1.0, 0.0))
    frame.add("pin", PIN, "ground", "top")
    frame.add("bar", BEAM, "top", "bob")
    frame.fix("ground")
    frame.load("bob", fx=1.0)
    return frame


def released() -> Frame:
    """A four-bar of releases: two columns and a girder, hinged at all four corners."""
    frame = Frame()
    for name, place in {"a": (0, 0, 0), "b": (0, 1, 0), "c": (2, 1, 0), "d": (2, 0, 0)}.items():
        frame.node(name, place)
    frame.add("ab", BEAM, "a", "b")
    frame.add("bc", Beam(BEAM.section, BEAM.material, release=("start rz", "end rz")), "b", "c")
    frame.add("cd", BEAM, "c", "d")
    for foot in ("a", "d"):
        frame.fix(foot, "ux", "uy", "uz", "rx", "ry")
    frame.load("b", fx=1.0)
    return frame


def folded() -> Frame:
    """The paper's linkage at 0 degrees with its crank clamped: coupler and rocker in line."""
    return as_frame(four_bar(coordinates(0.0), (0.0, 100.0, 0.0, 0.0, 0.0, 0.0)))


def detached() -> Frame:
    """A clamped bar, and beside it a mass that nothing holds."""
    frame = chain((0.0, 0.0, 0.0), (1.0, 0.0, 0.0))
    frame.fix("n0")
    frame.node("lost", (2.0, 0.0, 0.0))
    frame.add("ball", PointMass(1.0), "lost")
    frame.load("lost", fz=1.0)
    return frame


CASES: dict[str, tuple[Callable[[], Frame], tuple[str, ...], tuple[str, ...]]] = {
    "floating": (floating, ("n0", "n1"), ()),
    "sliding": (sliding, ("n0", "n1", "n2", "n3"), ("ux",)),
    "pendulum": (pendulum, ("bob",), ("ux", "rz")),
    "released": (released, ("b", "c"), ("ux",)),
    "folded": (folded, ("D.coupler", "D.rocker"), ("uy",)),
    "detached": (detached, ("lost",), ("uz",)),
}


@pytest.mark.parametrize("case", CASES)
def test_a_mechanism_says_what_moves(case: str) -> None:
    """Status "mechanism", the moving nodes and directions by name, NaN results, one MechanismWarning."""
    build, nodes, directions = CASES[case]
    solution = build().solve()
    with pytest.warns(MechanismWarning, match="kinematically unstable") as caught:
        displacement = solution.displacement(nodes[0])
    assert len(caught) == 1
    assert solution.status == "mechanism"
    assert np.isnan(displacement).all()
    text = solution.mechanism()
    for name in (*nodes, *directions):
        assert name in text
    for node in {"n0", "ground", "a", "A", "E"} & set(solution.frame.supports) - set(nodes):
        assert f"{node}:" not in text


READ: dict[str, Callable[[Solution], object]] = {
    "displacement": lambda s: s.displacement("bob"),
    "end_forces": lambda s: s.end_forces("bar"),
    "forces": lambda s: s.forces("bar", 0.1),
    "stress": lambda s: s.stress("bar", 0.1),
    "displacement_along": lambda s: s.displacement_along("bar", 0.1),
    "reaction": lambda s: s.reaction(next(iter(s.frame.supports))),
    "error_bound": lambda s: s.error_bound("bob"),
    "refined": lambda s: s.refined("bob"),
    "sensitivity": lambda s: s.sensitivity("bob", "ux"),
}


@pytest.mark.parametrize("what", READ)
def test_the_warning_points_to_who_reads(what: str) -> None:
    """One warning, at the line in this file, whatever is read first; nothing is said of what went on inside."""
    solution = pendulum().solve()
    with pytest.warns() as caught:
        READ[what](solution)
    assert [(each.category, each.filename) for each in caught] == [(MechanismWarning, __file__)]
    assert np.isinf(pendulum().solve().nonlinearity())


def test_the_warning_comes_once() -> None:
    """Reading more results of the same solution warns no more."""
    solution = pendulum().solve()
    with pytest.warns(MechanismWarning):
        solution.displacement("bob")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for values in (
            solution.displacement("top"),
            solution.reaction("ground"),
            solution.joint_force("pin"),
            solution.end_forces("bar"),
            solution.forces("bar", np.array([0.5])),
        ):
            assert np.isnan(values).any()


def test_status_is_read_without_a_warning() -> None:
    """Asking whether it is a mechanism is not reading a NaN."""
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert pendulum().solve().status == "mechanism"


def test_one_singular_pose_leaves_the_others_alone() -> None:
    """0, 180 and 360 degrees among 13 poses: NaN there, elsewhere what each pose gives alone."""
    angles = np.arange(0.0, 361.0, 30.0)
    each = [four_bar(coordinates(theta), (0.0, 100.0, 5.0, 0.0, 0.0, 0.0)) for theta in angles]
    frame = Frame()
    template = as_frame(each[1])
    for name in each[0].nodes:
        frame.node(name, np.array([structure.nodes[name] for structure in each]))
    for name, member in template.members.items():
        frame.add(name, member.element, member.start, member.end)
    for name, joint in template.joints.items():
        frame.add(name, joint.element, joint.first, joint.second)
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fy=100.0, fz=5.0)
    solution = frame.solve()
    singular = np.isin(angles, (0.0, 180.0, 360.0))
    assert np.array_equal(solution.status == "mechanism", singular)
    assert np.array_equal(solution.status == "regular", ~singular)
    with pytest.warns(MechanismWarning) as caught:
        u = np.stack([solution.displacement(name) for name in frame.nodes], axis=-2)
    assert len(caught) == 1
    # P's load reaches all nodes but the ground's.
    assert np.isnan(u[singular]).any(axis=(1, 2)).all()
    for pose in np.flatnonzero(~singular):
        assert apart(u[pose], stacked(solve(each[pose]).displacement)) < 1e-12
    assert "D.coupler" in solution.mechanism(6)


@pytest.mark.parametrize("angle", [1.0, 0.1, 0.01, 179.99])
def test_nearly_singular_is_not_singular(angle: float) -> None:
    """Close to the change point the linkage is soft, and solved, as exactly as its scaled condition number lets one."""
    structure = four_bar(coordinates(angle), (0.0, 100.0, 5.0, 0.0, 0.0, 0.0))
    solution = as_frame(structure).solve()
    assert solution.status == "regular"
    u = stacked({name: solution.displacement(name) for name in structure.nodes})
    assert apart(u, stacked(solve(structure).displacement)) <= allowed(solution.scaled_condition_number())


@pytest.mark.parametrize("stiffness", [1e-3, 1.0, 1e20])
def test_a_soft_or_a_hard_spring_is_not_a_mechanism(stiffness: float) -> None:
    """A pendulum on a torsion spring of 1e-3 N m/rad swings far and is regular: rz = F L/k."""
    frame = pendulum()
    frame.add("spring", Joint(stiffness=(0.0, 0.0, 0.0, 0.0, 0.0, stiffness)), "ground", "top")
    solution = frame.solve()
    assert solution.status == "regular"
    # The bar's own stiffness cancels out of the soft spring's equation: as exact as the condition allows.
    rtol = float(allowed(solution.scaled_condition_number()))
    assert_allclose(solution.displacement("top")[5], 1.0 / stiffness, rtol=rtol)


def test_freedom_that_no_load_finds_is_idle() -> None:
    """A bar on two ball joints may turn about itself; loaded at a support only that is said, and its results hold."""
    solution = spinning().solve()
    assert solution.status == "statically consistent mechanism"
    text = solution.mechanism()
    assert "n0" in text
    assert "rx" in text
    assert "uy" not in text
    assert_allclose(solution.reaction("n1")[:3], [0.0, -1.0, 0.0], rtol=1e-12, atol=1e-12)


def test_a_load_that_finds_it_makes_a_mechanism() -> None:
    """The same bar twisted about itself."""
    frame = spinning()
    frame.load("n1", mx=0.6, my=0.8)
    solution = frame.solve()
    assert solution.status == "mechanism"
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement("n1")).any()


def jointed(scale: ArrayLike) -> Frame:
    """A cantilever with a rotational spring in it, and a force at its end, in a unit of force of any size."""
    scale = np.asarray(scale)
    bar = Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9 * scale, nu=0.3))
    frame = Frame()
    for name, x in (("A", 0.0), ("B", 0.4), ("C", 0.4), ("D", 0.7)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", bar, "A", "B")
    frame.add("CD", bar, "C", "D")
    springs = [np.broadcast_to(np.inf, scale.shape)] * 5 + [50.0 * scale]
    frame.add("hinge", Joint(stiffness=np.stack(springs, axis=-1)), "B", "C")
    frame.fix("A")
    frame.load("D", fy=3.0 * scale)
    return frame


def test_status_and_displacement_in_every_unit_of_force() -> None:
    scales = [10.0**k for k in (-302, -299, -290, -200, -100, 0, 100, 200, 290)]
    wanted = 3.0 * (0.7**3 / (3.0 * 200e9 * 0.01 * 0.02**3 / 12.0) + 0.3**2 / 50.0)
    batch = jointed(scales).solve()
    assert (batch.status == "regular").all()
    assert_allclose(batch.displacement("D")[:, 1], wanted, rtol=1e-12)
    for scale in scales:
        alone = jointed(scale).solve()
        assert alone.status == "regular"
        assert_allclose(alone.displacement("D")[1], wanted, rtol=1e-12)


@pytest.mark.parametrize("scale", [1e-303, 1e-310, 1e-318])
def test_a_modulus_that_floats_cannot_hold_is_refused_and_no_mechanism(scale: float) -> None:
    told = r"Beam: E (A|I[yz]) = \S+ must be 1e-300 to 1e\+300, the range in which floats keep their digits; take"
    with pytest.raises(FrameError, match=told):
        jointed(scale)
    with pytest.raises(FrameError, match=told):
        jointed([1.0, scale])


@pytest.mark.parametrize("count", [(), (2,)])
def test_a_section_stiffer_than_floats_is_refused(count: tuple[int, ...]) -> None:
    plate = Rectangle(y=np.full(count, 1e3), z=1e3)
    with pytest.raises(FrameError, match=r"Beam: E A = \S+ must be 1e-300 to 1e\+300"):
        Beam(plate, Material(E=1e304, nu=0.3))
