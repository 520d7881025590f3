"""Frames of one entry: the first of a topology, later ones, and those changed in place have the same results."""

from __future__ import annotations

import pickle
import re
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, MechanismWarning, Solution
from linkframe.framework.batched import entry_machine, entry_recording
from linkframe.framework.batched.entry_program import Way
from linkframe.framework.cache import PROGRAMS, STACKS
from linkframe.models import Linkage
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Array = NDArray[np.float64]
STEEL = Material(E=200e9, nu=0.3, density=7850.0)
PIN = (2e11, 2e11, 2e11, 2e11, 2e11, 0.0)
# Frames of a topology after which its program surely is there.
MET = 6


@pytest.fixture(autouse=True)
def _nothing_known() -> Iterator[None]:
    PROGRAMS.clear()
    yield
    PROGRAMS.clear()


def four_bar(angle: float = 0.7, stiffness: float = 2e11, force: float = 100.0, lift: float = 0.0) -> Frame:
    """Crank, coupler and rocker, all joints compliant."""
    x, y = 0.1 * np.cos(angle), 0.1 * np.sin(angle)
    places = {"A": (0, 0), "B": (x, y), "P": (x + 0.1, y + lift), "D": (x + 0.2, y), "E": (0.2, 0)}
    frame, bar = Frame(), Beam(Rectangle(y=0.0127, z=0.00635), STEEL)
    for name in ("A", "B", "B'", "P", "D", "D'", "E'", "E"):
        frame.node(name, (*places[name[0]], 0.0))
    for start, end in (("A", "B"), ("B'", "P"), ("P", "D"), ("D'", "E'")):
        frame.add(start + end, bar, start, end)
    for name, start, end in (("b", "B", "B'"), ("d", "D", "D'"), ("e", "E'", "E")):
        frame.add(name, Joint(stiffness=(*(stiffness,) * 5, 0.0)), start, end)
    frame.fix("A")
    frame.fix("E")
    frame.load("P", fy=force)
    return frame


def all_kinds(seed: int) -> Frame:
    """A frame with all that can be described, its numbers random: bodies, turned joints, screws, ties, all loads."""
    rng = np.random.default_rng(seed)
    frame = Frame()
    frame.body("arm", rng.normal(size=3), Rotation.random(rng=rng).as_matrix())
    frame.body("spin", axes=Rotation.from_rotvec([0.0, 0.0, rng.uniform(0.1, 3.0)]).as_matrix())
    first, second, third = rng.normal(size=(3, 3))
    frame.node("a", first, body="arm")
    frame.node("b", second, body="arm")
    frame.node("c", frame.position("b"))
    frame.node("d", third)
    frame.node("e", frame.bodies["spin"].axes.T @ third, body="spin")
    frame.node("f", rng.normal(size=3), body="spin")
    frame.node("g", rng.normal(size=3))
    bar = Beam(Rectangle(y=0.02, z=0.01), STEEL)
    for start, end in ("ab", "cd", "ef"):
        frame.add(start + end, Beam(Rectangle(y=rng.uniform(0.01, 0.02), z=0.01), STEEL), start, end)
    frame.add("dg", bar, "d", "g")
    axes = Rotation.random(rng=rng).as_matrix()
    frame.add("bc", Joint(stiffness=rng.uniform(1e5, 1e9, 6), axes=axes, pitch=rng.uniform(0.01, 0.1)), "b", "c")
    frame.add("de", Joint(stiffness=(np.inf, np.inf, 1e9, np.inf, 1e6, rng.uniform(1.0, 100.0))), "d", "e")
    frame.fix("a")
    frame.fix("f", "ux", "uy", "uz")
    frame.prescribe("f", rz=rng.uniform(0.0, 1e-3))
    frame.rigid("g", *[])
    frame.offset("bc", ux=rng.uniform(0.0, 1e-3), rz=rng.uniform(0.0, 1e-3))
    frame.load("c", **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), rng.normal(size=6), strict=True)))
    frame.load("b", fy=rng.normal(), mz=rng.normal())
    frame.point_load("dg", at=0.1, fx=rng.normal(), fy=rng.normal(), fz=rng.normal(), mx=rng.normal(), my=1.0, mz=1.0)
    frame.gravity(rng.normal(size=3))
    return frame


def everything(solution: Solution) -> dict[str, Array]:
    """All results by name."""
    frame = solution.frame
    found = {f"displacement of {name}": solution.displacement(name) for name in frame.nodes}
    found |= {f"reaction of {name}": solution.reaction(name) for name in frame.supports}
    found |= {f"ends of {name}": solution.end_forces(name) for name in frame.members}
    found |= {f"along {name}": solution.displacement_along(name, [0.01]) for name in frame.members}
    found |= {f"joint {name}": solution.joint_displacement(name) for name in frame.joints}
    found |= {f"force of {name}": solution.joint_force(name) for name in frame.joints}
    found |= {"all": solution.displacements(), "distance": solution.distance_to_singularity()}
    name = next(iter(frame.nodes))
    found["bound"] = solution.error_bound(list(frame.nodes)[1]) + solution.error_bound(name)
    found["state"] = np.asarray(solution.state)
    return found


def anew(frame: Frame) -> dict[str, Array]:
    """All results of a frame of a topology that was never met."""
    PROGRAMS.clear()
    return everything(frame.copy().solve())


def met(describe: Callable[[], Frame]) -> None:
    """Solve frames of a topology until its program is there."""
    for _ in range(MET):
        frame = describe()
        frame.solve().displacement(next(iter(frame.nodes)))


def assert_same(found: dict[str, Array], wanted: dict[str, Array]) -> None:
    """To the last bit."""
    assert found.keys() == wanted.keys()
    for name, value in found.items():
        np.testing.assert_array_equal(value, wanted[name], err_msg=name)


@pytest.mark.parametrize("way", list(Way))
@pytest.mark.parametrize("describe", [lambda k: four_bar(0.3 + 0.1 * k, 1e10 * (1 + k)), all_kinds])
def test_later_frames_are_as_the_first(
    describe: Callable[[int], Frame], way: Way, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Step by step, and after many of them by the functions, or the machine code, that the steps were compiled to."""
    if way is Way.MACHINE and not entry_machine.available():
        pytest.skip("no LLVM, or no extended precision of 80 bits")
    monkeypatch.setattr(entry_recording, "_OFTEN", 0 if way is Way.COMPILED else 10**9)
    monkeypatch.setattr(entry_recording, "_ALWAYS", 0 if way is Way.MACHINE else 10**9)
    wanted = anew(describe(9))
    met(lambda: describe(3))
    solution = describe(9).solve()
    found = everything(solution)
    assert solution.plan.entry is not None
    assert_same(found, wanted)


def test_frames_of_a_motion_pose_by_pose() -> None:
    """Links keep their stiffness from pose to pose: their results are those of the pose alone."""
    linkage = Linkage(A=(0, 0), B=(0, 0.1), P=(0.1, 0.1), D=(0.2, 0.1), E=(0.2, 0))
    for name, points in {"crank": "AB", "coupler": "BPD", "rocker": "DE"}.items():
        linkage.link(name, *points, beam=Beam(Rectangle(y=0.0127, z=0.00635), STEEL))
    linkage.revolute("A", "ground", "crank", drive=True)
    for name, pair in {"B": ("crank", "coupler"), "D": ("coupler", "rocker"), "E": ("rocker", "ground")}.items():
        linkage.revolute(name, *pair, stiffness=PIN)

    def framed(angle: float) -> Frame:
        frame = linkage.move(A=angle).frame()
        frame.load("P", fx=10.0, fy=100.0, mz=1.0)
        return frame

    met(lambda: framed(0.2))
    for angle in (-0.4, 0.3, 0.9):
        solution = framed(angle).solve()
        found = everything(solution)
        assert solution.plan.entry is not None
        STACKS.clear()
        assert_same(found, anew(framed(angle)))
        met(lambda: framed(0.2))


def test_results_do_not_depend_on_what_is_read_first() -> None:
    wanted = anew(four_bar(0.8))
    met(four_bar)
    found = everything(four_bar(0.8).solve())
    backwards = four_bar(0.8).solve()
    backwards.status  # noqa: B018
    reactions = {name: backwards.reaction(name) for name in "EA"}
    assert_same({f"reaction of {name}": value for name, value in reactions.items()} | found, wanted)


CHANGES = st.lists(
    st.tuples(st.sampled_from(["load", "no load", "joint", "beam", "place", "support"]), st.integers(1, 50)),
    min_size=1,
    max_size=6,
)


@settings(max_examples=8, deadline=None)
@given(CHANGES)
def test_changed_in_place_as_described_anew(changes: list[tuple[str, int]]) -> None:
    """Programs of what was met in examples before are there, those of the first are not."""
    frame = four_bar()
    frame.solve().displacement("P")
    for kind, number in changes:
        size = 1.0 + 0.01 * number
        if kind == "load":
            frame.set_load("P", fy=50.0 * size, mz=number % 2)
        elif kind == "no load":
            frame.set_load("P", fy=0.0)
        elif kind == "joint":
            frame.change("b", Joint(stiffness=(*(1e11 * size,) * 5, 10.0 * (number % 2))))
        elif kind == "beam":
            frame.change("AB", Beam(Rectangle(y=0.01 * size, z=0.008), STEEL))
        elif kind == "place":
            frame.change("P", (0.15 * size, 0.06, 0.0))
        else:
            frame.prescribe("E", ux=1e-4 * number)
        found = [frame.solve().displacement("P"), frame.solve().reaction("A")]
        np.testing.assert_array_equal(found, fresh(frame.copy()))


def fresh(frame: Frame) -> list[Array]:
    """The same results by operations that are done one by one, whatever was written down."""
    solution = frame.solve()
    solution.plan.entry = None
    return [solution.displacement("P"), solution.reaction("A")]


def test_threads_share_what_is_written_down(monkeypatch: pytest.MonkeyPatch) -> None:
    """Other poses and other loads, in no order: each has the bits that it has alone."""
    monkeypatch.setattr(entry_recording, "_OFTEN", 20)

    def work(number: int) -> bytes:
        frame = four_bar(0.5 + 0.1 * (number % 5))
        found = [frame.solve().displacement("P")]
        frame.set_load("P", fy=10.0 * (1 + number % 3))
        return np.array([*found, frame.solve().displacement("P")]).tobytes()

    with ThreadPoolExecutor(4) as pool:
        together = list(pool.map(work, range(60)))
    PROGRAMS.clear()
    alone = [work(number) for number in range(15)]
    assert together == [alone[number % 15] for number in range(60)]


def test_which_joint_is_stiffest_makes_no_topology_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    written: list[object] = []
    program = entry_recording._written

    def counted(*given: Any) -> Any:
        written.append(given)
        return program(*given)

    monkeypatch.setattr(entry_recording, "_written", counted)
    frame, orders = four_bar(), [(1.0, 2.0, 3.0), (2.0, 3.0, 1.0), (3.0, 1.0, 2.0), (3.0, 2.0, 1.0)]
    for shares in orders * MET:
        for name, share in zip("bde", shares, strict=True):
            frame.change(name, Joint(stiffness=(*(share * 1e11,) * 5, 0.0)))
        changed = frame.solve().displacement("P")
        fresh = frame.copy().solve("banded").displacement("P")
        assert np.abs(changed - fresh).max() < 1e-12 * np.abs(fresh).max()
    assert len(written) == 1


def test_load_alone_takes_up_the_factor() -> None:
    met(four_bar)
    frame = four_bar()
    frame.solve().displacement("P")
    for force in (10.0, 20.0):
        frame.set_load("P", fy=force)
        solution = frame.solve()
        entry = solution.plan.entry
        assert entry is not None
        assert entry.again
        assert "with the factor of the last solution" in solution.explain()
        np.testing.assert_array_equal(solution.displacement("P"), fresh(four_bar(force=force))[0])


def test_a_mechanism_among_regular_frames_is_told() -> None:
    met(four_bar)
    frame = four_bar(0.7, 0.0)
    with pytest.warns(MechanismWarning, match="kinematically unstable"):
        assert np.isnan(frame.solve().displacement("P")).all()


def test_solutions_travel() -> None:
    met(four_bar)
    solution = four_bar(1.1).solve()
    wanted = solution.displacement("P")
    twin = pickle.loads(pickle.dumps(solution))
    np.testing.assert_array_equal(twin.displacement("P"), wanted)
    np.testing.assert_array_equal(twin.reaction("A"), solution.reaction("A"))


def test_long_chains_are_condensed_as_ever() -> None:
    """Members in line, which are condensed two by two, are not written down one by one."""
    rod = Beam(Rectangle(y=0.02, z=0.01), STEEL)

    def chain(step: float = 1.0) -> Frame:
        frame = Frame()
        for k in range(20):
            frame.node(f"{k}", (step * k, 0.1 * (k % 3), 0.2 * (k % 2)))
            if k:
                frame.add(f"m{k}", rod, f"{k - 1}", f"{k}")
        frame.fix("0")
        frame.load("19", fy=1.0)
        return frame

    met(chain)
    solution = chain(1.1).solve()
    np.testing.assert_array_equal(solution.displacement("19"), anew(chain(1.1))["displacement of 19"])
    assert solution.plan.entry is None


def test_the_method_is_told_as_it_was_asked_for() -> None:
    met(four_bar)
    for method, told in ((None, "unknowns are no more than"), ("broadcast", "as asked for")):
        for _ in range(MET):
            solution = four_bar().solve(method)
            solution.displacement("P")
        assert solution.plan.entry is not None
        assert told in solution.explain()


def test_two_parts_that_nothing_connects_are_solved_apart() -> None:
    def pair(length: float = 1.0) -> Frame:
        frame, rod = Frame(), Beam(Rectangle(y=0.02, z=0.01), STEEL)
        for k, (start, end) in enumerate(("AB", "CD")):
            frame.node(start, (0.0, 0.0, k))
            frame.node(end, (length, 0.0, k))
            frame.add(start + end, rod, start, end)
            frame.fix(start)
            frame.load(end, fy=1.0)
        return frame

    met(pair)
    solution = pair(1.5).solve()
    np.testing.assert_array_equal(solution.displacement("B"), anew(pair(1.5))["displacement of B"])
    assert solution.plan.entry is None


def test_a_rotation_that_nothing_holds_is_told_of_every_frame() -> None:
    """A moment turns an end that is hinged on both sides: the pivot is zero whatever the numbers are."""

    def hinged(length: float) -> Frame:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (length, 0.0, 0.0))
        frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), STEEL, release=("end rz",)), "A", "B")
        frame.fix("A")
        frame.fix("B", "ux", "uy", "uz")
        frame.load("B", mz=2.0)
        return frame

    for k in range(MET):
        solution = hinged(1.0 + k).solve()
        with pytest.warns(MechanismWarning):
            assert np.isnan(solution.displacement("B")).any()
        assert solution.status == "mechanism"


def test_explain_tells_how_the_program_was_run(monkeypatch: pytest.MonkeyPatch) -> None:
    """First without one; then its steps one by one, as functions, and as machine code where that can be had."""
    monkeypatch.setattr(entry_recording, "_FEW", 2)
    monkeypatch.setattr(entry_recording, "_OFTEN", 4)
    monkeypatch.setattr(entry_recording, "_ALWAYS", 6)
    PROGRAMS.clear()
    told = []
    for k in range(8):
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0 + 0.1 * k, 0.0, 0.0))
        frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), Material(E=200e9, nu=0.3)), "A", "B")
        frame.fix("A")
        frame.load("B", fy=1.0)
        solution = frame.solve()
        solution.displacement("B")
        told += re.findall(r"steps, recorded for all frames of this topology, (.+)\.", solution.explain()) or [""]
    last = "as machine code" if entry_machine.available() else "as Python functions"
    assert told == ["", "", *["by Python one by one"] * 2, *["as Python functions"] * 2, last, last]
