"""Positions, velocities and accelerations of the four-bar against the paper, textbooks and 50-digit geometry."""

from __future__ import annotations

from functools import partial

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from linkframe.framework.errors import FrameError
from linkframe.models import FourBar, Link, PoseState
from numpy.testing import assert_allclose, assert_array_equal

DEGREES = np.arange(0, 361, 10)
CHANGE_POINTS = np.radians([0.0, 180.0, 360.0])
SINGULAR = "singular (direct-kinematic, type II): coupler and rocker in line"
length = st.floats(0.05, 5.0)
angle = st.floats(-7.0, 7.0)


def exact(four_bar, theta, side):
    """Pins B and D by the intersection of two circles, in mpmath's precision."""
    a, b, c, d = (mp.mpf(float(length)) for length in four_bar.lengths)
    pin = a * mp.expj(theta)
    diagonal = d - pin
    s = abs(diagonal)
    along = (s**2 + b**2 - c**2) / (2 * s)
    return pin, pin + diagonal / s * (along + 1j * side * mp.sqrt(b**2 - along**2))


# -- Eq. (15) of the paper --------------------------------------------------------------------------------------------


def test_symmetric_linkage_is_equation_15():
    theta = np.radians(DEGREES)
    motion = FourBar().move(theta)
    arm = 0.1 * np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)
    for point, offset in {"B": 0.0, "P": 0.1, "D": 0.2}.items():
        assert_allclose(motion.position(point), arm + np.array([offset, 0.0, 0.0]), atol=1e-16, rtol=1e-15)
    assert_array_equal(motion.position("A"), np.zeros((37, 3)))
    assert_array_equal(motion.position("E"), np.tile([0.2, 0.0, 0.0], (37, 1)))


def test_parallelogram_passes_its_change_points():
    theta = np.linspace(-0.1, 2 * np.pi + 0.1, 4001)
    theta = np.sort(np.concatenate([theta, CHANGE_POINTS, CHANGE_POINTS + 1e-9]))
    motion = FourBar().move(theta, rate=3.0, acceleration=-2.0)
    circle = np.stack([np.cos(theta), np.sin(theta), 0 * theta], axis=-1)
    tangent = np.stack([-np.sin(theta), np.cos(theta), 0 * theta], axis=-1)
    assert_allclose(motion.velocity("P"), 0.3 * tangent, atol=1e-14)
    assert_allclose(motion.acceleration("P"), 0.1 * (-2.0 * tangent - 9.0 * circle), atol=1e-13)
    assert_allclose(motion.angular_velocity("coupler"), 0.0, atol=1e-13)
    assert_allclose(motion.angular_velocity("rocker"), 3.0, atol=1e-13)


def test_singular_poses_are_named_and_only_those():
    motion = FourBar().move(np.radians(DEGREES))
    singular = np.isin(DEGREES, [0, 180, 360])
    assert_array_equal(motion.status, np.where(singular, SINGULAR, "regular"))
    assert_array_equal(motion.state, np.where(singular, PoseState.SINGULAR_DIRECT, PoseState.REGULAR))
    assert np.all(FourBar().move(CHANGE_POINTS + 1e-12).status == "regular")


def test_a_fixed_side_has_no_velocity_at_a_change_point():
    theta = np.append(CHANGE_POINTS, 1.0)
    motion = FourBar(branch="open").move(theta, rate=1.0)
    assert_allclose(motion.position("P"), FourBar().move(theta).position("P"), atol=1e-16)
    assert_array_equal(np.isnan(motion.velocity("P")[:, 0]), [True, True, True, False])


# -- textbooks --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize(
    ("branch", "book", "recomputed"),
    [
        (
            "open",
            [88.8, 117.3, -6.0, -4.0, 26.1, 53.3],
            [88.8372413, 117.2860679, -5.9909657, -3.9917348, 26.0800166, 53.3305883],
        ),
        (
            "crossed",
            [-115.2, -143.6, -0.66, -2.66, 77.9, 50.7],
            [-115.2108122, -143.6596385, -0.662352, -2.6615829, 77.9198551, 50.6692834],
        ),
    ],
)
def test_norton_row_a(branch, book, recomputed):
    """Norton, Design of Machinery, tables P4-1, P6-1, P7-1, row a; its answers have 2 to 4 digits."""
    motion = FourBar(crank=2, coupler=7, rocker=9, ground=6, branch=branch).move(np.radians(30.0), rate=10.0)
    found = [
        value(link)
        for value in (lambda x: np.degrees(motion.angle(x)), motion.angular_velocity, motion.angular_acceleration)
        for link in ("coupler", "rocker")
    ]
    assert_allclose(found, recomputed, rtol=2e-8)
    assert_allclose(found, book, atol=0.07)


def test_nikravesh_example():
    """Nikravesh, Planar Multibody Dynamics, examples 5.2 and 6.5: four-bar with a point 0.2 at 30° on its coupler."""
    point = 0.2 * np.exp(1j * np.radians(30.0))
    four_bar = FourBar(0.1, 0.3, 0.22, 0.2, point=(point.real, point.imag), branch="open")
    motion = four_bar.move(np.radians(45.0), rate=1.5, acceleration=-1.2)
    links = ("coupler", "rocker")
    assert_allclose([motion.angle(link) for link in links], [0.27212474293624817, 0.7586309236111003], rtol=1e-14)
    assert_allclose([motion.angular_velocity(link) for link in links], [0.028622177505291294, 0.7160755715521803])
    assert_allclose([motion.angular_acceleration(link) for link in links], [0.7779495932191832, 0.36564374076175393])
    assert_allclose(motion.position("P"), [0.21066429596757313, 0.21358469552909545, 0.0], rtol=1e-14)


# -- 50 digits --------------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("distance", [1.0, 1e-3, 1e-6, 1e-9, 1e-12])
@pytest.mark.parametrize("change_point", [0.0, np.pi])
@pytest.mark.parametrize("lengths", [(0.1, 0.2, 0.1, 0.2), (0.25, 0.25, 0.25, 0.25), (1.0, 4.0, 3.0, 2.0)])
def test_pins_keep_all_digits_near_a_change_point(lengths, change_point, distance):
    theta = change_point + distance
    four_bar = FourBar(*lengths, branch="parallel")
    with mp.workdps(50):
        _, pin = exact(four_bar, mp.mpf(theta), side=int(np.sign(np.sin(theta))))
    found = four_bar.move(theta).position("D")
    assert_allclose(found[:2], [float(pin.real), float(pin.imag)], atol=1e-15 * max(lengths))


def test_half_chord_by_pythagoras_would_lose_half_the_digits():
    """The plain circle intersection, one nanoradian from the change point: its error is what the factors avoid."""
    theta, (a, b, c, d) = np.pi + 1e-9, (0.1, 0.2, 0.1, 0.2)
    s = abs(d - a * np.exp(1j * theta))
    along = (s**2 + b**2 - c**2) / (2 * s)
    plain = np.sqrt(np.maximum(b**2 - along**2, 0.0))
    true = a * d * abs(np.sin(theta)) / s
    assert abs(plain - true) > 0.5 * true
    assert_allclose(abs(FourBar().move(theta).closure.area) / s, true, rtol=1e-14)


def test_rhombus_has_a_limit_where_the_crank_pin_meets_the_pivot():
    motion = FourBar(1, 1, 1, 1).move([0.0, 1e-9, 1e-3])
    assert_allclose(motion.position("D")[:, 0], 1.0 + np.cos([0.0, 1e-9, 1e-3]), atol=1e-15)
    assert_array_equal(motion.status, [SINGULAR, "regular", "regular"])
    assert np.isnan(FourBar(1, 1, 1, 1).move([0.0, 2 * np.pi], rate=1.0).velocity("D")[:, 0]).all()


def test_lengths_written_in_decimals_make_a_change_point():
    """0.1 + 0.4 and 0.2 + 0.3 are not equal in binary; a half chord from their difference would be 4e-9."""
    assert FourBar(0.1, 0.2, 0.3, 0.4).gap(np.pi) == 0.0
    for excess in (0.0, 1e-16, -1e-16):
        motion = FourBar(0.1, 0.2, 0.3 + excess, 0.4, branch="parallel").move(np.pi, rate=1.0)
        assert motion.status == SINGULAR
        assert_allclose(motion.position("D"), [0.1, 0.0, 0.0], atol=1e-16, rtol=1e-15)
        assert np.isfinite(motion.velocity("D")).all()


def test_antiparallelogram_passes_its_change_points():
    """On the other branch the pin moves as smoothly: its path has a continuous velocity through θ = π."""
    h = 1e-5
    motion = FourBar(branch="antiparallel").move(np.pi + h * np.arange(-2, 3), rate=1.0)
    place = motion.position("D")
    slope = (place[0] - 8 * place[1] + 8 * place[3] - place[4]) / (12 * h)
    assert motion.status[2] == SINGULAR
    assert_allclose(motion.velocity("D")[2], slope, atol=1e-10)
    assert np.sign(place[4, 1]) != np.sign(FourBar().move(np.pi + 2 * h).position("D")[1])


def test_branch_follows_from_the_lengths():
    assert FourBar().branch == FourBar(crank=[0.1, 0.2], rocker=[0.1, 0.2]).branch == "parallel"
    assert FourBar(2, 7, 9, 6).branch == FourBar(crank=[0.1, 0.2], rocker=0.1).branch == "open"


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_derivatives_against_50_digits(branch):
    lengths, theta, side = (0.3, 0.9, 0.8, 0.7), 0.8, {"open": 1, "crossed": -1}[branch]
    four_bar = FourBar(*lengths, branch=branch)
    motion = four_bar.move(theta, rate=1.7, acceleration=-0.6)
    with mp.workdps(50):

        def pin(time):
            return exact(four_bar, theta + mp.mpf(1.7) * time - mp.mpf(0.6) * time**2 / 2, side)[1]

        for order, found in ((1, motion.velocity("D")), (2, motion.acceleration("D"))):
            true = mp.diff(lambda t: pin(t).real, 0, order), mp.diff(lambda t: pin(t).imag, 0, order)
            assert_allclose(found[:2], [float(v) for v in true], rtol=1e-13)


# -- what holds for every four-bar ------------------------------------------------------------------------------------


@given(a=length, b=length, c=length, d=length, theta=angle, branch=st.sampled_from(["open", "crossed"]))
def test_links_keep_their_lengths_on_the_right_side(a, b, c, d, theta, branch):
    four_bar = FourBar(a, b, c, d, branch=branch)
    if not four_bar.assembles(theta):
        with pytest.raises(FrameError, match="cannot be assembled"):
            four_bar.move(theta)
        return
    motion = four_bar.move(theta)
    places = {name: motion.position(name) for name in "ABDE"}
    size = 1e-15 * (a + b + c + d) * 4
    for (first, second), wanted in {"AB": a, "BD": b, "DE": c, "AE": d}.items():
        # Near the limits of reach the half chord is the root of a rounding error; its square is not.
        assert abs(np.linalg.norm(places[first] - places[second]) - wanted) < size * max(1.0, wanted / min(b, c))
    if motion.status == "regular":
        left = np.cross(places["E"] - places["B"], places["D"] - places["B"])[2]
        assert (left > 0) == (branch == "open")


@given(theta=angle, rate=st.floats(-5, 5), x=st.floats(-1, 1), y=st.floats(-1, 1))
def test_points_of_a_link_move_as_a_rigid_body(theta, rate, x, y):
    motion = FourBar(0.3, 0.9, 0.8, 0.7, branch="open").move(theta, rate=rate)
    for link in ("crank", "coupler", "rocker"):
        arm = motion.position_on(link, x, y) - motion.position_on(link, 0.0)
        spin = motion.angular_velocity(link) * np.array([-arm[1], arm[0], 0.0])
        assert_allclose(motion.velocity_on(link, x, y) - motion.velocity_on(link, 0.0), spin, atol=1e-13)


def test_transmission_angle_is_that_between_coupler_and_rocker():
    motion = FourBar(0.3, 0.9, 0.8, 0.7, branch="open").move(np.radians(DEGREES))
    to_b, to_e = (motion.position(point) - motion.position("D") for point in "BE")
    cosine = np.sum(to_b * to_e, axis=-1) / (0.9 * 0.8)
    assert_allclose(np.cos(motion.transmission_angle), cosine, atol=1e-15)
    assert_allclose(FourBar().move([0.5, 1e-9, np.pi + 1e-9]).transmission_angle, [0.5, 1e-9, np.pi - 1e-9], rtol=1e-14)


def test_batches_of_lengths_and_angles_broadcast():
    theta = np.radians([30.0, 60.0])[:, None]
    lengths = np.array([0.1, 0.11, 0.12])
    many = FourBar(crank=lengths, coupler=0.2, rocker=0.15, ground=0.2, point=(0.1, 0.02)).move(
        theta, rate=[1.0, 2.0, 3.0]
    )
    assert many.shape == (2, 3)
    one = FourBar(crank=0.11, coupler=0.2, rocker=0.15, ground=0.2, point=(0.1, 0.02)).move(theta[1, 0], rate=2.0)
    for quantity in ("position", "velocity", "acceleration"):
        assert_array_equal(getattr(many, quantity)("P")[1, 1], getattr(one, quantity)("P"))


# -- what cannot be ---------------------------------------------------------------------------------------------------


def test_a_loop_that_does_not_close_names_pose_and_gap():
    four_bar = FourBar(crank=1.0, coupler=1.0, rocker=1.0, ground=2.5)
    theta = np.radians([0.0, 120.0, 180.0])
    assert_array_equal(four_bar.assembles(theta), [True, False, False])
    assert_allclose(four_bar.gap(theta)[2], 1.5)
    with pytest.raises(FrameError, match=r"pose 2 \(theta = 180 deg\).* gap of 1.5 \(2 of 3"):
        four_bar.move(theta)


def test_rounding_does_not_open_the_loop_at_the_limit_of_reach():
    """The drive angle at which coupler and rocker are stretched out, known to rounding only."""
    ground = np.linspace(2.1, 2.9, 400)
    limit = np.arccos((1 + ground**2 - 4) / (2 * ground))
    four_bar = FourBar(1.0, 1.0, 1.0, ground)
    assert four_bar.assembles(limit).all()
    assert four_bar.singular(limit).all()
    assert not four_bar.assembles(limit + 1e-12).any()


def test_limit_of_reach_is_singular_and_without_velocity():
    four_bar = FourBar(crank=1.0, coupler=1.0, rocker=1.0, ground=2.5, branch="open")
    limit = np.arccos((1 + 2.5**2 - 4) / 5)
    motion = four_bar.move([limit, limit - 1e-6], rate=1.0)
    assert_array_equal(motion.status, [SINGULAR, "regular"])
    assert_array_equal(np.isnan(motion.velocity("D")[:, 0]), [True, False])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"crank": 0.0}, "crank of the four-bar is 0.0: give a positive length"),
        ({"rocker": [0.1, -0.2]}, "rocker of the four-bar is -0.2"),
        ({"ground": np.nan}, "ground of the four-bar contains nan"),
        ({"beam": 2e11}, "beam of the crank is 2.*: give a Beam"),
        ({"point": 0.1}, r"give a pair \(x, y\)"),
        ({"branch": "left"}, "choose one of open, crossed, parallel, antiparallel"),
        ({"crank": [0.1, 0.1], "rocker": [0.1, 0.1, 0.1]}, r"rocker.*\(3,\).*\(2,\).*crank"),
        ({"stiffness": (1.0, 2.0)}, "stiffness of the joints"),
        ({"stiffness": {"B": np.ones(6), "X": np.ones(6)}}, r"stiffness.*\['B', 'X'\]"),
    ],
)
def test_bad_input_is_refused(wrong, message):
    with pytest.raises(FrameError, match=message):
        FourBar(**wrong)


def test_unknown_points_and_links_are_refused():
    motion = FourBar().move(1.0)
    with pytest.raises(FrameError, match="no point 'Q': choose one of A, B, P, D, E"):
        motion.position("Q")
    for of in (motion.angle, FourBar().link_beam):
        with pytest.raises(FrameError, match="no link 'bar': choose one of crank, coupler, rocker"):
            of("bar")
    with pytest.raises(FrameError, match="no passive joint 'A': choose one of B, D, E"):
        FourBar().joint_stiffness("A")
    for of in (motion.frame, partial(FourBar().linkage, 1.0)):
        with pytest.raises(FrameError, match="clearance of joint 'A': the four-bar's passive joints are B, D, E"):
            of({"A": 1e-3})
    with pytest.raises(FrameError, match="drive angle theta contains nan"):
        FourBar().move(np.nan)


def test_arrays_of_the_user_stay_his_own():
    lengths, springs, mass = np.array([0.1, 0.11]), np.full(6, 1e8), np.array([1.0, 2.0])
    four_bar = FourBar(crank=lengths, stiffness=springs, branch="open")
    link = Link(mass=mass, centre=(lengths, 0.0))
    motion = four_bar.move(np.radians(30.0))
    before = motion.position("P").copy(), motion.reactions(coupler=link, gravity=(0.0, -9.81)).unknowns.copy()
    for array in (lengths, springs, mass):
        array *= 2.0
    again = four_bar.move(np.radians(30.0))
    assert_array_equal(again.position("P"), before[0])
    assert_array_equal(again.reactions(coupler=link, gravity=(0.0, -9.81)).unknowns, before[1])
    assert_array_equal(four_bar.joint_stiffness("D"), np.full(6, 1e8))


@pytest.mark.parametrize("scale", [2.0**-20, 2.0**20])
def test_a_change_point_is_one_in_any_unit(scale):
    """The lengths fulfil a + b = c + d but for rounding, 0.1 + 0.5 against 0.2 + 0.4; powers of two scale exactly."""
    lengths = np.array([0.1, 0.5, 0.2, 0.4])
    theta = np.append(np.radians(DEGREES), 1e-6)
    wanted, found = (FourBar(*(unit * lengths), branch="parallel").move(theta, rate=1.0) for unit in (1.0, scale))
    assert wanted.singular.any()
    assert_array_equal(found.singular, wanted.singular)
    assert_array_equal(found.position("D"), scale * wanted.position("D"))
    assert_array_equal(found.velocity("D"), scale * wanted.velocity("D"))
