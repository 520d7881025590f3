"""Compliance, clearance and their sum: orders of error, work, statuses."""

from __future__ import annotations

import warnings

import numpy as np
import pytest
from linkframe.framework.errors import FrameError, MechanismWarning
from linkframe.models import FourBar, Link, accuracy
from numpy.testing import assert_allclose, assert_array_equal

THETA = np.radians([10.0, 30.0, 60.0, 90.0, 150.0, 230.0, 300.0, 350.0])
LOAD = (0.0, 100.0, 0.0)
ROCKING = FourBar(0.3, 0.9, 0.8, 0.7, point=(0.5, 0.2), branch="open")
SINGULAR = "singular (direct-kinematic, type II): coupler and rocker in line"


def test_each_part_is_the_whole_when_the_other_is_absent():
    both = accuracy(ROCKING, THETA, load=LOAD, clearance=1e-3, contact=0.7)
    load = accuracy(ROCKING, THETA, load=LOAD)
    gaps = accuracy(ROCKING, THETA, clearance=1e-3, contact=0.7)
    assert_allclose(both.compliance, load.total, rtol=1e-12, atol=1e-20)
    assert_allclose(both.clearance, gaps.total, rtol=1e-12, atol=1e-18)
    assert_array_equal(load.clearance, np.zeros((8, 3)))
    assert_array_equal(gaps.compliance, np.zeros((8, 3)))
    assert_array_equal(both.rigid, ROCKING.move(THETA).position("P"))


def test_total_is_the_frame_with_load_and_clearance():
    found = accuracy(ROCKING, THETA, load=LOAD, clearance=1e-3, contact=0.7)
    # To 1e-12 of the largest displacement: the offsets go in as forces on the stiff joints.
    assert_allclose(found.total, found.frame().solve().displacement("P")[:, :3], atol=1e-14)
    assert_allclose(found.total_exact - found.clearance_exact, found.compliance, rtol=1e-9, atol=1e-18)


@pytest.mark.parametrize("four_bar", [FourBar(), ROCKING])
def test_first_order_clearance_differs_from_the_exact_by_its_square(four_bar):
    sizes = 1e-3 * 2.0 ** -np.arange(6)
    found = accuracy(four_bar, np.radians([30.0, 60.0, 150.0, 230.0])[:, None], clearance=sizes, contact=2.0)
    error = np.linalg.norm(found.clearance - found.clearance_exact, axis=-1)
    rate = np.log2(error[:, :-1] / error[:, 1:])
    assert_allclose(rate[:, -1], 2.0, atol=0.02)
    assert np.all(error[:, -1] > 1e-12)


def test_contact_by_reaction_gives_way_to_the_load():
    """The load works on the clearance as the joint forces on their offsets: F · u = ε Σ |R| (virtual work)."""
    found = accuracy(ROCKING, THETA, load=(20.0, 100.0, 3.0), clearance=1e-4, contact="reaction")
    frame = ROCKING.move(THETA).frame()
    frame.load("P", fx=20.0, fy=100.0, mz=3.0)
    solution = frame.solve()
    reactions = sum(np.linalg.norm(solution.joint_force(joint)[:, :3], axis=-1) for joint in "BDE")
    found_frame = found.frame()
    moved = found_frame.solve().displacement("P") - solution.displacement("P")
    assert_allclose(moved[:, :3], found.clearance, rtol=1e-9, atol=1e-15)
    work = 20.0 * moved[:, 0] + 100.0 * moved[:, 1] + 3.0 * moved[:, 5]
    assert_allclose(work, 1e-4 * reactions, rtol=1e-9)


def test_contact_by_reaction_is_the_angle_of_the_joint_force():
    by_force = accuracy(ROCKING, THETA, load=LOAD, clearance={"B": 1e-3, "D": 5e-4, "E": 0.0}, contact="reaction")
    frame = ROCKING.move(THETA).frame()
    frame.load("P", fy=100.0)
    solution = frame.solve()
    angles = {joint: np.arctan2(*solution.joint_force(joint)[:, 1::-1].T) for joint in "BDE"}
    given = accuracy(ROCKING, THETA, load=LOAD, clearance={"B": 1e-3, "D": 5e-4}, contact=angles)
    assert_allclose(by_force.clearance, given.clearance, rtol=1e-9, atol=1e-15)
    assert_allclose(by_force.clearance_exact, given.clearance_exact, rtol=1e-9, atol=1e-15)


def test_contact_by_kinetostatics_is_that_by_reaction_when_nothing_moves():
    given = {"load": (20.0, 100.0, 0.0), "clearance": 1e-3}
    reactions = ROCKING.move(THETA).reactions(coupler=Link(force=(20.0, 100.0), at=ROCKING.point))
    angles = {joint: reactions.contact_angle(joint) for joint in "BDE"}
    still = accuracy(ROCKING, THETA, contact="reaction", **given)
    assert_allclose(accuracy(ROCKING, THETA, contact=angles, **given).clearance, still.clearance, atol=1e-12)


def test_an_unloaded_joint_stays_centred():
    """At 90° a force along the coupler passes through B: nothing presses the pins of the rocker."""
    found = accuracy(FourBar(), np.radians(90.0), load=(100.0, 0.0, 0.0), clearance=1e-3, contact="reaction")
    assert_allclose(found.offsets["B"], 1e-3 * np.sign(found.offsets["B"].real), rtol=1e-9)
    assert found.offsets["D"] == found.offsets["E"] == 0.0


def test_singular_poses_have_a_status_and_no_number():
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", MechanismWarning)
        found = accuracy(FourBar(), np.radians([0.0, 60.0, 180.0, 360.0]), load=LOAD, clearance=1e-4, contact=1.0)
        lost = np.array([True, False, True, True])
        for part in (found.compliance, found.clearance, found.clearance_exact, found.total, found.total_exact):
            assert_array_equal(np.isnan(part).any(axis=-1), lost)
    assert_array_equal(found.status, np.where(lost, SINGULAR, "regular"))
    assert_allclose(found.rigid[:, 0], [0.2, 0.15, 0.0, 0.2], atol=1e-16)


def test_contact_by_reaction_leaves_singular_poses_out():
    found = accuracy(FourBar(), np.radians([0.0, 60.0]), load=LOAD, clearance=1e-4, contact="reaction")
    assert np.all(np.isfinite(found.condition_number()))
    with pytest.warns(MechanismWarning):
        total = found.total
    assert_array_equal(np.isnan(total[:, 0]), [True, False])
    assert_array_equal(found.status, [SINGULAR, "regular"])
    regular = accuracy(FourBar(), np.radians(60.0), load=LOAD, clearance=1e-4, contact="reaction")
    assert_allclose(total[1], regular.total, rtol=1e-12, atol=1e-18)


def test_a_loop_that_clearance_leaves_open_says_so():
    found = accuracy(FourBar(), np.radians([2.0, 60.0]), clearance=1e-3, contact=0.0)
    assert_array_equal(found.status, ["regular", "regular"])
    assert_array_equal(found.exact_status, ["clearance leaves the loop open", "regular"])
    assert_array_equal(np.isnan(found.clearance_exact[:, 0]), [True, False])


def test_batches_of_poses_loads_and_clearances():
    theta, size = THETA[:, None], np.array([1e-4, 2e-4, 4e-4])
    many = accuracy(ROCKING, theta, load=(0.0, 1e5 * size, 0.0), clearance=size, contact=0.3)
    assert many.shape == (8, 3)
    one = accuracy(ROCKING, THETA[3], load=(0.0, 1e5 * size[1], 0.0), clearance=size[1], contact=0.3)
    for part in ("compliance", "clearance", "clearance_exact"):
        assert_allclose(getattr(many, part)[3, 1], getattr(one, part), rtol=1e-12, atol=1e-20)
    assert many.condition_number().shape == many.scaled_condition_number().shape == (8, 3)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"clearance": -1e-3}, "clearance of joint 'B' is -0.001: give zero or more"),
        ({"clearance": {"A": 1e-3}}, "clearance of joint 'A': the four-bar's passive joints are B, D, E"),
        ({"clearance": np.nan}, "clearance of joint 'B' contains nan"),
        ({"contact": "force"}, "contact is 'force'"),
        ({"contact": "reaction"}, "the load is zero"),
        ({"load": (1.0, 2.0)}, r"give \(fx, fy, mz\)"),
        ({"load": (0.0, np.ones(3), 0.0)}, r"load fy has batch shape \(3,\).*\(8,\) of drive angle theta"),
    ],
)
def test_bad_input_is_refused(wrong, message):
    with pytest.raises(FrameError, match=message):
        accuracy(FourBar(), THETA, **wrong)
