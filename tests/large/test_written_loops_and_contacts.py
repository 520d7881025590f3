"""Loops of springs and contact in clearances, written down as programs: against closed forms and the same by arrays."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame
from linkframe.framework.large import newton_program
from linkframe.framework.large.solution import LargeSolution
from linkframe.framework.program import machine_code
from linkframe.models import FourBar
from numpy.typing import NDArray

Array = NDArray[np.float64]
needs_llvm = pytest.mark.skipif(not machine_code.available(), reason="llvmlite is not installed")

INF = np.inf
STEEL = Material(E=200e9, nu=0.3)
BAR = Rectangle(y=0.02, z=0.01)
PLACES = [(0.2, 0.0, 0.3), (-0.1, 0.17, 0.3), (-0.1, -0.17, 0.35)]


def solved(frame: Frame, way: str) -> LargeSolution:
    """Solution by arrays, step by step by NumPy, or by machine code."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_program._Costs, "pay_compiled", lambda *_: way == "compiled")
        patch.setattr(newton_program._Costs, "pay_by_numpy", lambda *_: way != "arrays")
        solution = frame.solve(large=True)
        program = solution._load_stepping.newton.program
        assert (program is not None) == (way != "arrays")
        assert program is None or program.compiled == (way == "compiled")
        assert solution.iterations.shape == frame.shape
    return solution


def assert_alike(frame: Frame, node: str, way: str, rounding: float = 1e-12) -> LargeSolution:
    """What a program finds is what arrays find, in as many steps."""
    one, other = solved(frame, way), solved(frame, "arrays")
    assert (one.status == other.status).all()
    assert (one.iterations == other.iterations).all()
    found, wanted = one.displacement(node), other.displacement(node)
    assert (np.abs(found - wanted) <= rounding * np.abs(wanted).max(axis=-1, keepdims=True)).all()
    return one


def platform(stiffness: Array, force: Array, *options: dict[str, object]) -> Frame:
    """A rigid platform on three bushings, which close two loops of rigid links and springs."""
    frame = Frame()
    frame.node("P", (0.0, 0.0, 0.3))
    for k, place in enumerate(PLACES):
        for name in "GT":
            frame.node(f"{name}{k}", place)
        frame.fix(f"G{k}")
        frame.rigid("P", f"T{k}")
        given = options[k] if options else {}
        frame.add(f"bushing{k}", Joint(stiffness, **given), f"G{k}", f"T{k}")  # type: ignore[arg-type]
    frame.load("P", fx=force[:, 0], fy=force[:, 1], fz=force[:, 2])
    return frame


def pushed(count: int) -> Array:
    return np.array([300.0, 500.0, -900.0]) * np.random.default_rng(5).uniform(-1.0, 1.0, (count, 3))


@needs_llvm
def test_a_platform_on_balls_of_springs() -> None:
    """Balance of the forces of its springs and of their moments, solved to 50 digits."""
    springs = np.array([2e3, 2e3, 2e3, 0.0, 0.0, 0.0])
    force = pushed(8)
    solution = assert_alike(platform(springs, force), "P", "compiled")
    assert solution.model.loops
    moved = solution.displacement("P")
    assert np.abs(moved[:, 3:]).max() > 0.05
    with mpmath.workdps(50):
        arms = [mpmath.matrix([x, y, mpmath.mpf(z) - mpmath.mpf(0.3)]) for x, y, z in PLACES]

        def unbalanced(*unknown: mpmath.mpf) -> list[mpmath.mpf]:
            spin = mpmath.matrix([[0, -unknown[5], unknown[4]], [unknown[5], 0, -unknown[3]],
                                  [-unknown[4], unknown[3], 0]])  # fmt: skip
            angle = mpmath.sqrt(sum(x * x for x in unknown[3:]))
            turn = mpmath.sin(angle) / angle * spin + (1 - mpmath.cos(angle)) / angle**2 * spin * spin
            total = [-mpmath.mpf(float(each)) for each in force[0]] + [mpmath.mpf(0)] * 3
            for arm in arms:
                change = turn * arm
                push = [2000 * (unknown[k] + change[k]) for k in range(3)]
                lever = arm + change
                for k in range(3):
                    a, b = (k + 1) % 3, (k + 2) % 3
                    total[k] += push[k]
                    total[3 + k] += lever[a] * push[b] - lever[b] * push[a]
            return total

        exact = mpmath.findroot(unbalanced, moved[0].tolist())
        error = np.array([float(abs(x - y)) for x, y in zip(exact, moved[0].tolist(), strict=True)])
    assert (error < 3e-15).all()


def test_loops_of_all_kinds_of_springs() -> None:
    """A screw, a bushing in axes of its own, and one that is loose in rotation, by arrays and by a program."""
    rng = np.random.default_rng(2)
    springs = np.array([1e4, 2e4, 5e4, 30.0, 30.0, 9.0]) * rng.uniform(0.5, 2.0, (7, 1))
    axes = np.linalg.qr(rng.standard_normal((3, 3)))[0]
    loose = {"clearance": rng.uniform(1e-3, 1e-2, 7), "clearance_directions": ("rx", "ry")}
    frame = platform(springs, pushed(7), {"pitch": 0.01}, {"axes": axes * np.linalg.det(axes)}, loose)
    solution = assert_alike(frame, "P", "numpy")
    assert (solution.status == "stable").all()


def rigid_links(last: tuple[float, ...], force: Array) -> Frame:
    """A four-bar of rigid links on hinges, of which the last joints may be others, and the first has a spring."""
    frame, hinge = Frame(), (INF,) * 5 + (0.0,)
    places = {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.1, 0.0), "C": (0.2, 0.15, 0.0), "D": (0.2, 0.0, 0.0)}
    for name, place in places.items():
        frame.node(name, place)
        frame.node(f"{name}1", place)
    joints = {"A": (INF,) * 5 + (4.0,), "B": hinge, "C": last, "D": last}
    for (name, springs), following in zip(joints.items(), ("B", "C", "D", None), strict=True):
        frame.add(f"joint{name}", Joint(springs), name, f"{name}1")
        if following is not None:
            frame.rigid(f"{name}1", following)
    frame.fix("A")
    frame.fix("D1")
    frame.load("B", fx=force[:, 0], fy=force[:, 1], fz=force[:, 2])
    return frame


@pytest.mark.parametrize(
    ("last", "across", "way"),
    [((0.0, 0.0, 0.0), 0.0, "numpy"), ((1.0, 1.0, 0.0), 3.0, pytest.param("compiled", marks=needs_llvm))],
)
def test_ideal_joints_that_close_a_loop(last: tuple[float, ...], across: float, way: str) -> None:
    """In the plane the spring balances the load on the crank, by whose angle the loop of rigid links is closed."""
    force = np.array([[20.0, 3.0, across]]) * np.linspace(-1.0, 1.5, 9)[:, None]
    ideal = (INF, INF, INF) + (last if across else (INF, INF, 0.0))
    # arrays, which take eigenvalues, close the loop to some 1e-12
    solution = assert_alike(rigid_links(ideal, force), "C", way, rounding=1e-10)
    assert (solution.model.multipliers >= 0).any()
    assert (solution.status == "stable").all()
    crank = solution.displacement("B")
    assert np.abs(crank[:, 5]).max() > 0.3
    angle = np.pi / 2.0 + crank[:, 5]
    lever = 0.1 * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    assert crank[:, :2] == pytest.approx(lever - [0.0, 0.1], abs=1e-15)
    if not across:
        moment = lever[:, 0] * force[:, 1] - lever[:, 1] * force[:, 0]
        assert 4.0 * crank[:, 5] == pytest.approx(moment, abs=1e-13)
    rocker = solution.displacement("C")[:, :3] + np.array([0.2, 0.15, 0.0]) - [0.2, 0.0, 0.0]
    assert np.linalg.norm(rocker, axis=-1) == pytest.approx(0.15, rel=1e-14)


def test_redundant_constraints_are_left_to_the_arrays() -> None:
    """Four hinges hold a plane linkage out of its plane more often than needed."""
    force = np.array([[20.0, 3.0, 1.0]]) * np.linspace(0.1, 1.0, 2000)[:, None]
    frame = rigid_links((INF,) * 5 + (0.0,), force)
    assert "forbid what others forbid" in str(frame.solve(large=True).explain())
    assert solved(rigid_links((INF,) * 5 + (0.0,), force[::500]), "arrays").converged.all()


@pytest.mark.parametrize("stiffness", [1e9, INF])
def test_a_loose_bar_turns_into_the_force(stiffness: float) -> None:
    """B ends in the direction of the force, at the clearance, the bar and what the force draws them out from A."""
    clearance, length = np.geomspace(1e-5, 1e-2, 11), 0.5
    angle = np.radians(np.linspace(-100.0, 120.0, 11))
    ahead = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    frame = Frame()
    for name, x in (("A", 0.0), ("A1", 0.0), ("B", length)):
        frame.node(name, (x, 0.0, 0.0))
    springs = (stiffness, stiffness, INF, INF, INF, 1e-3)
    frame.add("bearing", Joint(springs, clearance=clearance, clearance_directions=("ux", "uy")), "A", "A1")
    frame.add("bar", Beam(BAR, STEEL), "A1", "B")
    frame.fix("A")
    frame.load("B", fx=1000.0 * ahead[:, 0], fy=1000.0 * ahead[:, 1])
    solution = solved(frame, "numpy")
    assert (solution.status == "stable").all()
    far = clearance + length + 1000.0 * length / (STEEL.E * 0.02 * 0.01) + 1000.0 / stiffness
    at = solution.displacement("B")[:, :2] + np.array([length, 0.0])
    assert np.linalg.norm(at, axis=-1) == pytest.approx(far, rel=1e-9)
    assert at / far[:, None] == pytest.approx(ahead, abs=1e-5)


@pytest.mark.parametrize(("stiffness", "way"), [pytest.param(1e9, "compiled", marks=needs_llvm), (INF, "numpy")])
def test_a_linkage_with_clearance(stiffness: float, way: str) -> None:
    """The same by arrays, entry by entry in any company, and by Newton's method alone."""
    theta = np.radians([20.0, 50.0, 80.0, 110.0, 140.0])[:, None]
    springs = (stiffness,) * 5 + (0.0,)

    def loose(some: slice) -> Frame:
        clearances = dict(zip("BDE", ([1e-5, 1e-4], 3e-5, [2e-4, 1e-6]), strict=True))
        motion = FourBar(beam=Beam(BAR, STEEL), stiffness=springs).move(theta[some])
        frame = motion.frame({name: np.asarray(each) for name, each in clearances.items()})
        frame.load("P", fy=np.array([-90.0, 150.0]))
        return frame

    whole = assert_alike(loose(slice(None)), "P", way)
    assert (whole.status == "stable").all()
    part = solved(loose(slice(1, 4)), way)
    assert (part.displacement("P") == whole.displacement("P")[1:4]).all()
    assert (part.status == whole.status[1:4]).all()
    if stiffness < INF:
        assert whole.iterations.max() <= 14


def test_one_step_leads_where_many_do() -> None:
    """Journals put on their circles strain the members, which must not throw the linkage into its other branch."""
    linkage = FourBar(beam=Beam(Rectangle(y=0.0105, z=0.0063), STEEL), stiffness=(1e9,) * 5 + (0.0,))
    loose = linkage.move(np.radians(19.4)).frame({"B": 6e-6, "D": 4e-6, "E": 1e-4})
    loose.load("P", fx=8.4, fy=-43.5)
    one, many = loose.solve(large=True), loose.solve(large=True, steps=12)
    assert one.displacement("P") == pytest.approx(many.displacement("P"), rel=1e-9, abs=1e-15)
    assert one.iterations <= 6


def test_each_choice_of_clearance_has_a_program_of_its_own() -> None:
    """Of frames alike in all else; one that is described again has the same."""

    def loose(directions: tuple[str, ...], rigid: bool) -> Frame:
        frame, springs = Frame(), [1e6] * 3 + [200.0] * 3
        if rigid:
            springs[:2] = INF, INF
        for name, x in (("A", 0.0), ("A1", 0.0), ("B", 0.5)):
            frame.node(name, (x, 0.0, 0.0))
        bearing = Joint(tuple(springs), clearance=np.array([1e-3, 2e-3]), clearance_directions=directions)
        frame.add("bearing", bearing, "A", "A1")
        frame.add("bar", Beam(BAR, STEEL), "A1", "B")
        frame.fix("A")
        frame.load("B", fx=50.0, fy=100.0, fz=70.0)
        return frame

    found = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(newton_program._Costs, "pay_compiled", lambda *_: False)
        patch.setattr(newton_program._Costs, "pay_by_numpy", lambda *_: True)
        for directions, rigid in ((("ux", "uy"), False), (("ux", "uz"), False), (("ux", "uy"), True)):
            for _ in range(2):
                program = loose(directions, rigid).solve(large=True)._load_stepping.newton.program
                assert program is not None
                found.append(id(program.recorded))
    assert found[::2] == found[1::2]
    assert len(set(found)) == 3
