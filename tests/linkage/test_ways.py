"""Ways through the poses: scattered ones, change points of a batch, drives that go round, poses next to a fold."""

from __future__ import annotations

import numpy as np
import pytest
from linkframe.models import FourBar, Linkage
from linkframe.models.linkage.way import assemble, fan
from linkframe.models.linkage.way.guess import guess_of
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import four_bar
from reference.spatial import stewart
from scipy.spatial.transform import Rotation


def scattered_legs(count, spread, seed=0):
    """Stewart platform, legs for random places of its platform, and these places."""
    linkage, base, top = stewart()
    rng = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(rng.uniform(-spread, spread, (count, 3))).as_matrix()
    shift = rng.uniform(-spread, spread, (count, 3))
    centre = np.array([0.0, 0.0, 1.1])
    ends = np.einsum("pij,kj->pki", turn, top - centre) + centre + shift[:, None]
    legs = np.linalg.norm(ends - base, axis=-1) - np.linalg.norm(top - base, axis=-1)
    return linkage, {f"M{k}": legs[:, k] for k in range(6)}, centre + shift, turn


def test_scattered_poses_are_reached_at_once():
    linkage, legs, centre, turn = scattered_legs(300, 0.2)
    motion = linkage.move(legs)
    assert_array_equal(motion.closure_status, "regular")
    assert_allclose(motion.position("O"), centre, atol=1e-13)
    assert_allclose(motion.axes("platform"), turn, atol=1e-13)


def test_scattered_poses_are_those_of_the_way(monkeypatch):
    linkage, legs, _, _ = scattered_legs(120, 0.15, seed=4)
    asked = []
    whole = fan.fanned

    def fanned(*arguments):
        found = whole(*arguments)
        asked.append(found is not None)
        return found

    monkeypatch.setattr("linkframe.models.linkage.way.several_drives.fanned", fanned)
    at_once = linkage.move(legs)
    assert asked == [True]
    monkeypatch.setattr(fan, "POSES", 10**9)
    gone = linkage.move(legs)
    assert asked == [True]
    assert_allclose(at_once.position("O"), gone.position("O"), atol=1e-14)


def test_change_points_of_a_batch_of_parallelograms():
    """Parallelograms of several sizes pass their change points together, each to rounding."""
    theta = np.radians(np.array([0.0, 90.0, 179.0, 180.0, 181.0, 270.0, 360.0]))[:, None]
    size = np.array([0.5, 1.0, 3.0])
    linkage = four_bar(1, 2, 1, 2, 1.0)
    batch = Linkage({name: size[:, None] * place for name, place in linkage.points.items()})
    for name, link in linkage.links.items():
        batch.link(name, *link.points)
    for name, pair in linkage.joints.items():
        batch.revolute(name, pair.first, pair.second, at=pair.at[0], drive=name == "A")
    motion = batch.move(A=theta, rates={"A": 1.0})
    closed = FourBar(size, 2 * size, size, 2 * size, branch="parallel").move(theta, rate=1.0)
    assert_array_equal(motion.closure_status, "regular")
    assert_allclose(motion.position("D"), closed.position("D"), atol=3e-13)
    assert_allclose(motion.velocity("D"), closed.velocity("D"), atol=1e-10)


def test_drive_that_turns_goes_round_to_what_lies_behind_its_range():
    dimensions = (1.0, 1.2, 1.1, 2.5)
    closed = FourBar(*dimensions, branch="open")
    theta = np.radians(np.array([-20.0, 10.0, 340.0, 370.0, 700.0, -380.0]))
    motion = four_bar(*dimensions, np.radians(10.0)).move(A=theta)
    assert_array_equal(motion.closure_status, "regular")
    assert_allclose(motion.position("D"), closed.move(theta).position("D"), atol=1e-14)
    assert_allclose(motion.coordinate("A")[:, 0], theta, atol=1e-14)


def test_poses_next_to_a_dead_point_are_closed():
    """Crank and coupler stretched: s² = (b + c)² at the limit of the drive; the last pose is 1e-9 of it away."""
    a, b, c, d = 1.0, 1.2, 1.1, 2.5
    limit = np.arccos((a**2 + d**2 - (b + c) ** 2) / (2 * a * d))
    theta = limit * (1.0 - np.array([1e-2, 1e-4, 1e-6, 1e-9]))
    motion = four_bar(a, b, c, d, np.radians(10.0)).move(A=np.append(theta, limit * (1.0 + 1e-6)))
    assert_array_equal(motion.is_assembled, [True] * 4 + [False])
    assert motion.gap[:4].max() < 1e-13
    # so near the end a rounding of the drive moves the pin by its root
    error = np.abs(motion.position("D")[:4] - FourBar(a, b, c, d, branch="open").move(theta).position("D")).max(axis=1)
    assert np.all(error < 1e-15 / np.sqrt(1.0 - theta / limit) * 20.0)


@pytest.mark.parametrize("branch", ["open", "crossed"])
def test_other_range_of_the_drive_is_not_taken_for_the_same_branch(branch):
    """A rocker as drive swings in two ranges, mirror images of each other; no motion leads from one to the other.

    Behind the gap, the pose of all that can be assembled is that of the drawn configuration.
    """
    theta = np.radians(np.array([50.0, 80.0, 110.0, 250.0, 280.0, 310.0]))
    linkage = four_bar(1.5, 2.2, 0.8, 2.0, np.radians(80.0), branch == "crossed")
    motion = linkage.move(A=theta)
    assert_array_equal(motion.closure_status[:3], "regular")
    assert not np.any(motion.closure_status[3:] == "regular")
    assert all(told.startswith("branch changed: behind a gap") for told in motion.closure_status[3:].tolist())
    closed = FourBar(1.5, 2.2, 0.8, 2.0, branch=branch).move(theta)
    assert_allclose(motion.position("D"), closed.position("D"), atol=1e-14)


def test_two_drives_behind_a_gap():
    """A rocker that drives, on a base that turns: put together anew behind the gap, and regular where a way leads."""
    theta, base = np.radians([80.0, 110.0, 180.0, 250.0, 280.0, 110.0]), np.linspace(0.0, 0.5, 6)
    drawn = four_bar(1.5, 2.2, 0.8, 2.0, np.radians(80.0))
    linkage = Linkage(drawn.points)
    linkage.link("base", "A", "E")
    for name, link in drawn.links.items():
        linkage.link(name, *link.points)
    linkage.revolute("A", "ground", "base", drive=True, name="turn")
    for name, joint in drawn.joints.items():
        links = ("base" if link == "ground" else link for link in (joint.first, joint.second))
        linkage.revolute(name, *links, at=joint.at[..., 0], drive=name == "A")
    motion = linkage.move(A=theta, turn=base)
    told = np.array([text[:20] for text in motion.closure_status.tolist()])
    wanted = ["regular", "regular", "not assembled: gap 0", *["branch changed: behi"] * 2, "regular"]
    assert_array_equal(told, wanted)
    there = motion.is_assembled
    closed = FourBar(1.5, 2.2, 0.8, 2.0, branch="open").move(theta[there])
    turned = Rotation.from_rotvec(base[there, None] * (0, 0, 1)).apply(closed.position("D").copy())
    assert_allclose(motion.position("D")[there], turned, atol=1e-14)


def test_parallelogram_of_unequal_bars_goes_on_smoothly_and_says_so():
    """Bars of lengths that differ by 1e-3: a crank-rocker, whose own branch would fold where all lie in line."""
    linkage = Linkage(A=(0, 0), B=(0, 1), C=(2, 1), D=(2, 0))
    for name, length in (("AB", 0.999), ("BC", 2.0), ("CD", 1.0)):
        linkage.link(name, *name, length=length)
    links = ("ground", "AB", "BC", "CD", "ground")
    for k, pin in enumerate("ABCD"):
        linkage.revolute(pin, links[k], links[k + 1], drive=pin == "A")
    motion = linkage.move(A=np.radians([0.0, 60.0, 120.0, 180.0]))
    told = [text[:31] for text in motion.closure_status.tolist()]
    assert told == ["regular", "regular", *["branch changed: two came close,"] * 2]
    assert_allclose(motion.axes("BC"), np.broadcast_to(np.eye(3), (4, 3, 3)), atol=3e-3)


def test_scattered_poses_out_of_reach_are_not_taken_at_once(monkeypatch):
    linkage = Linkage(A=(0, 0), B=(-0.3, 0.8), C=(0.5, 1.6), D=(1.3, 0.8), E=(1, 0))
    for name, ends in (("a", "AB"), ("b", "BC"), ("c", "CD"), ("d", "DE")):
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "a", drive=True)
    linkage.revolute("E", "ground", "d", drive=True)
    for point, first, second in (("B", "a", "b"), ("C", "b", "c"), ("D", "c", "d")):
        linkage.revolute(point, first, second)
    rng = np.random.default_rng(2)
    first, second = rng.uniform(-0.3, 0.65, 150), -rng.uniform(-0.3, 0.65, 150)
    half = 0.5 * (1.0 + (0.3 + 0.8j) * np.exp(1j * second) - (-0.3 + 0.8j) * np.exp(1j * first))
    reach = np.abs(half) <= np.sqrt(1.28)
    assert 0 < np.count_nonzero(~reach) < 15
    asked, whole = [], fan.fanned

    def fanned(*arguments):
        asked.append(whole(*arguments))
        return asked[-1]

    monkeypatch.setattr("linkframe.models.linkage.way.several_drives.fanned", fanned)
    motion = linkage.move(A=first, E=second)
    assert asked[0] is None
    assert_array_equal(motion.closure_status == "regular", reach)


def test_guess_on_the_other_branch_is_found_out():
    """Newton's method closes a pose of the crossed four-bar; the sign of the determinant tells it from the open one."""
    linkage, theta = four_bar(2, 7, 9, 6, 0.5), np.array([0.5, 0.6])
    motion = linkage.move(A=theta)
    loops = motion.assembly.loops
    drawn = FourBar(2, 7, 9, 6, branch="open").move(0.5)
    for branch, verified in (("open", True), ("crossed", False)):
        pose = FourBar(2, 7, 9, 6, branch=branch).move(theta)
        state = {
            "A": theta - 0.5,
            "B": pose.angle("coupler") - theta - (drawn.angle("coupler") - 0.5),
            "E": pose.angle("rocker") - drawn.angle("rocker"),
        }
        names = sorted(motion.mechanism.states, key=lambda name: motion.mechanism.states[name].start)
        states = np.stack([state[name] for name in names], axis=-1)
        guess = guess_of(states, np.sign([[x] for x in loops_signs(motion)]), np.ones(2, dtype=bool))
        found = assemble.close_batch(loops, guess, motion.mechanism.parameters, (), (2,))
        assert_array_equal(found.closed, True)
        assert_array_equal(found.verified, verified)
        guess.reached[:] = False
        assert not assemble.close_batch(loops, guess, motion.mechanism.parameters, (), (2,)).verified.any()


def loops_signs(motion):
    """Determinant of the loop at each pose of a motion."""
    found = motion.assembly.loops.close_all(list(motion.assembly.state), motion.mechanism.parameters)
    return found.determinants[0]


def test_jump_over_branches_that_only_come_close_is_told():
    """Nearly a parallelogram: what closes behind 180° as a parallelogram is not where the motion leads."""
    theta = np.radians(np.arange(0.0, 361.0, 20.0))
    motion = four_bar(1.0, 2.0, 1.0 - 1e-4, 2.0, np.radians(60.0)).move(A=theta)
    upper = (theta > 0.1) & (theta < 3.1)
    assert_array_equal(motion.closure_status[upper], "regular")
    beyond = motion.closure_status[(theta > 3.2) & (theta < 6.2)]
    assert not np.any(beyond == "regular")
    exact = four_bar(1.0, 2.0, 1.0, 2.0, np.radians(60.0)).move(A=theta)
    assert_array_equal(exact.closure_status, "regular")
