"""Contact without a stiffness at large displacement: journals on their circles to rounding, forces from equilibrium."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from linkframe.elements import Beam, Joint, Material, Rectangle
from linkframe.framework import Frame, FrameError
from linkframe.models import FourBar, Linkage
from numpy.testing import assert_allclose

INF = float("inf")
STEEL = Material(E=200e9, nu=0.3)
BAR = Beam(Rectangle(y=0.02, z=0.01), STEEL)
EA = 200e9 * 0.02 * 0.01
LENGTH = 0.5
# What |d| may differ from the clearance by, relative.
ROUNDED = 4e-15


def hung(force: np.ndarray, clearance: object, stiffness: object = INF, play: tuple[str, ...] = ("ux", "uy")) -> Frame:
    """A bar along x in a loose bearing at A, which a force on its end B turns; soft springs tell where it starts."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("A1", (0.0, 0.0, 0.0))
    frame.node("B", (LENGTH, 0.0, 0.0))
    soft = (INF, INF, 1e-3) if len(play) == 2 else (1e-3,) * 3
    springs = (stiffness, stiffness, INF if len(play) == 2 else stiffness, *soft)
    frame.add("bearing", Joint(springs, clearance=clearance, clearance_directions=play), "A", "A1")  # type: ignore[arg-type]
    frame.add("bar", BAR, "A1", "B")
    frame.fix("A")
    frame.load("B", fx=force[..., 0], fy=force[..., 1], fz=force[..., 2])
    return frame


def four_bar(clearances: dict[str, object], force: object, theta: object, **options: object) -> Frame:
    given = {"stiffness": (INF,) * 5 + (0.0,)} | options
    frame = FourBar(0.1, 0.2, 0.1, 0.2, point=(0.1, 0.0), branch="antiparallel", **given).move(theta).frame(clearances)  # type: ignore[arg-type]
    frame.load("P", fy=force)  # type: ignore[arg-type]
    return frame


def off(frame: Frame, joint: str, moved: np.ndarray) -> np.ndarray:
    """By how much the displacement in the play exceeds the clearance, relative."""
    element = frame.joints[joint].element
    return np.asarray(np.linalg.norm(moved[..., list(element.clearance_directions)], axis=-1) / element.clearance - 1.0)


@pytest.mark.parametrize("degrees", [0.0, 5.0, 60.0, 120.0])
def test_a_loose_bar_turns_into_the_force(degrees: float) -> None:
    """B ends in the direction n of the force, at ε + L + F L/EA from A, the contact force is F along n."""
    n = np.array([np.cos(np.radians(degrees)), np.sin(np.radians(degrees)), 0.0])
    frame = hung(1000.0 * n, 2e-3)
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    far = 2e-3 + LENGTH + 1000.0 * LENGTH / EA
    # The soft spring holds it back by an angle of 1e-3 deg / F L.
    assert_allclose(solution.displacement("B")[:3] + np.array([LENGTH, 0.0, 0.0]), far * n, atol=3e-6)
    assert abs(off(frame, "bearing", solution.joint_displacement("bearing"))) < ROUNDED
    assert "rigid contact in bearing" in solution.explain()
    contact = solution.contact("bearing")
    assert contact.status == "closed"
    assert contact.force == pytest.approx(1000.0, rel=1e-11)
    assert_allclose(contact.normal, n, atol=3e-6)
    assert contact.gap == 0.0
    if degrees == 0.0:
        error = np.abs(solution.displacement("B")[0] - (2e-3 + 1000.0 * LENGTH / EA))
        assert error <= solution.error_bound("B")[0] < 1e-14


@settings(max_examples=6, deadline=None)
@given(
    st.tuples(st.floats(0.3, 1.0), st.floats(-1.0, 1.0), st.floats(-1.0, 1.0)),
    st.floats(-8.0, -2.0),
    st.floats(0.0, 4.0),
)
def test_a_ball_rests_on_its_socket(direction: tuple[float, float, float], clearance: float, size: float) -> None:
    """Three components of play: B lies on a sphere about A, whatever clearance and force; no clearance is a hinge."""
    n = np.array(direction)
    n, force, radii = n / np.linalg.norm(n), 10.0**size, np.array([0.0, 10.0**clearance])
    solution = hung(force * n, radii, play=("ux", "uy", "uz")).solve(large=True)
    assert solution.status.tolist() == ["stable"] * 2
    moved = solution.joint_displacement("bearing")[:, :3]
    assert_allclose(np.linalg.norm(moved, axis=-1), radii, rtol=ROUNDED, atol=1e-18)
    # A bar that has swung knows its length to a rounding, and its force to EA times that.
    pressed = solution.joint_force("bearing")[1, :3]
    assert_allclose(pressed, force * moved[1] / radii[1], rtol=1e-9, atol=1e-15 * EA)
    at = solution.displacement("B")[:, :3] + np.array([LENGTH, 0.0, 0.0])
    assert_allclose(np.linalg.norm(at, axis=-1), LENGTH + radii + force * LENGTH / EA, rtol=1e-7)
    assert solution.contact("bearing").status.tolist() == ["closed"] * 2


def test_a_beam_pressed_into_a_gap() -> None:
    """Beyond the gap the beam is one whose end is displaced by it; its support's reaction is the contact force."""
    force = np.array([1.0, 100.0, 390.0, 440.0, 1e3, 1e4])

    def beam() -> Frame:
        frame = Frame()
        frame.node("A", (0.0, 0.0, 0.0))
        frame.node("B", (1.0, 0.0, 0.0))
        frame.add("AB", Beam(Rectangle(y=0.02, z=0.01), STEEL, segments=4), "A", "B")
        frame.fix("A")
        frame.load("B", fy=force)
        return frame

    gap = 0.1
    stopped, pushed, free = beam(), beam(), beam()
    stopped.node("C", (1.0, 0.0, 0.0))
    stopped.fix("C")
    stopped.add("stop", Joint((0.0, INF, 0.0, 0.0, 0.0, 0.0), clearance=gap), "C", "B")
    pushed.prescribe("B", uy=gap)
    solution, driven, loose = (frame.solve(large=True, steps=4) for frame in (stopped, pushed, free))
    contact = solution.contact("stop")
    closed = loose.displacement("B")[:, 1] > gap
    assert closed.tolist() == [False, False, False, True, True, True]
    assert contact.closed.tolist() == closed.tolist()
    expected = np.where(closed[:, None], driven.displacement("B"), loose.displacement("B"))
    assert_allclose(solution.displacement("B"), expected, rtol=1e-10, atol=1e-14)
    assert_allclose(solution.joint_displacement("stop")[closed, 1], gap, rtol=ROUNDED)
    assert_allclose(contact.force, np.where(closed, -driven.reaction("B")[:, 1], 0.0), rtol=1e-9)
    assert_allclose(contact.gap, np.where(closed, 0.0, gap - loose.displacement("B")[:, 1]), rtol=1e-9)
    assert_allclose(solution.strain_energy[-1], np.where(closed, driven.strain_energy[-1], loose.strain_energy[-1]))


def test_at_a_singular_pose_the_load_moves_the_linkage_to_the_end_of_its_reach() -> None:
    """Coupler and rocker in line at 0 degrees: a pin loose by ε lets the coupler turn by the angle φ at which its end
    is b + ε from the ground pin, cos φ = (a² + c² - (b + ε)²) / 2 a c, and no farther; then P is a sin φ / 2 above. The
    links give way in proportion to the load."""
    clearance, force = np.array([1e-4, 1e-3, 5e-3])[:, None], np.array([1e-1, 1.0])
    frame = four_bar({"D": clearance}, force, 0.0)
    solution = frame.solve(large=True)
    assert (solution.status == "stable").all()
    assert np.abs(off(frame, "D", solution.joint_displacement("D"))).max() < ROUNDED
    reach = 0.1 * np.sin(np.arccos((0.2**2 + 0.1**2 - (0.1 + clearance[:, 0]) ** 2) / (2.0 * 0.2 * 0.1)))
    moved = solution.displacement("P")[..., 1]
    assert_allclose(moved[:, 0], reach, rtol=1e-3)
    assert_allclose((10.0 * moved[:, 0] - moved[:, 1]) / 9.0, reach, rtol=2e-6)


def test_contact_is_the_limit_of_stiffness() -> None:
    """The difference from a finite contact stiffness k falls as 1/k, at the singular pose and elsewhere."""
    theta, k = np.radians([0.0, 1.0, 40.0, 100.0])[:, None], np.array([1e9, 1e10, 1e11])
    rigid = four_bar(dict.fromkeys("BD", 1e-3), 100.0, theta[:, 0]).solve(large=True)
    springs = np.stack([k, k, *(INF + 0.0 * k,) * 3, 0.0 * k], axis=-1)
    near = four_bar(dict.fromkeys("BD", 1e-3), 100.0, theta, stiffness=springs).solve(large=True)
    assert (rigid.status == "stable").all()
    error = np.abs(near.displacement("P") - rigid.displacement("P")[:, None]).max(axis=-1)
    assert_allclose(error[:, :-1] / error[:, 1:], 10.0, rtol=0.05)
    for joint in "BD":
        found, expected = near.contact(joint), rigid.contact(joint)
        assert found.closed.all()
        assert expected.closed.all()
        assert_allclose(found.force[:, -1], expected.force, rtol=1e-5)
        assert_allclose(found.normal[:, -1], expected.normal, atol=1e-5)
        assert_allclose(found.offset[:, -1], expected.offset, atol=1e-8)


def linkage(force: float, clearance: float, **given: object) -> Frame:
    """A four-bar as a user writes it: loose pins without any stiffness."""
    beam = Beam(Rectangle(y=12.7e-3, z=6.35e-3), STEEL)
    model = Linkage(A=(0, 0), B=(0, 0.1), P=(0.12, 0.19), D=(0.24, 0.16), E=(0.22, 0))
    model.link("crank", "A", "B", beam=beam)
    model.link("coupler", "B", "P", "D", beam=beam)
    model.link("rocker", "D", "E", beam=beam)
    model.revolute("A", "ground", "crank", drive=True)
    model.revolute("B", "crank", "coupler", clearance=clearance, **given)  # type: ignore[arg-type]
    model.revolute("D", "coupler", "rocker", clearance=clearance)
    model.revolute("E", "rocker", "ground", clearance=2.0 * clearance)
    frame = model.move(A=np.radians([10.0, 80.0, 150.0, 300.0])).frame()
    frame.load("P", fy=force)
    return frame


def test_small_displacements_are_those_of_the_linear_contact() -> None:
    """The difference from the linear solution falls with load and clearance together, as their square."""
    differences = []
    for size in (1.0, 0.5):
        frame = linkage(10.0 * size, 1e-6 * size)
        large, linear = frame.solve(large=True), frame.solve()
        assert (large.status == "stable").all()
        differences.append(np.abs(large.displacement("P") - linear.displacement("P"))[:, :2].max() / size)
        assert differences[-1] < 1e-3 * np.abs(linear.displacement("P")).max() / size
        for joint in "BDE":
            assert_allclose(large.contact(joint).force, linear.contact(joint).force, rtol=1e-3)
            assert_allclose(large.contact(joint).offset, linear.contact(joint).offset, atol=1e-3 * 2e-6)
    assert differences[1] == pytest.approx(0.5 * differences[0], rel=0.1)


@pytest.mark.parametrize("stiffness", [INF, 1e8], ids=["rigid", "rigid and stiff"])
def test_loads_and_reactions_are_in_equilibrium(stiffness: float) -> None:
    frame = linkage(200.0, 1e-3, stiffness=(stiffness, stiffness, INF, INF, INF, 0.0))
    solution = frame.solve(large=True)
    assert (solution.status == "stable").all()
    total = np.zeros((4, 6))
    ends = {name for name in frame.supports if np.abs(solution.reaction(name)).max() > 0.0}
    for name in ends:
        total += about_origin(frame.position(name) + solution.displacement(name)[..., :3], solution.reaction(name))
    load = np.zeros((4, 6))
    load[:, 1] = 200.0
    node = frame.aliases.get("P", "P")
    total += about_origin(frame.position(node) + solution.displacement("P")[..., :3], load)
    assert_allclose(total, 0.0, atol=1e-9 * 200.0)
    for joint in "DE" if np.isfinite(stiffness) else "BDE":
        moved, force = solution.joint_displacement(joint), solution.joint_force(joint)
        assert np.abs(off(frame, joint, moved)).max() < ROUNDED
        contact = solution.contact(joint)
        assert_allclose(
            force[:, :2], contact.force[:, None] * contact.offset[:, :2] / contact_radius(frame, joint), rtol=1e-8
        )
    assert solution.residual.max() < 1e-10


def about_origin(place: np.ndarray, force: np.ndarray) -> np.ndarray:
    return np.concatenate([force[..., :3], force[..., 3:] + np.cross(place, force[..., :3])], axis=-1)


def contact_radius(frame: Frame, joint: str) -> float:
    return float(frame.joints[joint].element.clearance)


@pytest.mark.parametrize("force", [50.0, 150.0])
def test_a_stop_that_closes_a_loop(force: float) -> None:
    """A spring k and a stop between the same two nodes: the stop takes F - k ε once the spring has given way by ε."""
    frame = Frame()
    frame.node("A", (0.0, 0.0, 0.0))
    frame.node("B", (0.0, 0.0, 0.0))
    frame.node("C", (0.1, 0.0, 0.0))
    frame.fix("A")
    frame.add("spring", Joint((1e4, 1e4, INF, INF, INF, INF)), "A", "B")
    frame.add("stop", Joint((INF, INF, 0.0, 0.0, 0.0, 0.0), clearance=0.01), "A", "B")
    frame.rigid("B", "C")
    frame.load("C", fx=0.6 * force, fy=0.8 * force)
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    pressed = max(force - 1e4 * 0.01, 0.0)
    contact = solution.contact("stop")
    assert contact.force == pytest.approx(pressed, rel=1e-10)
    assert solution.joint_force("stop")[:3] == pytest.approx(pressed * np.array([0.6, 0.8, 0.0]), rel=1e-10)
    moved = 0.01 if pressed else force / 1e4
    assert solution.displacement("C")[:3] == pytest.approx(moved * np.array([0.6, 0.8, 0.0]), rel=1e-13)


@settings(max_examples=15, deadline=None)
@given(st.floats(-6.0, -1.0), st.floats(2.0, 9.0), st.floats(0.01, 3.0), st.floats(0.0, 6.28), st.booleans())
def test_bounds_hold(clearance: float, stiffness: float, load: float, angle: float, loop: bool) -> None:
    """A stop alone, which nothing but its play moves, and one beside a spring: ε along the force, to 40 digits."""
    radius, k = 10.0**clearance, 10.0**stiffness
    force = k * radius * 10.0**load * np.array([np.cos(angle), np.sin(angle)])
    frame = Frame()
    for name, x in {"A": 0.0, "B": 0.0, "C": 0.1}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.fix("A")
    if loop:
        frame.add("spring", Joint((k, k, INF, INF, INF, INF)), "A", "B")
    rest = 0.0 if loop else INF
    frame.add(
        "stop", Joint((INF, INF, rest, rest, rest, rest), clearance=radius, clearance_directions=("ux", "uy")), "A", "B"
    )
    frame.rigid("B", "C")
    frame.load("C", fx=force[0], fy=force[1])
    solution = frame.solve(large=True)
    assert solution.status == "stable"
    with mpmath.workdps(40):
        x, y = (mpmath.mpf(float(part)) for part in force)
        exact = [mpmath.mpf(radius) * part / mpmath.hypot(x, y) for part in (x, y)]
        found, bound = solution.displacement("C"), solution.error_bound("C")
        error = [float(abs(mpmath.mpf(float(a)) - b)) for a, b in zip(found[:2], exact, strict=True)]
    assert np.all(error <= bound[:2])
    assert np.all(bound[:2] < 1e-12 * radius)


def test_play_in_a_rotation() -> None:
    """A hinge loose by an angle ε lets a lever turn so far before it bends: its moment is F L cos of where it is."""
    frame = Frame()
    for name, x in {"A": 0.0, "A1": 0.0, "B": LENGTH}.items():
        frame.node(name, (x, 0.0, 0.0))
    frame.fix("A")
    angle = np.array([0.05, 0.5, 1.2])
    frame.add("hinge", Joint((INF,) * 6, clearance=angle, clearance_directions=("rz",)), "A", "A1")
    frame.add("lever", BAR, "A1", "B")
    frame.load("B", fy=20.0)
    solution = frame.solve(large=True)
    assert_allclose(solution.joint_displacement("hinge")[:, 5], angle, rtol=ROUNDED)
    arm = LENGTH + solution.displacement("B")[:, 0]
    assert_allclose(solution.contact("hinge").force, 20.0 * arm, rtol=1e-9)
    bent = 20.0 * np.cos(angle) * LENGTH**3 / (3.0 * 200e9 * 0.01 * 0.02**3 / 12.0)
    assert_allclose(solution.displacement("B")[:, 1], LENGTH * np.sin(angle) + bent * np.cos(angle), rtol=1e-4)


def test_each_entry_of_a_batch_is_as_if_alone() -> None:
    force = np.array([[1.0, 0.2, 0.0], [300.0, 200.0, 0.0], [1e4, 8e3, 0.0]])
    radius = np.array([1e-3, 0.0, 3e-3])
    whole = hung(force, radius).solve(large=True)
    assert (whole.status == "stable").all()
    for k in range(3):
        alone = hung(force[k], max(radius[k], 1e-300)).solve(large=True)
        assert_allclose(whole.displacement("B")[k], alone.displacement("B"), rtol=1e-9, atol=1e-13)


def test_load_steps_end_where_one_step_does() -> None:
    frame = four_bar(dict.fromkeys("BD", 1e-3), 50.0, np.radians([20.0, 60.0]))
    once, often = frame.solve(large=True), frame.solve(large=True, steps=3)
    assert_allclose(often.displacement("P"), once.displacement("P"), rtol=1e-10, atol=1e-14)


def test_a_path_says_what_it_needs() -> None:
    with pytest.raises(FrameError, match=r"joint 'bearing' is ideal .* for a path"):
        hung(np.array([1.0, 0.0, 0.0]), 1e-3).path("B", "ux", 1e-3)
