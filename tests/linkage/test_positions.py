"""Positions and rates of linkages against closed forms and published figures."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import FourBar, Linkage
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import bennett, four_bar
from reference.spatial import spatial_slider_crank, stewart
from scipy.spatial.transform import Rotation

DEGREES = np.arange(0.0, 361.0)
THETA = np.radians(DEGREES)
TURN = Rotation.from_rotvec([0.3, 0.5, -1.0])


# -- planar four-bars -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("turn", [Rotation.identity(), TURN])
@pytest.mark.parametrize(
    ("lengths", "branch"), [((2, 7, 9, 6), "open"), ((2, 7, 9, 6), "crossed"), ((0.1, 0.25, 0.2, 0.22), "open")]
)
def test_four_bar_is_its_closed_form(lengths, branch, turn):
    closed = FourBar(*lengths, branch=branch).move(THETA, rate=3.0, acceleration=-2.0)
    linkage = four_bar(*lengths, 0.5, crossed=branch == "crossed", turn=turn)
    motion = linkage.move(A=THETA, rates={"A": 3.0}, accelerations={"A": -2.0})
    size, back = max(lengths), turn.as_matrix()
    for point in "ABDE":
        assert_allclose(motion.position(point) @ back, closed.position(point), atol=1e-14 * size)
        assert_allclose(motion.velocity(point) @ back, closed.velocity(point), atol=1e-13 * size)
        assert_allclose(motion.acceleration(point) @ back, closed.acceleration(point), atol=2e-12 * size)
    for link in ("crank", "coupler", "rocker"):
        about = turn.apply((0.0, 0.0, 1.0))
        assert_allclose(motion.angular_velocity(link), closed.angular_velocity(link)[:, None] * about, atol=1e-13)
        assert_allclose(
            motion.angular_acceleration(link), closed.angular_acceleration(link)[:, None] * about, atol=1e-12
        )
    assert_array_equal(motion.closure_status, "regular")
    assert motion.gap.max() < 1e-14 * size
    assert_allclose(motion.coordinate("A")[:, 0], THETA)


@pytest.mark.parametrize("branch", ["parallel", "antiparallel"])
def test_change_points_are_passed_on_the_same_branch(branch):
    near = np.concatenate([sign * np.array([0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1e-2]) for sign in (1, -1)])
    theta = np.sort(np.concatenate([THETA, np.pi + near, near]))
    closed = FourBar(1, 2, 1, 2, branch=branch).move(theta, rate=3.0, acceleration=-2.0)
    linkage = four_bar(1, 2, 1, 2, np.radians(60.0), crossed=branch == "antiparallel")
    motion = linkage.move(A=theta, rates={"A": 3.0}, accelerations={"A": -2.0})
    assert_array_equal(motion.closure_status, "regular")
    assert_allclose(motion.position("D"), closed.position("D"), atol=1e-13)
    assert_allclose(motion.velocity("D"), closed.velocity("D"), atol=1e-11)
    assert_allclose(motion.acceleration("D"), closed.acceleration("D"), atol=1e-8)


def test_other_branch_is_taken_when_asked_for():
    linkage = four_bar(1, 2, 1, 2, np.radians(60.0))
    motion = linkage.move(A=THETA, branch="switch", rates={"A": 1.0})
    before, after = ({"rate": 1.0, "theta": THETA} for _ in range(2))
    parallel, anti = FourBar(1, 2, 1, 2, branch="parallel"), FourBar(1, 2, 1, 2, branch="antiparallel")
    first, second = parallel.move(**before), anti.move(**after)
    upper = (DEGREES > 0) & (DEGREES < 180)
    lower = (DEGREES > 180) & (DEGREES < 360)
    for at, expected in ((upper, first), (lower, second)):
        assert_allclose(motion.position("D")[at], expected.position("D")[at], atol=1e-13)
        assert_allclose(motion.velocity("D")[at], expected.velocity("D")[at], atol=1e-10)
    for k in (0, 180, 360):
        assert_allclose(motion.position("D")[k], first.position("D")[k], atol=1e-13)
    assert_array_equal(motion.closure_status, "regular")


def test_poses_out_of_reach_are_told_one_by_one_and_the_rest_goes_on():
    dimensions = {"crank": 1.0, "coupler": 1.2, "rocker": 1.1, "ground": 2.5}
    closed = FourBar(**dimensions, branch="open")
    motion = four_bar(*dimensions.values(), np.radians(10.0)).move(A=THETA, rates={"A": 1.0})
    reach = closed.assembles(THETA)
    assert_array_equal(motion.is_assembled, reach)
    assert_allclose(motion.position("D")[reach], closed.move(THETA[reach]).position("D"), atol=1e-13)
    for result in (motion.position("D"), motion.velocity("B"), motion.axes("coupler"), motion.coordinate("D")):
        assert_array_equal(np.isnan(result).reshape(361, -1).all(axis=1), ~reach)
    assert_allclose(motion.gap[180], 1.2, rtol=1e-6)
    assert motion.closure_status[180].startswith("not assembled: gap 1.2 at joint ")


def test_order_of_the_values_does_not_matter():
    linkage = four_bar(2, 7, 9, 6, 0.5)
    theta = np.random.default_rng(3).uniform(-7.0, 7.0, (5, 40))
    motion = linkage.move(A=theta)
    assert_allclose(motion.position("D"), FourBar(2, 7, 9, 6, branch="open").move(theta).position("D"), atol=1e-13)


# -- spatial linkages -----------------------------------------------------------------------------------------------


@pytest.mark.parametrize("both_balls", [False, True])
def test_spatial_slider_crank_is_its_closed_form(both_balls):
    """IFToMM benchmark: x² = 0.3² - (0.1 - 0.08 sin θ)² - (0.12 + 0.08 cos θ)², at rate 6 of the crank."""
    motion = spatial_slider_crank(both_balls).move(A=THETA, rates={"A": 6.0})
    y, z = 0.1 - 0.08 * np.sin(THETA), 0.12 + 0.08 * np.cos(THETA)
    dy, dz = -0.08 * np.cos(THETA), -0.08 * np.sin(THETA)
    x = np.sqrt(0.09 - y**2 - z**2)
    dx = -(y * dy + z * dz) / x
    ddx = -(dy**2 + dz**2 + dx**2 - y * (y - 0.1) - z * (z - 0.12)) / x
    assert_allclose(motion.position("C")[:, 0], x, atol=1e-15)
    assert_allclose(motion.velocity("C")[:, 0], 6.0 * dx, atol=1e-13)
    assert_allclose(motion.acceleration("C")[:, 0], 36.0 * ddx, atol=1e-11)
    assert_allclose(motion.coordinate("C.prismatic")[:, 0], x - 0.2, atol=1e-15)
    assert_allclose(motion.velocity("C")[0], (0.24, 0.0, 0.0), atol=1e-14)
    middle = 0.5 * (motion.velocity("B")[0] + motion.velocity("C")[0])
    assert_allclose(middle, (0.12, -0.24, 0.0), atol=1e-14)


def test_bennett_angles_keep_their_relation():
    """tan(θ/2) tan(φ/2) = sin((β+α)/2) / sin((β-α)/2) (Bennett 1903): five equations, three independent."""
    alpha, beta = np.radians(30.0), np.radians(70.0)
    theta = np.linspace(0.2, 6.0, 117)
    motion = bennett(alpha, beta, 1.0).move(H0=theta)
    phi = motion.coordinate("H1")[:, 0]
    ratio = np.sin(0.5 * (beta + alpha)) / np.sin(0.5 * (beta - alpha))
    assert_allclose(np.tan(0.5 * theta) * np.tan(0.5 * phi), ratio, rtol=1e-12)
    assert_allclose(motion.coordinate("H2")[:, 0], -theta, atol=1e-12)
    assert motion.gap.max() < 1e-13


def test_cardan_joint_turns_its_shaft_unevenly():
    """tan(output) = tan(input) / cos(angle of the shafts), as the first axis of the cross is drawn square to both."""
    lean = np.radians(35.0)
    output = np.array([0.0, np.sin(lean), np.cos(lean)])
    linkage = Linkage(A=(0, 0, -1), U=(0, 0, 0), C=output)
    linkage.link("shaft", "A", "U")
    linkage.link("other shaft", "U", "C")
    linkage.revolute("A", "ground", "shaft", drive=True)
    linkage.revolute("C", "ground", "other shaft", axis=output)
    linkage.universal("U", "shaft", "other shaft", axis=(1, 0, 0), second=np.cross(output, (1, 0, 0)))
    motion = linkage.move(A=THETA, rates={"A": 1.0})
    angle = np.unwrap(np.arctan2(np.cos(lean) * np.sin(THETA), np.cos(THETA)))
    assert_allclose(motion.coordinate("C")[:, 0], angle, atol=1e-14)
    rate = np.cos(lean) / (np.cos(THETA) ** 2 + np.cos(lean) ** 2 * np.sin(THETA) ** 2)
    assert_allclose(motion.coordinate_rate("C")[:, 0], rate, atol=1e-13)


def test_stewart_platform_goes_where_its_legs_say():
    linkage, base, top = stewart()
    t = np.linspace(0.0, 2.0 * np.pi, 200)
    turn = Rotation.from_rotvec(np.stack([0.2 * np.sin(t), 0.2 * np.sin(2 * t), 0.3 * np.sin(t)], axis=-1)).as_matrix()
    centre = np.array([0.0, 0.0, 1.1])
    shift = np.stack([0.2 * np.sin(t), 0.1 * np.sin(3 * t), 0.1 * np.cos(t) - 0.1], axis=-1)
    ends = np.einsum("pij,kj->pki", turn, top - centre) + centre + shift[:, None]
    legs = np.linalg.norm(ends - base, axis=-1) - np.linalg.norm(top - base, axis=-1)
    motion = linkage.move({f"M{k}": legs[:, k] for k in range(6)})
    assert_allclose(motion.position("O"), centre + shift, atol=1e-13)
    assert_allclose(motion.axes("platform"), turn, atol=1e-13)
    assert_array_equal(motion.closure_status, "regular")


def test_screw_advances_by_its_pitch():
    linkage = Linkage(A=(0, 0, 0), B=(0, 0, 1))
    linkage.link("spindle", "A", "B")
    linkage.link("nut", "B")
    linkage.revolute("A", "ground", "spindle", drive=True)
    linkage.screw("B", "spindle", "nut", axis=(0, 0, 1), pitch=0.01)
    linkage.prismatic("B", "ground", "nut", axis=(0, 0, 1))
    turns = np.linspace(0.0, 5.0, 11)
    motion = linkage.move(A=2.0 * np.pi * turns, rates={"A": 1.0})
    assert_allclose(motion.position("B", "nut")[:, 2], 1.0 - 0.01 * turns, atol=1e-14)
    assert_allclose(motion.coordinate("B")[:, 0], -2.0 * np.pi * turns, atol=1e-13)
    assert_allclose(motion.coordinate_rate("B.prismatic"), -0.01 / (2.0 * np.pi), atol=1e-16)


def test_driven_ball_turns_by_its_rotation_vector():
    linkage = Linkage(A=(0, 0, 0), B=(1, 0, 0))
    linkage.link("arm", "A", "B")
    linkage.spherical("A", "ground", "arm", drive=True)
    vectors = np.linspace(0.0, 1.0, 7)[:, None] * np.array([0.5, 2.0, 0.2])
    motion = linkage.move(A=vectors, rates={"A": (0.0, 0.0, 2.0)})
    assert_allclose(motion.axes("arm"), Rotation.from_rotvec(vectors).as_matrix(), atol=1e-15)
    assert_allclose(motion.coordinate("A"), vectors, atol=1e-14)
    assert_allclose(motion.velocity("B"), np.cross((0.0, 0.0, 2.0), motion.position("B")), atol=1e-15)


def test_drive_where_a_loop_closes_is_the_same_as_one_on_the_tree():
    points = {"A": (0, 0), "B": (0, 1), "C": (2, 1.5), "D": (2.2, 0)}

    def drawn() -> Linkage:
        linkage = Linkage(points)
        for name, ends in (("a", "AB"), ("b", "BC"), ("c", "CD")):
            linkage.link(name, *ends)
        for point, first, second in (("A", "ground", "a"), ("B", "a", "b"), ("C", "b", "c"), ("D", "c", "ground")):
            linkage.revolute(point, first, second)
        return linkage

    driven = drawn()
    driven.drive("A")
    expected = driven.move(A=np.linspace(0.0, 0.5, 6))
    for joint in "BCD":
        other = drawn()
        other.drive(joint)
        motion = other.move({joint: expected.coordinate(joint)[:, 0]})
        assert_allclose(motion.position("B"), expected.position("B"), atol=1e-14)
    both = drawn()
    for joint in "ABC":
        both.drive(joint)
    motion = both.move({joint: expected.coordinate(joint)[:, 0] for joint in "ABC"})
    assert_allclose(motion.position("C"), expected.position("C"), atol=1e-14)


def test_sweep_of_two_drives_goes_on_behind_a_gap():
    """A five-bar whose elbows come too far apart and back again."""
    linkage = Linkage(A=(0, 0), B=(-0.3, 0.8), C=(0.5, 1.6), D=(1.3, 0.8), E=(1, 0))
    for name, ends in (("a", "AB"), ("b", "BC"), ("c", "CD"), ("d", "DE")):
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "a", drive=True)
    linkage.revolute("E", "ground", "d", drive=True)
    for point, first, second in (("B", "a", "b"), ("C", "b", "c"), ("D", "c", "d")):
        linkage.revolute(point, first, second)
    t = np.radians(np.arange(0.0, 361.0, 5.0))
    first, second = 0.9 * np.sin(t), -0.9 * np.sin(t)
    motion = linkage.move(A=first, E=second)
    elbow = (-0.3 + 0.8j) * np.exp(1j * first)
    other = 1.0 + (0.3 + 0.8j) * np.exp(1j * second)
    half = 0.5 * (other - elbow)
    reach = np.abs(half) <= np.sqrt(1.28)
    assert 15 < np.count_nonzero(~reach) < 30
    assert_array_equal(motion.is_assembled, reach)
    assert_array_equal(motion.closure_status[reach], "regular")
    top = (elbow + half + 1j * half / np.abs(half) * np.sqrt(np.maximum(1.28 - np.abs(half) ** 2, 0.0)))[reach]
    assert_allclose(motion.position("C")[reach, :2], np.stack([top.real, top.imag], axis=-1), atol=1e-13)
    # the gap is shared out between the joints: the least there can be is what the two rods lack
    assert_allclose(motion.gap[~reach], 2.0 * (np.abs(half)[~reach] - np.sqrt(1.28)), rtol=1e-5)
