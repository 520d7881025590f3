"""Contact in joint clearances: closed forms, batches, states, and what is refused."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import ClearanceState, Frame, FrameError, MechanismWarning, Solution
from linkframe.framework.clearances.contact import law
from numpy.testing import assert_allclose, assert_array_equal
from scipy.spatial.transform import Rotation

STEEL = Material(E=200e9, nu=0.3)
BAR = Beam(Rectangle(y=0.02, z=0.01), STEEL)
EIZ, LENGTH = 200e9 * 0.01 * 0.02**3 / 12, 0.8
INF = float("inf")
springs = st.sampled_from([1e3, 1e6, 1e11, 1e16, INF])


def cantilever(joint: Joint, **load: object) -> Frame:
    """A bar clamped at A whose end B stands before a stop on the ground."""
    frame = Frame()
    for name, x in (("A", 0.0), ("B", LENGTH), ("ground", LENGTH)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("stop", joint, "ground", "B")
    frame.fix("A")
    frame.fix("ground")
    frame.load("B", **load)
    return frame


# -- closed forms -------------------------------------------------------------------------------------------------


@settings(max_examples=50)
@example(stiffness=1e3, clearance=0.0156, force=1.25e-159)
@example(stiffness=1e6, clearance=0.0625, force=-1.25e-159)
@example(stiffness=INF, clearance=1e-3, force=1e-320)
@example(stiffness=1e16, clearance=1e-3, force=-1e300)
@given(stiffness=springs, clearance=st.floats(1e-6, 1e-1), force=st.floats(-1e5, 1e5))
def test_cantilever_against_a_stop(stiffness: float, clearance: float, force: float) -> None:
    """Deflection c F until contact, then the stop shares: R = (c |F| − ε)/(c + 1/k), with c = L³/3EI."""
    c = LENGTH**3 / (3.0 * EIZ)
    frame = cantilever(Joint((0.0, stiffness, 0.0, 0.0, 0.0, 0.0), clearance=clearance), fy=force)
    solution = frame.solve()
    reaction = max(0.0, (c * abs(force) - clearance) / (c + 1.0 / stiffness))
    expected = np.sign(force) * c * (abs(force) - reaction)
    scale = max(abs(force), 1e-3)
    assert_allclose(solution.displacement("B")[1], expected, atol=1e-12 * c * scale)
    contact = solution.contact("stop")
    assert_allclose(contact.force, reaction, atol=1e-11 * scale)
    assert_allclose(solution.reaction("ground")[1], -np.sign(force) * reaction, atol=1e-10 * scale)
    if reaction > 1e-9 * scale:
        assert contact.closed
        assert_array_equal(contact.normal, [0.0, np.sign(force), 0.0])
    elif reaction == 0.0 and c * abs(force) < clearance * (1 - 1e-9):
        assert contact.status == "open"
        assert_allclose(contact.gap, clearance - c * abs(force), rtol=1e-9, atol=1e-12 * clearance)


def test_axial_play_of_a_bar() -> None:
    """A bar of stiffness EA/L between clearances of both its ends and their springs, in line."""
    k, eps = np.array([1e6, 1e9, INF]), (3e-5, 5e-5)
    frame = Frame()
    for name, x in (("left", 0.0), ("A", 0.0), ("B", LENGTH), ("right", LENGTH)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    along = np.stack([np.full(2, 1e6)] + [np.full(2, 1e8)] * 5, axis=-1)
    along[1, 0] = 1e9
    frame.add("start", Joint(along, clearance=eps[0], clearance_directions=("ux",)), "left", "A")
    frame.add("end", Joint((0.0, INF, INF, INF, 0.0, 0.0)), "B", "right")
    frame.fix("left")
    frame.fix("right", "uy", "uz", "rx")
    frame.prescribe("right", ux=0.0, ry=0.0, rz=0.0)
    frame.load("B", fx=1000.0)
    solution = frame.solve()
    expected = 1000.0 * (1.0 / k[:2] + LENGTH / (200e9 * 0.02 * 0.01)) + eps[0]
    assert_allclose(solution.displacement("B")[:, 0], expected, rtol=1e-12)
    assert_allclose(solution.displacement("B")[:, 0] - frame.solve(clearance=False).displacement("B")[:, 0], eps[0])


def test_backlash_in_rotation() -> None:
    """A key with play turns freely by its backlash, then twists its shaft by T L/GJ and its own spring."""
    frame = cantilever(Joint((0, 0, 0, 5e3, 0, 0), clearance=2e-3, clearance_directions=("rx",)), mx=[-0.1, -100.0])
    c = LENGTH / (STEEL.G * BAR.section.J)
    solution = frame.solve()
    held = np.maximum(0.0, (c * np.array([0.1, 100.0]) - 2e-3) / (c + 1.0 / 5e3))
    assert_allclose(solution.displacement("B")[:, 3], -c * (np.array([0.1, 100.0]) - held), rtol=1e-11)
    assert_array_equal(solution.contact("stop").status, ["open", "closed"])
    assert_array_equal(solution.contact("stop").state, [ClearanceState.OPEN, ClearanceState.CLOSED])
    assert_array_equal(solution.contact("stop").normal, [[0, 0, 0], [-1, 0, 0]])


@settings(max_examples=40)
@given(
    turn=st.tuples(*[st.floats(-3.0, 3.0)] * 3),
    force=st.tuples(*[st.floats(-100.0, 100.0)] * 3).filter(lambda f: np.linalg.norm(f) > 1e-3),
    stiffness=springs,
)
def test_a_ball_joint_lies_along_its_force(turn: tuple[float, ...], force: tuple[float, ...], stiffness: float) -> None:
    """The end of a bar hangs on a ball joint under a force F there: δ = (ε/|F| + 1/k) F, whatever the joint's axes."""
    frame = Frame()
    for name, x in (("A", 0.0), ("B", LENGTH), ("C", LENGTH), ("D", 2.0 * LENGTH)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    axes = Rotation.from_rotvec(turn).as_matrix()
    frame.add(
        "ball",
        Joint((stiffness,) * 3 + (10.0,) * 3, axes=axes, clearance=1e-4, clearance_directions=("ux", "uy", "uz")),
        "B",
        "C",
    )
    frame.fix("A")
    frame.load("C", fx=force[0], fy=force[1], fz=force[2])
    frame.add("CD", BAR, "C", "D")
    solution = frame.solve()
    expected = (1e-4 / np.linalg.norm(force) + 1.0 / stiffness) * np.array(force)
    moved = solution.displacement("C")[:3] - solution.displacement("B")[:3]
    assert_allclose(moved, expected, rtol=1e-10, atol=1e-9 * np.abs(expected).max())
    contact = solution.contact("ball")
    assert_allclose(contact.normal, force / np.linalg.norm(force), atol=1e-10)
    assert contact.force == pytest.approx(np.linalg.norm(force), rel=1e-10)


def test_an_imposed_offset_moves_the_centre() -> None:
    """A stop that was set 1 mm off has its clearance about that."""
    c, eps, shift = LENGTH**3 / (3.0 * EIZ), 1e-3, 5e-4
    frame = cantilever(Joint((0, INF, 0, 0, 0, 0), clearance=eps), fy=[-100.0, 100.0])
    frame.offset("stop", uy=shift)
    assert_allclose(frame.solve().displacement("B")[:, 1], [shift - eps, 100.0 * c if 100.0 * c < 1.5e-3 else 1.5e-3])


def test_a_settlement_closes_the_gap() -> None:
    """The ground comes nearer by 3 mm to an unloaded bar: it lifts it by what is left of that, as rigid as it is."""
    frame = cantilever(Joint((0, INF, 0, 0, 0, 0), clearance=1e-3), fy=0.0)
    frame.prescribe("ground", uy=[0.5e-3, 3e-3])
    solution = frame.solve()
    assert_allclose(solution.displacement("B")[:, 1], [0.0, 2e-3], atol=1e-18)
    assert_allclose(solution.contact("stop").force, [0.0, 2e-3 * 3.0 * EIZ / LENGTH**3], rtol=1e-12)


# -- batches ------------------------------------------------------------------------------------------------------


def batch_frame(clearance: np.ndarray, stiffness: np.ndarray, angle: np.ndarray) -> Frame:
    """Two bars on the ground that meet in a pin, propped by a third: statically indeterminate, all joints loose."""
    frame = Frame()
    ends = {"1": (-0.6, 0.0), "2": (0.5, -0.1), "3": (0.1, -0.7)}
    spring = np.stack([stiffness] * 5 + [0.0 * stiffness], axis=-1)
    frame.node("P1", (0.0, 0.3, 0.0))
    for name, (x, y) in ends.items():
        frame.node("G" + name, (x, y, 0.0))
        frame.node("E" + name, (x, y, 0.0))
        if name != "1":
            frame.node("P" + name, (0.0, 0.3, 0.0))
            frame.add("pin" + name, Joint(spring, clearance=clearance), "P1", "P" + name)
        frame.add("bar" + name, BAR, "E" + name, "P" + name)
        frame.add("foot" + name, Joint(spring, clearance=0.5 * clearance), "G" + name, "E" + name)
        frame.fix("G" + name)
    frame.load("P1", fx=500.0 * np.cos(angle), fy=500.0 * np.sin(angle))
    return frame


@pytest.mark.filterwarnings("ignore:.*free.*one choice of many")
def test_a_batch_is_its_members() -> None:
    rng = np.random.default_rng(3)
    clearance, stiffness = rng.uniform(0.0, 1e-3, (2, 1, 1)), 10 ** rng.uniform(5, 11, (3, 1))
    angle = np.linspace(0.0, 6.0, 4)
    solution = batch_frame(clearance, stiffness, angle).solve()
    assert solution.shape == (2, 3, 4)
    for entry in np.ndindex(2, 3, 4):
        i, j, k = entry
        one = batch_frame(clearance[i, 0, 0], stiffness[j, 0], angle[k]).solve()
        size = np.abs(one.displacement("P1")).max()
        assert_allclose(solution.displacement("P1")[entry], one.displacement("P1"), atol=1e-9 * size)
        assert solution.contact("pin2").status[entry] == one.contact("pin2").status


@settings(max_examples=20)
@given(st.tuples(*[st.floats(-3.0, 3.0)] * 3))
def test_turning_the_frame_turns_the_answer(angles: tuple[float, ...]) -> None:
    """The frame and its load turned in space: the displacement is a vector, and so is the contact."""
    turn = Rotation.from_rotvec(angles).as_matrix()
    first, second = (hanging(axes).solve() for axes in (np.eye(3), turn))
    moved = first.displacement("B")[..., :3]
    assert_allclose(second.displacement("B")[..., :3], moved @ turn.T, atol=1e-9 * np.abs(moved).max())
    assert_array_equal(second.contact("2").status, first.contact("2").status)
    assert_allclose(second.contact("2").normal, first.contact("2").normal @ turn.T, atol=1e-7)


def hanging(turn: np.ndarray) -> Frame:
    """A clamped bar whose end two more bars hold, at which pins are loose in all directions; loads of three sizes."""
    frame = Frame()
    feet = {"1": (0.0, 0.0, 0.0), "2": (0.8, 0.6, 0.1), "3": (0.9, -0.2, -0.7)}
    tip = np.array([0.8, 0.0, 0.0])
    frame.node("B", turn @ tip)
    for name, foot in feet.items():
        frame.node("foot" + name, turn @ np.array(foot))
        if name == "1":
            frame.add("bar1", Beam(Rectangle(y=0.02, z=0.01), STEEL, up=turn[:, 2]), "foot1", "B")
        else:
            frame.node("top" + name, turn @ tip)
            frame.add("bar" + name, Beam(Rectangle(y=0.02, z=0.02), STEEL), "foot" + name, "top" + name)
            frame.add(name, Joint((1e9,) * 3 + (0.0,) * 3, axes=turn, clearance=2e-4), "B", "top" + name)
        frame.fix("foot" + name)
    force = turn @ np.array([30.0, -50.0, 20.0])
    factor = np.array([0.01, 1.0, 100.0])
    frame.load("B", fx=factor * force[0], fy=factor * force[1], fz=factor * force[2])
    return frame


def test_what_is_open_in_space() -> None:
    states = [hanging(np.eye(3)).solve().contact(name).status.tolist() for name in "23"]
    assert {"open", "closed"} <= {state for each in states for state in each}


# -- states -------------------------------------------------------------------------------------------------------


def pendulum(clearance: float = 1e-3, **load: object) -> Frame:
    """A clamped bar and one that is clamped to it but for a pin with play, held against turning by a soft spring."""
    frame = Frame()
    for name, x in (("A", 0.0), ("B", 1.0), ("C", 1.0), ("D", 2.0)):
        frame.node(name, (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add(
        "pin", Joint((1e8, 1e8, 1e8, 1e8, 1e8, 1e3), clearance=clearance, clearance_directions=("ux", "uy")), "B", "C"
    )
    frame.add("CD", BAR, "C", "D")
    frame.fix("A")
    if load:
        frame.load("C", **load)
    return frame


@pytest.mark.filterwarnings("ignore:.*free.*one choice of many")
def test_without_force_it_is_free_and_centred() -> None:
    """No force tells where the journal is: it stays centred, and the status says that this is one choice of many."""
    solution = pendulum(fy=[0.0, 10.0, -10.0]).solve()
    assert_array_equal(solution.status, ["free", "regular", "regular"])
    assert_array_equal(solution.contact("pin").status, ["free", "closed", "closed"])
    assert_array_equal(solution.joint_displacement("pin")[0], np.zeros(6))
    assert solution.contact("pin").gap[0] == 1e-3
    assert np.isnan(solution.contact("pin").angle[0])
    assert_allclose(solution.contact("pin").angle[1:], [np.pi / 2, -np.pi / 2])


def test_force_of_rounding_does_not_close() -> None:
    """What loads the first bar alone leaves the pin without force."""
    frame = pendulum()
    frame.load("B", fy=1234.5678, mz=np.array([0.1, 321.123]))
    assert_array_equal(frame.solve().contact("pin").status, ["free", "free"])


def test_jumps_where_the_reaction_passes_through_zero() -> None:
    force = np.array([5.0, 2.0, -1.0, -3.0, 0.0, -2.0, 4.0])
    contact = pendulum(fy=force).solve().contact("pin")
    assert_array_equal(contact.jumps(), [False, True, False, True, True, True])
    assert_array_equal(contact.jumps(axis=0), contact.jumps(axis=-1))
    grid = pendulum(fy=force[:, None], fx=np.array([0.0, 1e3])).solve().contact("pin")
    assert grid.jumps(axis=0).shape == (6, 2)
    assert_array_equal(grid.jumps(axis=0)[:, 0], contact.jumps())
    assert not grid.jumps(axis=0)[:, 1].any()
    assert_array_equal(grid.jumps(axis=1)[:, 0], [False, False, False, False, True, False, False])
    assert not grid.jumps(axis=1, turn=3.2)[:4].any()
    with pytest.raises(FrameError, match="2 axes"):
        grid.jumps(axis=2)
    cube = pendulum(fy=force, fx=np.array([0.0, 1e3])[:, None, None] * np.ones((3, 1))).solve().contact("pin")
    assert cube.jumps().shape == (2, 3, 6)
    assert_array_equal(cube.jumps()[0, 1], contact.jumps())


def test_a_mechanism_remains_one() -> None:
    frame = pendulum(fy=[1.0, 2.0])
    loose = Frame()
    for name, x in (("A", 0.0), ("B", 1.0), ("C", 1.0), ("D", 2.0)):
        loose.node(name, (x, 0.0, 0.0))
    loose.add("AB", BAR, "A", "B")
    loose.add("pin", Joint((1e8,) * 5 + (0.0,), clearance=1e-3), "B", "C")
    loose.add("CD", BAR, "C", "D")
    loose.fix("A")
    loose.load("D", fy=[0.0, 1.0])
    solution = loose.solve()
    assert frame.solve().status.tolist() == ["regular", "regular"]
    assert solution.status[1] == "mechanism"
    assert solution.contact("pin").status[1] == "mechanism"
    assert np.isnan(solution.contact("pin").force[1])
    with pytest.warns(MechanismWarning):
        assert np.isnan(solution.displacement("D")[1]).all()


# -- the face -----------------------------------------------------------------------------------------------------


def test_default_play_is_across_the_axis() -> None:
    def play(*stiffness: float) -> tuple[int, ...]:
        return Joint(stiffness, clearance=1e-3).clearance_directions

    assert play(9, 9, 9, 9, 9, 0) == (0, 1)
    assert play(9, 9, 9, 0, 9, 9) == (1, 2)
    assert play(9, 9, 0, 9, 9, 0) == (0, 1)
    assert play(9, 9, 9, 0, 0, 0) == (0, 1, 2)
    assert play(0, 9, 9, 9, 9, 9) == (1, 2)
    assert play(INF, INF, 7, INF, INF, 0) == (0, 1)
    assert Joint((1.0,) * 6).clearance_directions == ()


@pytest.mark.parametrize(
    ("stiffness", "options", "message"),
    [
        ((1, 2, 1, 1, 1, 0), {}, "one contact stiffness"),
        ((0, 0, 0, 1, 1, 1), {}, "no translation is constrained"),
        ((0, 1, 1, 1, 1, 0), {"clearance_directions": ("ux", "uy")}, "in a free direction"),
        ((1, 1, 1, 1, 1, 0), {"clearance_directions": ("ux", "rz")}, "mixes lengths and angles"),
        ((1, 1, 1, 1, 1, 0), {"clearance_directions": ("x",)}, "unknown"),
        ((1, 1, 1, 1, 1, 0), {"clearance": -1e-3}, "clearance = -0.001"),
        ((1, 1, 1, 1, 1, 0), {"clearance": np.nan}, "clearance = nan"),
        ((1, 1, 1, 1, 1, 0), {"clearance_directions": ()}, "name components"),
    ],
)
def test_what_makes_no_sense_is_refused(stiffness: tuple[float, ...], options: dict[str, object], message: str) -> None:
    with pytest.raises(FrameError, match=message):
        Joint(stiffness, **({"clearance": 1e-3} | options))  # type: ignore[arg-type]


def test_contact_is_of_joints_with_clearance() -> None:
    frame = pendulum(fy=1.0)
    with pytest.raises(FrameError, match="left out"):
        frame.solve(clearance=False).contact("pin")
    with pytest.raises(FrameError, match="unknown"):
        frame.solve().contact("AB")
    assert_array_equal(pendulum(0.0, fy=1.0).solve().displacement("D"), frame.solve(clearance=False).displacement("D"))


def test_explain_tells_of_clearances() -> None:
    frame = pendulum(fy=[1.0, 0.0])
    assert "joint pin: closed at 1, free at 1 of 2 entries" in frame.explain()
    assert "Clearances of 1 joints are left out: pin" in frame.solve(clearance=False).explain()
    assert "learance" not in pendulum(0.0, fy=1.0).explain()


def test_zero_at_some_entries_only() -> None:
    """Clearance may vary from nothing: there the joint is an ordinary one."""
    frame = pendulum(np.array([0.0, 1e-3]), fy=10.0)  # type: ignore[arg-type]
    solution: Solution = frame.solve()
    plain = frame.solve(clearance=False)
    assert_array_equal(solution.displacement("D")[0], plain.displacement("D")[0])
    assert_allclose(solution.displacement("C")[1, 1] - plain.displacement("C")[1, 1], 1e-3)
    assert_array_equal(solution.contact("pin").closed, [True, True])
    assert_allclose(solution.contact("pin").normal, [[0, 1, 0], [0, 1, 0]], atol=1e-12)


# -- the law ------------------------------------------------------------------------------------------------------


@given(st.lists(st.floats(-3.0, 3.0), min_size=1, max_size=3), st.floats(0.0, 2.0), st.floats(0.1, 1e3))
def test_the_law_derives_from_its_energy(delta: list[float], eps: float, k: float) -> None:
    x = np.array(delta)
    if abs(np.linalg.norm(x) - eps) < 1e-3:
        return
    force, tangent, _ = law(x, eps, k)
    step = 1e-6 * np.eye(len(x))
    up, down = law(x + step, eps, k), law(x - step, eps, k)
    assert_allclose(force, (up[2] - down[2]) / 2e-6, atol=1e-7 * k)
    assert_allclose(tangent, (up[0] - down[0]) / 2e-6, atol=1e-5 * k)


def test_the_law_of_a_rigid_contact_is_no_function() -> None:
    with pytest.raises(FrameError, match="finite"):
        law((1.0, 0.0), 0.5, INF)


# -- mechanisms beside it -----------------------------------------------------------------------------------------


def truss(*held: str, size: float) -> Frame:
    """Three bars between ball joints with play, loaded in their plane; across it only what is `held` at C holds."""
    frame = Frame()
    frame.node("C", (0.4, 0.6, 0.0))
    for name, place in {"A": (0.0, 0.0, 0.0), "B": (1.0, 0.0, 0.0), "D": (0.3, -0.8, 0.0)}.items():
        frame.node(name, place)
        frame.node(name + "1", place)
        frame.node("C" + name, (0.4, 0.6, 0.0))
        ball = Joint((1e9,) * 3 + (0.0,) * 3, clearance={"A": 1e-4, "B": 3e-4, "D": 1e-3}[name])
        frame.add("foot" + name, ball, name, name + "1")
        frame.add("bar" + name, BAR, name + "1", "C" + name)
        frame.add("top" + name, ball, "C" + name, "C")
        frame.fix(name)
    frame.fix("C", "rx", "ry", "rz", *held)
    frame.load("C", fx=100.0 * size, fy=-2000.0 * size)
    return frame


@pytest.mark.filterwarnings("ignore:.*free.*one choice of many")
@pytest.mark.parametrize("size", [1.0, 100.0])
def test_play_across_an_idle_mechanism(size: float) -> None:
    """The truss can swing out of its plane, which no load does: that does not hide how it resists offsets within."""
    loose, held = (truss(*names, size=size).solve() for names in ((), ("uz",)))
    assert (loose.status, held.status) == (
        ("free", "free") if size == 1.0 else ("statically consistent mechanism",) * 2
    )
    assert_allclose(loose.displacement("C")[:2], held.displacement("C")[:2], rtol=1e-9)
    states = [str(loose.contact(name).status) for name in ("footA", "footB", "footD")]
    assert states == ["closed", "closed", "free" if size == 1.0 else "closed"]


def test_rigid_loops_of_ideal_joints_are_refused() -> None:
    frame = Frame()
    for name, x in (("A", 0.0), ("B", 0.0), ("C", 1.0), ("D", 1.0)):
        frame.node(name, (x, 0.0, 0.0))
    frame.rigid("B", "D")
    for name, ends in (("left", ("A", "B")), ("right", ("C", "D"))):
        frame.add(name, Joint((INF,) * 3 + (1.0,) * 3, clearance=1e-3), *ends)
        frame.fix(ends[0])
    frame.load("D", fy=1.0)
    with pytest.raises(FrameError, match=r"joints left, right have clearance.*finite stiffness"):
        frame.solve()


@pytest.mark.parametrize("method", ["banded", "sparse", "iterative"])
def test_large_frames(method: str) -> None:
    """A long beam over loose props, by the sparse ways: the same contacts."""

    def beam(method: str) -> Solution:
        frame = Frame()
        for k in range(41):
            frame.node(f"N{k}", (0.25 * k, 0.0, 0.0))
            if k:
                frame.add(f"span{k}", BAR, f"N{k - 1}", f"N{k}")
        for k in range(4, 41, 4):
            frame.node(f"G{k}", (0.25 * k, 0.0, 0.0))
            frame.add(f"prop{k}", Joint((0, 1e7, 0, 0, 0, 0), clearance=1e-3), f"G{k}", f"N{k}")
            frame.fix(f"G{k}")
        frame.fix("N0")
        frame.load("N18", fy=-2000.0)
        return frame.solve(method)

    found, known = beam(method), beam("broadcast")
    states = [str(known.contact(f"prop{k}").status) for k in range(4, 41, 4)]
    assert "open" in states
    assert states.count("closed") > 2
    assert [str(found.contact(f"prop{k}").status) for k in range(4, 41, 4)] == states
    for k in range(4, 41, 4):
        lifted = known.displacement(f"N{k}")[1]
        assert_allclose(found.displacement(f"N{k}")[1], lifted, atol=1e-9)
        force = known.contact(f"prop{k}").force
        assert_allclose(force, 1e7 * max(abs(lifted) - 1e-3, 0.0), atol=1e-6)


@pytest.mark.filterwarnings("ignore:.*free.*one choice of many")
def test_absent_entries_have_no_contact() -> None:
    frame = pendulum(fy=[10.0, 10.0, 0.0])
    frame.exclude([False, True, False])
    solution = frame.solve()
    assert_array_equal(solution.contact("pin").status, ["closed", "absent", "free"])
    assert_array_equal(solution.status, ["regular", "absent", "free"])
    assert np.isnan(solution.contact("pin").force[1])
    assert np.isnan(solution.displacement("C")[1]).all()


@pytest.mark.filterwarnings("ignore:.*free.*one choice of many")
def test_the_same_in_parts(monkeypatch: pytest.MonkeyPatch) -> None:
    """Entries are handled some at a time, with the same bits."""
    rng = np.random.default_rng(5)
    given = (rng.uniform(0.0, 1e-3, (4, 1)), 10 ** rng.uniform(5, 11, (4, 1)), np.linspace(0.0, 6.0, 7))
    whole = batch_frame(*given).solve().displacement("P1")
    monkeypatch.setattr("linkframe.framework.clearances.contact_state._MOST", 5)
    assert_array_equal(batch_frame(*given).solve().displacement("P1"), whole)


def test_a_joint_that_is_tight_at_some_entries_tells_its_force_there() -> None:
    """A bar on two stops, of which the outer has clearance at one of two entries; both share the load with the bar."""
    frame = Frame()
    for name, x in {"A": 0.0, "B": LENGTH / 2, "C": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
        frame.node(f"{name} ground", (x, 0.0, 0.0))
    frame.add("AB", BAR, "A", "B")
    frame.add("BC", BAR, "B", "C")
    frame.fix("A")
    for name, clearance in {"B": 1e-5, "C": np.array([0.0, 2e-5])}.items():
        frame.add(f"stop {name}", Joint((0.0, 1e8, 0.0, 0.0, 0.0, 0.0), clearance=clearance), f"{name} ground", name)
        frame.fix(f"{name} ground")
    frame.load("B", fy=2e3)
    frame.load("C", fy=-300.0)
    solution = frame.solve()
    for stop in ("stop B", "stop C"):
        force = np.abs(solution.joint_force(stop)[:, 1])
        assert_array_equal(solution.contact(stop).closed, force > 1e-6)
        assert_allclose(solution.contact(stop).force, force, rtol=1e-9, atol=1e-9)
    assert_allclose(solution.displacement("C")[0, 1] * 1e8, solution.joint_force("stop C")[0, 1], rtol=1e-12)
