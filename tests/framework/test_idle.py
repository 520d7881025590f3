"""Frames that can move though no load makes them: forces hold, and displacements but those that tell how far."""

from __future__ import annotations

import importlib.util
import re
import warnings
from collections.abc import Callable

import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning
from linkframe.framework.batch import Array
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

STEEL = Material(E=200e9, nu=0.3)
SECTION = Rectangle(y=0.02, z=0.03)
BAR = Beam(SECTION, STEEL)
HINGE = (np.inf,) * 5 + (0.0,)
WAYS = ["banded", "sparse", *(["cholesky"] if importlib.util.find_spec("cvxopt") else []), "iterative"]


def swinging(turn: Array, release: bool, scale: float = 1.0, at: tuple[float, float, float] = (0.0, 0.0, 0.0)) -> Frame:
    """A cantilever AB of 1 along x with a bar BC of 1 along x behind a hinge about z, turned in space and moved."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 1.0, "C": 2.0}.items():
        frame.node(name, turn @ (np.array([scale * x, 0.0, 0.0]) + at))
    up = tuple(turn @ [0.0, 0.0, 1.0])
    bar = Beam(Rectangle(y=0.02 * scale, z=0.03 * scale), STEEL, up=up)
    frame.add("AB", bar, "A", "B")
    if release:
        frame.add("BC", Beam(bar.section, STEEL, up=up, release=("start rz",)), "B", "C")
    else:
        frame.node("end", turn @ (np.array([scale, 0.0, 0.0]) + at))
        frame.add("hinge", Joint(stiffness=HINGE, axes=turn), "B", "end")
        frame.add("BC", bar, "end", "C")
    frame.fix("A")
    return frame


def loaded(frame: Frame, node: str, turn: Array, force: tuple[float, float, float], moment: float = 0.0) -> Frame:
    """With a force and a moment about z, both turned."""
    fx, fy, fz = turn @ force
    mx, my, mz = turn @ [0.0, 0.0, moment]
    frame.load(node, fx=fx, fy=fy, fz=fz, mx=mx, my=my, mz=mz)
    return frame


def silently(read: Callable[[], Array]) -> Array:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        return read()


def turns(count: int) -> list[Array]:
    """The identity, and random rotations."""
    return [np.eye(3), *Rotation.random(count, rng=np.random.default_rng(4)).as_matrix()]


@pytest.mark.parametrize("release", [True, False], ids=["release", "joint"])
@pytest.mark.parametrize("turn", turns(6))
def test_a_cantilever_with_an_idle_bar(turn: Array, release: bool) -> None:
    """B moves as if the bar were not there, ``F L^3 / 3 E I``; C as far as the hinge has no say in it."""
    frame = loaded(swinging(turn, release), "B", turn, (1e3, 20.0, -30.0), 7.0)
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    z, y = (200e9 * inertia for inertia in (SECTION.Iz, SECTION.Iy))
    slope, sink = 20.0 / (2.0 * z) + 7.0 / z, -30.0 / (3.0 * y)
    expected = [1e3 / (200e9 * SECTION.A), 20.0 / (3.0 * z) + 7.0 / (2.0 * z), sink, 0.0, 30.0 / (2.0 * y), slope]
    found = solution.displacement("B").reshape(2, 3) @ turn
    assert_allclose(found.reshape(6), expected, rtol=1e-11, atol=1e-13 * abs(sink))
    assert_allclose(solution.reaction("A").reshape(2, 3) @ turn, [[-1e3, -20.0, 30.0], [0.0, -30.0, -27.0]], atol=1e-9)
    assert_allclose(solution.end_forces("BC"), 0.0, atol=1e-9)
    assert solution.free_motion().solvable
    assert np.isinf(solution.error_bound("B")).all()
    with pytest.warns(MechanismWarning, match="statically consistent mechanism.*C"):
        swung = solution.displacement("C")
    assert_allclose(np.isnan(swung), np.abs(solution.free_motion().displacement("C")[0]) > 1e-9)
    if turn[0, 0] == 1.0:
        assert_allclose(np.isnan(swung), [False, True, False, False, False, True])
        assert_allclose(swung[[0, 2]], [expected[0], sink - 30.0 / (2.0 * y)], rtol=1e-11)


@pytest.mark.parametrize("release", [True, False], ids=["release", "joint"])
@pytest.mark.parametrize("turn", turns(6))
def test_a_bar_pulled_along_itself(turn: Array, release: bool) -> None:
    """A pull through the hinge does no work on it: the bar carries it, and does not swing, whatever way it stands."""
    solution = loaded(swinging(turn, release), "C", turn, (1e3, 0.0, 0.0)).solve()
    assert solution.status == "statically consistent mechanism"
    assert_allclose(solution.end_forces("BC")[[0, 6]], [-1e3, 1e3], rtol=1e-11)
    assert_allclose(solution.reaction("A")[:3] @ turn, [-1e3, 0.0, 0.0], atol=1e-8)
    if not release:
        assert_allclose(solution.joint_force("hinge"), [1e3, 0.0, 0.0, 0.0, 0.0, 0.0], atol=1e-8)
        assert_allclose(solution.joint_displacement("hinge"), 0.0, atol=1e-15)
    grown = 2.0 * 1e3 / (200e9 * SECTION.A)
    assert_allclose(solution.displacement("C").reshape(2, 3) @ turn, [[grown, 0.0, 0.0], [0.0] * 3], atol=1e-11 * grown)


@pytest.mark.parametrize("release", [True, False], ids=["release", "joint"])
@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e6])
@pytest.mark.parametrize("load", [1e-12, 1.0, 1e12])
def test_a_small_load_that_works_is_not_idle(release: bool, scale: float, load: float) -> None:
    """However large the one that does not work beside it, and whatever the units."""
    for turn in turns(3):
        frame = loaded(swinging(turn, release, scale), "B", turn, (load, load, load), load * scale)
        assert frame.solve().status == "statically consistent mechanism"
        solution = loaded(frame, "C", turn, (0.0, 1e-9 * load, 0.0)).solve()
        assert solution.status == "mechanism"
        assert not solution.free_motion().solvable


@pytest.mark.parametrize("turn", turns(3))
def test_far_from_the_origin(turn: Array) -> None:
    """Coordinates are rounded by their distance from the origin, and with them the direction of the bar."""
    far = (1e5, -2e5, 3e5)
    frame = loaded(swinging(turn, True, at=far), "C", turn, (1.0, 0.0, 0.0))
    assert frame.solve().status == "statically consistent mechanism"
    assert loaded(frame, "C", turn, (0.0, 1e-6, 0.0)).solve().status == "mechanism"


def test_a_batch_of_idle_regular_and_driven_entries() -> None:
    """Each for itself, and one warning for all."""
    frame = swinging(np.eye(3), False)
    spring = np.broadcast_to(HINGE, (3, 6)).copy()
    spring[1, 5] = 1e3
    other = Frame()
    for name, node in frame.nodes.items():
        other.node(name, node.coordinates)
    other.add("AB", BAR, "A", "B")
    other.add("hinge", Joint(stiffness=spring), "B", "end")
    other.add("BC", BAR, "end", "C")
    other.fix("A")
    other.load("B", fy=5.0)
    other.load("C", fy=[0.0, 1.0, 1.0])
    solution = other.solve()
    assert solution.status.tolist() == ["statically consistent mechanism", "regular", "mechanism"]
    with pytest.warns(MechanismWarning, match="1 of 3 .* and 1 more are statically consistent mechanisms") as told:
        moved = solution.displacement("C")
    tip = solution.displacement("B")
    assert len(told) == 1
    z = 200e9 * SECTION.Iz
    assert_allclose(tip[:2, 1], [5.0 / (3.0 * z), 6.0 / (3.0 * z) + 1.0 / (2.0 * z)], rtol=1e-10)
    assert np.isnan(tip[2]).all()
    assert np.isnan(moved[[0, 0, 2], [1, 5, 1]]).all()
    assert np.isfinite(moved[1]).all()
    assert np.isfinite(solution.error_bound("B")[1]).all()
    assert "Statically consistent mechanisms: 1 entries" in solution.explain()


def test_along_an_idle_bar() -> None:
    """At its hinge it moves with the cantilever, beyond it across it as it likes."""
    solution = loaded(swinging(np.eye(3), True), "B", np.eye(3), (0.0, 1.0, 0.0)).solve()
    found = silently(lambda: solution.displacement_along("BC", [0.0, 0.5, 1.0]))
    assert np.isfinite(found[0, :5]).all()
    assert np.isnan(found[1:, 1]).all()
    assert_allclose(found[:, [0, 2]], 0.0, atol=1e-15)
    assert_allclose(solution.forces("BC", [0.0, 0.5]), 0.0, atol=1e-12)


def test_many_idle_rods() -> None:
    """Rods between balls turn about themselves; a tripod of them carries its load by their axes alone."""
    frame = Frame()
    frame.node("top", (0.0, 0.0, 1.0))
    feet = np.array([[np.cos(a), np.sin(a), 0.0] for a in 2.0 * np.pi * np.arange(3) / 3.0])
    for k, foot in enumerate(feet):
        frame.node(f"foot{k}", foot)
        frame.node(f"end{k}", (0.0, 0.0, 1.0))
        frame.add(f"rod{k}", BAR, f"foot{k}", f"end{k}")
        frame.add(f"ball{k}", Joint(stiffness=(1e9,) * 3 + (0.0,) * 3), "top", f"end{k}")
        frame.fix(f"foot{k}", "ux", "uy", "uz")
    frame.fix("top", "rx", "ry", "rz")
    frame.load("top", fz=-300.0)
    solution = frame.solve()
    assert solution.status == "statically consistent mechanism"
    assert solution.free_motion().count == 3
    pressed = 100.0 * np.sqrt(2.0)
    for k in range(3):
        assert_allclose(solution.end_forces(f"rod{k}")[[0, 6]], [pressed, -pressed], rtol=1e-11)
    shortened = pressed * np.sqrt(2.0) / (200e9 * SECTION.A)
    assert solution.displacement("top")[2] < -shortened


def lattice(side: int, support: bool = True) -> Frame:
    """A cubic space frame, one corner of which may carry an idle bar."""
    frame = Frame()
    names = {}
    for place in np.ndindex(side, side, side):
        names[place] = str(place)
        frame.node(names[place], np.array(place, dtype=float))
        for axis in range(3):
            if place[axis]:
                before = tuple(np.array(place) - np.eye(3, dtype=int)[axis])
                frame.add(f"{before} {place}", BAR, names[before], names[place])
        if support and place[2] == 0:
            frame.fix(names[place])
    return frame


@pytest.mark.parametrize("method", WAYS)
def test_an_idle_bar_on_a_lattice(method: str) -> None:
    """The lattice moves as without it, in every way of solving; a force on the bar makes it a mechanism."""
    frame = lattice(3)
    frame.load("(2, 2, 2)", fx=1e3, mz=5.0)
    expected = frame.solve(method).displacement("(2, 2, 2)")
    frame.node("pivot", (2.0, 2.0, 2.0))
    frame.node("tip", (2.5, 2.7, 2.9))
    frame.add("hinge", Joint(stiffness=HINGE), "(2, 2, 2)", "pivot")
    frame.add("bar", BAR, "pivot", "tip")
    solution = frame.solve(method)
    assert solution.status == "statically consistent mechanism"
    assert_allclose(solution.displacement("(2, 2, 2)"), expected, rtol=1e-9, atol=1e-12 * np.abs(expected).max())
    found = silently(lambda: solution.displacement("tip"))
    assert_allclose(np.isnan(found), [True, True, False, False, False, True])
    assert_allclose(solution.end_forces("bar"), 0.0, atol=1e-7)
    frame.load("tip", fx=1e-6)
    assert frame.solve(method).status == "mechanism"


@pytest.mark.parametrize("method", [*WAYS, "broadcast"])
def test_a_lattice_without_supports_names_six_motions(method: str) -> None:
    """All rigid, in every way of solving."""
    frame = lattice(3 if method == "broadcast" else 6, support=False)
    frame.load("(0, 0, 0)", fx=1.0, fz=2.0)
    solution = frame.solve(method)
    with pytest.warns(MechanismWarning, match="free motion 6"):
        assert np.isnan(solution.displacement("(0, 0, 0)")).all()
    motion = solution.free_motion()
    assert motion.count == 6
    assert not motion.solvable
    names = ["(0, 0, 0)", "(1, 0, 0)", "(1, 2, 2)"]
    moved = {name: motion.displacement(name) for name in names}
    assert np.linalg.matrix_rank(np.hstack([moved[name] for name in names])) == 6
    for name in names[1:]:
        arm = frame.nodes[name].coordinates
        rigid = moved[names[0]][:, :3] + np.cross(moved[names[0]][:, 3:], arm)
        assert_allclose(moved[name][:, :3], rigid, atol=1e-9)


@pytest.mark.parametrize("stiffness", [1e3, 1e9, np.inf])
def test_a_load_whose_parts_balance_about_the_hinge(stiffness: float) -> None:
    """A force and a couple that do no work together, at any orientation; a billionth more of the force does."""
    for seed, turn in enumerate(turns(12)):
        rng = np.random.default_rng(seed)
        way, force = rng.normal(size=(2, 3))
        way /= np.linalg.norm(way)
        frame = Frame()
        for name, place in {"A": np.zeros(3), "B": np.eye(3)[0], "end": np.eye(3)[0], "C": np.eye(3)[0] + way}.items():
            frame.node(name, turn @ place)
        frame.add("AB", BAR, "A", "B")
        frame.add("hinge", Joint(stiffness=(stiffness,) * 5 + (0.0,), axes=turn), "B", "end")
        frame.add("BC", BAR, "end", "C")
        frame.fix("A")
        loaded(frame, "C", turn, tuple(force), -np.cross(way, force)[2])
        solution = frame.solve()
        assert solution.status == "statically consistent mechanism"
        assert_allclose(solution.reaction("A")[:3] @ turn, -force, atol=1e-8)
        across = np.cross([0.0, 0.0, 1.0], way)
        assert loaded(frame, "C", turn, tuple(1e-9 * across)).solve().status == "mechanism"


@pytest.mark.parametrize("short", [1e-3, 1e-5, 1e-8])
def test_a_short_member_is_no_freedom_of_what_no_load_reaches(short: float) -> None:
    """A short piece is stiff by its cube; across the plane, where nothing pulls, the frame is as firm as in it."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": 0.5, "C": 0.5 + short, "D": 1.0}.items():
        frame.node(name, (x, 0.0, 0.0))
    for ends in ("AB", "BC", "CD"):
        frame.add(ends, BAR, *ends)
    frame.fix("A")
    frame.load("D", fy=1.0)
    assert frame.solve().status == "regular"
    loose = frame.copy()
    loose.node("E", (1.0, 0.0, 0.0))
    loose.add("pin", Joint((np.inf, np.inf, np.inf, 0.0, np.inf, np.inf)), "D", "E")
    assert loose.solve().status == "statically consistent mechanism"


def test_rods_in_line_are_pulled_along_whatever_their_direction() -> None:
    """What rounded places leave of the force across the rods is no work: each bears all of it, and no entry is told to
    move."""
    angle = np.linspace(0.1, 6.2, 25)
    along = np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=-1)
    frame = Frame()
    for name, x in {"A": 0.0, "A1": 0.0, "B": 0.31, "B1": 0.31, "C": 0.73}.items():
        frame.node(name, x * along)
    for first, second in ("AB", "BC"):
        frame.add(f"hinge {first}", Joint(stiffness=HINGE), first, f"{first}1")
        frame.add(first, BAR, f"{first}1", second)
    frame.fix("A")
    frame.load("C", fx=1e3 * along[:, 0], fy=1e3 * along[:, 1])
    solution = frame.solve()
    assert set(solution.status.tolist()) == {"statically consistent mechanism"}
    assert_allclose(solution.forces("A", [0.0])[:, 0, 0], 1e3, rtol=1e-12)


@pytest.mark.parametrize("unit", [1e-9, 1.0, 1e3, 1e9, 1e12])
@pytest.mark.parametrize("force", [1.0, np.array([1.0, 2.0])])
def test_a_rod_that_spins_is_told_so_in_every_unit_of_length(unit: float, force: float | Array) -> None:
    """A rod of 10 m on a ball and a guide along x, in gigametres to picometres: it is pulled by ``F / cos``, moves by
    ``F L / (E A cos^2)`` at its guide, turns with it, and might spin about itself: that is across this turn."""
    steel, side = Material(E=200e9 / unit**2, nu=0.3), 0.02 * unit
    along = np.array([2.0, 3.0, 6.0]) / 7.0
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", 10.0 * unit * along)
    frame.add("AB", Beam(Rectangle(y=side, z=side), steel), "A", "B")
    frame.fix("A", "ux", "uy", "uz")
    frame.fix("B", "uy", "uz")
    frame.load("B", fx=force)
    solution = frame.solve()
    assert re.search(r"B \(.rx .ry .rz\)", solution.mechanism(*(() if np.ndim(force) == 0 else (0,))))
    moved = solution.displacement("B")
    turned = np.cross(along, moved[..., :3] / (10.0 * unit))
    assert_allclose(moved[..., 3:], turned, rtol=1e-12, atol=1e-12 * np.abs(turned).max())
    assert_allclose(moved[..., 0] / unit, force * 10.0 / (200e9 * 0.02**2 * along[0] ** 2), rtol=1e-12)
    assert_allclose(solution.forces("AB", [0.0])[..., 0, 0], force / along[0], rtol=1e-12)
    assert set(np.atleast_1d(solution.status)) == {"statically consistent mechanism"}
    assert np.isinf(solution.error_bound("B")[..., 0]).all()
