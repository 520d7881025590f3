"""Rods between two balls: they spin about themselves, whatever was described first, and bear no moment about it."""

from __future__ import annotations

import warnings
from typing import Any

import numpy as np
import pytest
from linkframe.elements import Beam, Circle, Joint, Material
from linkframe.framework import FrameError, MechanismWarning
from linkframe.framework.batch import Array
from linkframe.models import Linkage
from linkframe.models.linkage import Motion
from numpy.testing import assert_allclose
from scipy.spatial.transform import Rotation

BAR = Beam(Circle(diameter=0.02), Material(E=200e9, nu=0.3, density=7800.0))
PLACES = {"A": (0.0, 0.0, 0.0), "B": (0.0, 0.1, 0.05), "C": (0.4, 0.3, 0.1), "D": (0.4, 0.0, 0.0)}
ROD = np.array([0.4, 0.2, 0.05])
ALONG = ROD / np.linalg.norm(ROD)
EVEN, UNEVEN = (1e8, 1e8, 1e8, 0.0, 0.0, 0.0), (1e8, 1e8, 3e8, 0.0, 0.0, 0.0)
MECHANISM, CONSISTENT = "mechanism", "statically consistent mechanism"


def rssr(
    back: bool = False,
    turn: Array | None = None,
    ball: tuple[float, ...] | None = None,
    rod: Beam | None = BAR,
    gravity: float = 0.0,
    body: dict[str, Any] | None = None,
    **load: float,
) -> Linkage:
    """A crank and a rocker coupled by a rod between two balls, its joints described forth or back, turned in space."""
    turn = np.eye(3) if turn is None else turn
    linkage = Linkage({name: turn @ place for name, place in PLACES.items()})
    linkage.link("crank", "A", "B", beam=BAR)
    linkage.link("rod", "B", "C", **({"beam": rod} if rod else {"mass": 2.0, "inertia": 0.0}) | (body or {}))
    linkage.link("rocker", "D", "C", beam=BAR)
    described = [
        lambda: linkage.revolute("A", "ground", "crank", axis=turn @ [1.0, 0.1, 0.0], drive=True),
        lambda: linkage.spherical("B", "crank", "rod", stiffness=ball),
        lambda: linkage.spherical("C", "rod", "rocker", stiffness=ball),
        lambda: linkage.revolute("D", "ground", "rocker", axis=turn @ [0.2, 0.0, 1.0]),
    ]
    for joint in reversed(described) if back else described:
        joint()
    if gravity:
        linkage.gravity(turn @ [0.0, 0.0, -gravity])
    if load:
        linkage.load("C", link="rod", **load)
    return linkage


def pushed(motion: Motion, node: str, force: Array, moment: Array) -> tuple[Array, Array]:
    """Status, and displacement of the rocker's end, under a force and a moment."""
    frame = motion.frame()
    frame.load(node, **dict(zip(("fx", "fy", "fz", "mx", "my", "mz"), (*force, *moment), strict=True)))
    solution = frame.solve()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        return solution.status, solution.displacement("C.rocker")


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("ball", [None, EVEN, UNEVEN])
def test_no_ball_bears_a_moment_about_the_rod(back: bool, ball: tuple[float, ...] | None) -> None:
    """It moves without bound, and the warning names the rod; the same at large displacement."""
    motion = rssr(back, ball=ball).move(A=0.0)
    frame = motion.frame()
    frame.load("C.rod", mx=50.0)
    solution = frame.solve()
    assert solution.status == MECHANISM
    with pytest.warns(MechanismWarning, match=r"free motion 1: .*\.rod"):
        assert np.isnan(solution.displacement("C.rocker")).all()
    assert np.isnan(solution.displacement("B.crank")).all()
    assert not solution.free_motion().solvable
    told = r"turn 'rod' about the line between B and C with a moment of up to 44\.4.*: leave that moment out, or give"
    with pytest.raises(FrameError, match=told):
        frame.solve(large=True)
    with pytest.raises(FrameError, match=r"path of 'C\.rocker': the loads turn 'rod'"):
        frame.path("C.rocker", "uz", to=0.01)


@pytest.mark.parametrize("back", [False, True])
@pytest.mark.parametrize("turn", [np.eye(3), *Rotation.random(3, rng=np.random.default_rng(1)).as_matrix()])
def test_a_moment_across_the_rod_is_a_couple_of_forces(back: bool, turn: Array) -> None:
    """Forces on the balls, ``d x f = m``, do to the rocker what the moment does; a billionth about the rod is told."""
    motion = rssr(back, turn).move(A=0.0)
    moment = turn @ np.cross(ROD, [3.0, -20.0, 70.0])
    force = np.cross(moment, turn @ ROD) / (ROD @ ROD)
    status, found = pushed(motion, "C.rod", np.zeros(3), moment)
    near, far = (pushed(motion, f"{end}.rod", sign * force, np.zeros(3))[1] for end, sign in (("B", -1), ("C", 1)))
    assert status == "regular"
    assert_allclose(found, near + far, rtol=0.0, atol=1e-11 * np.abs(far).max())
    assert pushed(motion, "C.rod", np.zeros(3), moment + 1e-9 * np.linalg.norm(moment) * turn @ ALONG)[0] == MECHANISM


def test_what_was_described_first_changes_nothing() -> None:
    forth, back = (rssr(order, gravity=9.81, fy=3.0).move(A=[0.0, 0.1]) for order in (False, True))
    one, other = (motion.frame().solve() for motion in (forth, back))
    for node in ("B.crank", "B.rod", "C.rod", "C.rocker"):
        assert_allclose(one.displacement(node), other.displacement(node), rtol=1e-11, atol=1e-17)
    assert set(one.status) == set(other.status) == {"regular"}
    assert_allclose(forth.frequencies(3), back.frequencies(3), rtol=1e-9)
    assert_allclose(forth.compliance_matrix("C", "rod"), back.compliance_matrix("C", "rod"), rtol=1e-9, atol=1e-15)


@pytest.mark.parametrize("gravity", [0.0, 9.81])
@pytest.mark.parametrize("back", [False, True])
def test_frequencies_are_those_of_balls_that_hardly_resist(back: bool, gravity: float) -> None:
    """As the springs against turning vanish, the spin's frequency does, and nothing else depends on them."""
    found = rssr(back, ball=EVEN, gravity=gravity).move(A=0.3).frequencies(4)
    soft = rssr(back, ball=(*EVEN[:3], 1e-2, 1e-2, 1e-2), gravity=gravity).move(A=0.3).frequencies(5)
    assert soft[0] < 0.05 * soft[1]
    assert_allclose(found, soft[1:], rtol=1e-6)


def test_modes_of_the_frame_have_the_spin() -> None:
    motion = rssr().move(A=0.3)
    assert_allclose(motion.frame().modes(3).frequencies, [0.0, *motion.frequencies(2)], rtol=1e-9)


def test_a_rod_without_inertia_about_itself_has_no_frequency_to_leave_out() -> None:
    forth, back = (rssr(order, rod=None).move(A=0.3) for order in (False, True))
    found = forth.frequencies(3)
    assert np.all(found > 0.0)
    assert_allclose(found, back.frequencies(3), rtol=1e-11)


@pytest.mark.filterwarnings("ignore::linkframe.framework.MechanismWarning")
@pytest.mark.parametrize("gravity", [0.0, 9.81])
def test_compliance_of_a_rod_is_that_of_its_ball_and_nothing_about_itself(gravity: float) -> None:
    """Its end goes with the rocker's; its rotation, of which the spin is a part, has no compliance."""
    motion = rssr(gravity=gravity).move(A=0.3)
    rod, rocker = (motion.compliance_matrix("C", link) for link in ("rod", "rocker"))
    assert_allclose(rod[:3, :3], rocker[:3, :3], rtol=1e-9, atol=1e-9 * rocker[:3, :3].max())
    assert np.isnan(rod[3:]).all()
    assert np.isnan(rod[:, 3:]).all()
    assert np.isfinite(rocker).all()
    assert np.isnan(motion.stiffness("C", "rod")).all()


@pytest.mark.parametrize("back", [False, True])
def test_inertia_spins_a_rod_that_balls_cannot_hold(back: bool) -> None:
    """The forces are those of the rigid links' Newton-Euler equations, the balls bear no moment; nothing holds it at
    rest."""
    linkage = rssr(back, gravity=9.81, mx=5.0, fy=3.0)
    motion = linkage.move(A=np.array([0.0, 0.3]), rates={"A": 10.0}, accelerations={"A": 50.0})
    solution, rigid = motion.frame(inertia=True).solve(), motion.reactions()
    assert set(rigid.method) == {"determinate"}
    assert set(solution.status) == {"regular"}
    for ball in "BC":
        found = solution.joint_force(ball)
        sizes = [np.linalg.norm(each[:, :3], axis=-1) for each in (found, rigid.force(ball))]
        assert_allclose(*sizes, rtol=1e-9)
        assert_allclose(found[:, 3:], 0.0, atol=1e-11)
    assert set(motion.frame().solve().status) == {MECHANISM}
    assert np.isnan(motion.frequencies(1)).all()


def test_weight_beside_the_axis_of_a_rod_swings_it() -> None:
    """From rest about its axis u by ``m u.(e x g) / (u.I u + m e^2)``; the balls bear what is left of its weight."""
    mass, own = 2.0, np.diag([0.02, 0.03, 0.04])
    beside = 0.05 * np.cross(ALONG, [0.0, 0.0, 1.0])
    centre = 0.3 * np.array(PLACES["B"]) + 0.7 * np.array(PLACES["C"]) + beside
    motion = rssr(gravity=9.81, body={"mass": mass, "centre": centre, "inertia": own}).move(A=0.0)
    weight = mass * np.array([0.0, 0.0, -9.81])
    gain = ALONG @ np.cross(beside, weight) / (ALONG @ own @ ALONG + mass * beside @ beside)
    assert abs(gain) > 1.0
    rigid, solution = motion.reactions(), motion.frame(inertia=True).solve()
    whole = rigid.force("B", "rod") + rigid.force("C", "rod")
    assert_allclose(whole[:3], mass * gain * np.cross(ALONG, beside) - weight, rtol=1e-9)
    assert solution.status == "regular"
    for ball in "BC":
        found, expected = solution.joint_force(ball), rigid.force(ball)
        assert_allclose(np.linalg.norm(found[:3]), np.linalg.norm(expected[:3]), rtol=1e-9)
        assert_allclose(found[3:], 0.0, atol=1e-11)


@pytest.mark.parametrize("back", [False, True])
def test_what_is_added_against_the_spin_resists_it(back: bool) -> None:
    """A brake of 200 N m/rad between rod and rocker turns by m / k under a moment about the rod."""
    frame = rssr(back).move(A=0.0).frame()
    frame.add("brake", Joint(stiffness=(0.0, 0.0, 0.0, 200.0, 200.0, 200.0)), "C.rocker", "C.rod")
    frame.load("B.rod", **dict(zip(("mx", "my", "mz"), 5.0 * ALONG, strict=True)))
    solution = frame.solve()
    assert solution.status == "regular"
    assert_allclose(solution.joint_displacement("brake")[3:] @ ALONG, 5.0 / 200.0, rtol=1e-10)
    assert_allclose(solution.joint_force("B")[3:], 0.0, atol=1e-10)


def test_a_support_on_the_rod_bears_the_moment() -> None:
    frame = rssr().move(A=0.0).frame()
    frame.load("C.rod", mx=50.0)
    frame.fix("B.rod", "rx")
    solution = frame.solve()
    assert solution.status == "regular"
    assert_allclose(solution.joint_force("C")[3:], 0.0, atol=1e-9)
    # about the rod, all that is on it
    assert_allclose(solution.reaction("B.rod")[3] * ALONG[0], -50.0 * ALONG[0], rtol=1e-9)


def test_entries_of_a_batch_without_such_a_moment_keep_their_results() -> None:
    motion = rssr().move(A=0.3)
    frame = motion.frame()
    frame.load("C.rocker", fy=10.0)
    alone = frame.solve().displacement("C.rocker")
    frame.load("C.rod", mx=[0.0, 50.0])
    solution = frame.solve()
    assert solution.status.tolist() == [CONSISTENT, MECHANISM]
    with pytest.warns(MechanismWarning):
        found = solution.displacement("C.rocker")
    assert_allclose(found[0], alone, rtol=1e-11)
    assert np.isnan(found[1]).all()


def test_weight_along_a_rod_does_not_spin_it_and_a_load_beside_its_members_would() -> None:
    """The members lie on the axis; a moment within one of them is a moment about it."""
    frame = rssr(gravity=9.81).move(A=0.3).frame()
    assert frame.solve().status == "regular"
    frame.line_load("rod", fy=(3.0, 7.0))
    assert frame.solve().status == "regular"
    frame.point_load("rod", at=0.1, mx=1e-3, local=True)
    assert frame.solve().status == MECHANISM
