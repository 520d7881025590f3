"""Reactions and drive torque: each link in equilibrium by itself, power in balance, textbook statics."""

from __future__ import annotations

from itertools import product

import mpmath as mp
import numpy as np
import pytest
from linkframe.framework.errors import FrameError
from linkframe.models import FourBar, Link
from numpy.testing import assert_allclose, assert_array_equal

LENGTHS = {"crank": 0.3, "coupler": 0.9, "rocker": 0.8, "ground": 0.7}
LINKS = {
    "crank": Link(mass=2.0, centre=(0.1, 0.03), inertia=0.05, force=(3.0, -7.0), at=(0.2, -0.1), torque=0.4),
    "coupler": Link(mass=5.0, centre=(0.5, -0.2), inertia=0.3, force=(-11.0, 4.0), at=(0.3, 0.4), torque=-1.5),
    "rocker": Link(mass=3.0, centre=(0.3, 0.05), inertia=0.2, force=(6.0, 2.0), torque=2.5),
}
GRAVITY = (0.3, -9.81)
ACTING = {"crank": {"A": 1, "B": 1}, "coupler": {"B": -1, "D": 1}, "rocker": {"D": -1, "E": 1}}


def moving(theta, rate=4.0, acceleration=-3.0):
    return FourBar(**LENGTHS, branch="open").move(theta, rate=rate, acceleration=acceleration)


def moment(arm, force):
    return arm[..., 0] * force[..., 1] - arm[..., 1] * force[..., 0]


def point_of_force(link):
    return link.at or link.centre


@pytest.mark.parametrize("name", LINKS)
def test_each_link_is_in_equilibrium_about_any_point(name):
    """Newton and Euler for one link at a time, moments about the global origin, none of the nine rows reused."""
    motion, link = moving(np.radians(np.arange(0, 360, 7))), LINKS[name]
    found = motion.reactions(**LINKS, gravity=GRAVITY)
    place = motion.position_on(name, *link.centre)
    momentum = link.mass * motion.acceleration_on(name, *link.centre)
    weight = link.mass * np.array([*GRAVITY, 0.0])
    external = np.array([*link.force, 0.0])
    forces = sum(sign * found.reaction(joint) for joint, sign in ACTING[name].items())
    assert_allclose(forces + external + weight, momentum, atol=1e-11)
    moments = sum(sign * moment(motion.position(joint), found.reaction(joint)) for joint, sign in ACTING[name].items())
    moments = moments + moment(motion.position_on(name, *point_of_force(link)), external) + moment(place, weight)
    moments = moments + link.torque + (found.drive_torque if name == "crank" else 0.0)
    spin = link.inertia * motion.angular_acceleration(name) + moment(place, momentum)
    assert_allclose(moments, spin, atol=1e-11)


def test_power_of_drive_and_loads_is_the_rate_of_kinetic_energy():
    """The kinetic energy is differentiated in 40 digits from positions alone, by an independent circle intersection."""
    theta, rate, acceleration = 0.8, 4.0, -3.0
    motion = moving(theta, rate, acceleration)
    found = motion.reactions(**LINKS, gravity=GRAVITY)
    power = found.drive_torque * rate
    for name, link in LINKS.items():
        power = power + motion.velocity_on(name, *point_of_force(link))[:2] @ np.array(link.force)
        power = power + link.mass * (motion.velocity_on(name, *link.centre)[:2] @ np.array(GRAVITY))
        power = power + link.torque * motion.angular_velocity(name)
    assert_allclose(power, energy_rate(theta, rate, acceleration), rtol=1e-10)


def energy_rate(theta, rate, acceleration):
    a, b, c, d = LENGTHS.values()

    def places(time):
        pin = a * mp.expj(theta + rate * time + mp.mpf(acceleration) * time**2 / 2)
        diagonal = d - pin
        s = abs(diagonal)
        along = (s**2 + mp.mpf(b) ** 2 - mp.mpf(c) ** 2) / (2 * s)
        end = pin + diagonal / s * (along + 1j * mp.sqrt(mp.mpf(b) ** 2 - along**2))
        return {"crank": (mp.mpc(0), pin / a), "coupler": (pin, (end - pin) / b), "rocker": (mp.mpc(d), (end - d) / c)}

    def energy(time):
        total = mp.mpf(0)
        for name, link in LINKS.items():
            centre = mp.mpc(*link.centre)
            velocity = mp.diff(lambda t, n=name, z=centre: places(t)[n][0] + z * places(t)[n][1], time)
            spin = mp.diff(lambda t, n=name: places(t)[n][1], time)
            total += (link.mass * abs(velocity) ** 2 + link.inertia * abs(spin) ** 2) / 2
        return total

    with mp.workdps(40):
        return float(mp.diff(energy, 0))


def test_parallelogram_under_a_load_on_the_coupler():
    """By hand at 90°: the load at the coupler's middle is shared by two vertical bars; at 30° torque is F l cos θ."""
    load = Link(force=(0.0, 100.0), at=(0.1, 0.0))
    found = FourBar().move(np.radians([90.0, 30.0])).reactions(coupler=load)
    assert_allclose(found.reaction("D")[0], [0.0, -50.0, 0.0], atol=1e-12)
    assert_allclose(found.reaction("E")[0], [0.0, -50.0, 0.0], atol=1e-12)
    assert_allclose(found.reaction("B")[0], [0.0, 50.0, 0.0], atol=1e-12)
    assert_allclose(found.drive_torque, [0.0, -100.0 * 0.1 * np.cos(np.radians(30.0))], atol=1e-12)


def test_rotating_crank_alone_feels_its_centripetal_force():
    motion = moving(0.5, rate=10.0, acceleration=0.0)
    found = motion.reactions(crank=Link(mass=2.0, centre=(0.25, 0.0)))
    assert_allclose(found.reaction("A"), -2.0 * 0.25 * 100.0 * np.array([np.cos(0.5), np.sin(0.5), 0.0]), atol=1e-12)
    assert_allclose(found.drive_torque, 0.0, atol=1e-12)


def test_reactions_broadcast_over_poses_and_loads():
    theta, loads = np.radians([20.0, 50.0, 80.0])[:, None], np.array([1.0, 10.0])
    many = moving(theta, 1.0, 0.0).reactions(coupler=Link(force=(0.0, loads)))
    assert many.unknowns.shape == (3, 2, 9)
    one = moving(theta[1, 0], 1.0, 0.0).reactions(coupler=Link(force=(0.0, 10.0)))
    assert_allclose(many.unknowns[1, 1], one.unknowns, rtol=1e-13, atol=1e-15)


def test_reactions_broadcast_over_poses_and_places_on_the_links():
    theta, centres, places = np.array([0.3, 0.9])[:, None], np.array([0.0, 0.1, 0.3]), np.array([0.2, 0.1, -0.1])
    many = moving(theta, 1.0, 0.5).reactions(coupler=Link(2.0, (0.1, centres), 0.3, (1.0, 2.0), at=(places, 0.1)))
    assert many.unknowns.shape == (2, 3, 9)
    for (k, angle), j in product(enumerate(theta[:, 0]), range(3)):
        link = Link(2.0, (0.1, centres[j]), 0.3, (1.0, 2.0), at=(places[j], 0.1))
        one = moving(angle, 1.0, 0.5).reactions(coupler=link)
        assert_allclose(many.unknowns[k, j], one.unknowns, rtol=1e-13, atol=1e-15)


def test_singular_poses_have_a_status_and_no_number():
    found = FourBar().move(np.radians([0.0, 30.0, 180.0])).reactions(coupler=Link(force=(0.0, 100.0)))
    assert_array_equal(found.status == "regular", [False, True, False])
    assert_array_equal(np.isnan(found.unknowns).all(axis=-1), [True, False, True])


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"mass": -1.0}, "mass of the link is -1.0"),
        ({"inertia": [0.1, -0.2]}, "inertia of the link is -0.2"),
        ({"centre": 0.1}, "centre of the link is 0.1: give a pair"),
        ({"force": (np.inf, 0.0)}, "force of the link contains inf"),
    ],
)
def test_bad_links_are_refused(wrong, message):
    with pytest.raises(FrameError, match=message):
        Link(**wrong)


def test_gravity_in_the_plane_has_two_components():
    with pytest.raises(FrameError, match=r"gravity is \(0.0, -9.81, 0.0\): give a pair"):
        moving(0.3).reactions(gravity=(0.0, -9.81, 0.0))


def test_unknown_joint_is_refused():
    with pytest.raises(FrameError, match="no joint 'C': choose one of A, B, D, E"):
        moving(0.3).reactions().reaction("C")


def test_loads_that_do_not_fit_the_motion_are_refused():
    motion = moving(np.array([0.3, 0.4]))
    with pytest.raises(FrameError, match=r"mass of the coupler has batch shape \(3,\).*\(2,\) of the motion"):
        motion.reactions(coupler=Link(mass=np.ones(3)))
    with pytest.raises(FrameError, match=r"rocker is 3: give a Link"):
        motion.reactions(rocker=3)
