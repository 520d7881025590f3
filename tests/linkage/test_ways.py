"""Ways through the poses: scattered ones, change points of a batch, drives that go round, poses next to a fold."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pytest
from linkframe.models import FourBar, Linkage
from numpy.testing import assert_allclose, assert_array_equal
from reference.linkages import four_bar
from reference.spatial import stewart
from scipy.optimize import brentq, minimize_scalar
from scipy.spatial.transform import Rotation

OTHER = "other assembly mode; not reachable from the reference configuration"


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


def test_change_points_of_a_batch_of_parallelograms():
    """Parallelograms of several sizes pass their change points together, each to rounding."""
    theta = np.radians(np.array([0.0, 90.0, 179.0, 180.0, 181.0, 270.0, 360.0]))[:, None]
    size = np.array([0.5, 1.0, 3.0])
    linkage = four_bar(1, 2, 1, 2, 1.0)
    batch = Linkage({name: size[:, None] * place for name, place in linkage.points.items()})
    for name, link in linkage.links.items():
        batch.link(name, *link.points)
    for name, pair in linkage.joints.items():
        batch.revolute(name, pair.first, pair.second, reference=pair.reference[0], drive=name == "A")
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

    Behind the gap there is a position where it is asked for, that of the drawn configuration.
    """
    theta = np.radians(np.array([50.0, 80.0, 110.0, 250.0, 280.0, 310.0]))
    linkage = four_bar(1.5, 2.2, 0.8, 2.0, np.radians(80.0), branch == "crossed")
    motion = linkage.move(A=theta)
    assert motion.status.tolist() == ["regular"] * 3 + [OTHER] * 3
    assert_array_equal(motion.is_assembled, [True] * 3 + [False] * 3)
    assert np.isnan(motion.position("D")[3:]).all()
    anyhow = linkage.move(A=theta, other_modes=True)
    assert anyhow.status.tolist() == motion.status.tolist()
    closed = FourBar(1.5, 2.2, 0.8, 2.0, branch=branch).move(theta)
    assert_allclose(anyhow.position("D"), closed.position("D"), atol=1e-14)
    assert_array_equal(anyhow.frame().solve().status, motion.status)


def test_two_drives_behind_a_gap():
    """A rocker that drives, on a base that turns: another assembly mode behind the gap, regular where a path leads."""
    theta, base = np.radians([80.0, 110.0, 180.0, 250.0, 280.0, 110.0]), np.linspace(0.0, 0.5, 6)
    drawn = four_bar(1.5, 2.2, 0.8, 2.0, np.radians(80.0))
    linkage = Linkage(drawn.points)
    linkage.link("base", "A", "E")
    for name, link in drawn.links.items():
        linkage.link(name, *link.points)
    linkage.revolute("A", "ground", "base", drive=True, name="turn")
    for name, joint in drawn.joints.items():
        links = ("base" if link == "ground" else link for link in (joint.first, joint.second))
        linkage.revolute(name, *links, reference=joint.reference[..., 0], drive=name == "A")
    motion = linkage.move(A=theta, turn=base, other_modes=True)
    told = [text[:20] for text in motion.status.tolist()]
    assert told == ["regular", "regular", "not assembled: gap 0", OTHER[:20], OTHER[:20], "regular"]
    there = motion.is_assembled
    closed = FourBar(1.5, 2.2, 0.8, 2.0, branch="open").move(theta[there])
    turned = Rotation.from_rotvec(base[there, None] * (0, 0, 1)).apply(closed.position("D").copy())
    assert_allclose(motion.position("D")[there], turned, atol=1e-14)


def test_scattered_poses_are_assembled_as_far_as_they_reach():
    linkage = five_bar()
    rng = np.random.default_rng(2)
    first, second = rng.uniform(-0.3, 0.65, 150), -rng.uniform(-0.3, 0.65, 150)
    half = 0.5 * (1.0 + (0.3 + 0.8j) * np.exp(1j * second) - (-0.3 + 0.8j) * np.exp(1j * first))
    reach = np.abs(half) <= np.sqrt(1.28)
    assert 0 < np.count_nonzero(~reach) < 15
    assert_array_equal(linkage.move(A=first, E=second).closure_status == "regular", reach)


@pytest.mark.parametrize("unequal", [3e-3, 1e-5])
def test_parallelogram_of_unequal_bars_moves_as_it_really_does(unequal):
    """A crank that is a little shorter than its rocker turns fully; past the line it goes on crossed, in any sweep.

    D lies on the same side of the diagonal from B to E at all times.
    """
    linkage = four_bar(1.0 - unequal, 2.0, 1.0, 2.0, np.radians(60.0))
    closed = FourBar(1.0 - unequal, 2.0, 1.0, 2.0, branch="open")
    for poses in (3, 361, 721):
        theta = np.radians(60.0) + np.linspace(0.0, 2.0 * np.pi, poses)
        motion = linkage.move(A=theta)
        assert np.all(np.char.startswith(motion.closure_status, "regular"))
        assert_allclose(motion.position("D"), closed.move(theta).position("D"), atol=1e-9)


def test_tolerances_of_a_parallelogram():
    """Random bars, unequal by 1e-3: each that can turn does, as its closed form, round sharp bends at 0 and 180°."""
    rng, drawn = np.random.default_rng(0), four_bar(1, 2, 1, 2, 1.0)
    lengths = [length * (1.0 + 1e-3 * rng.standard_normal(60)) for length in (1.0, 2.0, 1.0)]
    linkage = Linkage(drawn.points)
    for (name, link), length in zip(drawn.links.items(), lengths, strict=True):
        linkage.link(name, *link.points, length=length)
    for name, joint in drawn.joints.items():
        linkage.revolute(name, joint.first, joint.second, drive=name == "A", reference=joint.reference[..., 0])
    theta = np.linspace(0.0, 2.0 * np.pi, 25)[:, None]
    motion = linkage.move(A=theta)
    crank, coupler, rocker = lengths
    turns = crank + np.maximum(coupler, 2.0) < rocker + np.minimum(coupler, 2.0)
    assert 5 < np.count_nonzero(turns) < 30
    assert motion.is_assembled[:, turns].all()
    closed = FourBar(*(x[turns] for x in lengths), 2.0, branch="open").move(theta)
    assert_allclose(motion.position("D")[:, turns], closed.position("D"), atol=1e-11)


def test_parallelogram_that_is_too_long_to_turn_stops():
    """Its rocker a little shorter than the crank, it cannot pass the line; behind it there are other modes only."""
    theta = np.radians(np.arange(0.0, 361.0, 20.0))
    motion = four_bar(1.0, 2.0, 1.0 - 1e-4, 2.0, np.radians(60.0)).move(A=theta)
    upper = (theta > 0.1) & (theta < 3.1)
    assert_array_equal(motion.closure_status[upper], "regular")
    beyond = (theta > 3.2) & (theta < 6.2)
    assert_array_equal(motion.closure_status[beyond], OTHER)
    assert np.isnan(motion.position("D")[beyond]).all()


def test_bars_that_are_equal_to_eight_digits_are_equal():
    """The loop is then left open by those digits where the bars lie in line, which the gap tells."""
    theta = np.radians(np.array([60.0, 179.0, 180.0, 180.0 + 1e-7, 181.0, 300.0, 420.0]))
    exact = FourBar(1, 2, 1, 2, branch="parallel").move(theta)
    for crank in (1.0 - 1e-9, 1.0 + 1e-9):
        motion = four_bar(crank, 2.0, 1.0, 2.0, np.radians(60.0)).move(A=theta)
        assert motion.is_assembled.all()
        assert motion.gap.max() < 1e-8
        assert motion.status[2] == "singular (direct-kinematic, type II; dead point of D)"
        assert_allclose(motion.position("D"), exact.position("D"), atol=1e-6)


# -- each pose depends on itself and the reference configuration alone ---------------------------------------------


def five_bar() -> Linkage:
    """5R linkage, both arms driven."""
    linkage = Linkage(A=(0, 0), B=(-0.3, 0.8), C=(0.5, 1.6), D=(1.3, 0.8), E=(1, 0))
    for name, ends in {"a": "AB", "b": "BC", "c": "CD", "d": "DE"}.items():
        linkage.link(name, *ends)
    linkage.revolute("A", "ground", "a", drive=True)
    linkage.revolute("E", "ground", "d", drive=True)
    for point, first, second in (("B", "a", "b"), ("C", "b", "c"), ("D", "c", "d")):
        linkage.revolute(point, first, second)
    return linkage


def three_rps(order: Sequence[int] = (0, 1, 2)) -> Linkage:
    """Platform on three driven legs: hinges on a circle of 0.4 below, balls on one of 0.2 above."""
    linkage = Linkage(P=(0, 0, 0.6))
    turn = Rotation.from_euler("z", np.arange(3)[:, None] * 120.0, degrees=True).as_matrix()
    for k in order:
        foot, head = turn[k] @ (0.4, 0, 0), turn[k] @ (0.2, 0, 0) + (0, 0, 0.6)
        for name, place in {"F": foot, "M": 0.5 * (foot + head), "H": head}.items():
            linkage.point(f"{name}{k}", place)
    linkage.link("platform", "P", *(f"H{k}" for k in order))
    for k in order:
        leg = linkage.points[f"H{k}"] - linkage.points[f"F{k}"]
        linkage.link(f"cylinder {k}", f"F{k}", f"M{k}")
        linkage.link(f"piston {k}", f"M{k}", f"H{k}")
        linkage.revolute(f"F{k}", "ground", f"cylinder {k}", axis=turn[k][:, 1])
        linkage.prismatic(f"M{k}", f"cylinder {k}", f"piston {k}", axis=leg, drive=True, reference=np.linalg.norm(leg))
        linkage.spherical(f"H{k}", f"piston {k}", "platform")
    return linkage


def legs(values) -> dict[str, np.ndarray]:
    return {f"M{k}": np.asarray(value) for k, value in enumerate(np.moveaxis(np.asarray(values), -1, 0))}


def test_home_of_a_platform_is_regular_beside_other_poses():
    home = np.hypot(0.2, 0.6)
    assert three_rps().move().status == "regular"
    beside = three_rps().move(M0=[home, 0.632, 0.7])
    assert_array_equal(beside.status, "regular")


def test_poses_of_a_grid_are_those_alone_and_their_mirror_images():
    """Legs 1 and 2 exchanged mirror the platform; some poses lie behind singular ones on the straight path."""
    linkage, length = three_rps(), np.linspace(0.525, 0.75, 6)
    grid = np.stack(np.broadcast_arrays(0.632, length[:, None], length), axis=-1)
    motion = linkage.move(legs(grid))
    place, status = motion.position("P"), motion.status
    told = dict(zip(*np.unique(status, return_counts=True), strict=True))
    assert told["regular"] > 15
    assert told[OTHER] >= 2
    assert_array_equal(status, status.T)
    assert_allclose(place, np.swapaxes(place, 0, 1) * (1.0, -1.0, 1.0), atol=1e-10)
    for i, j in ((5, 0), (0, 5), (2, 4)):
        alone = linkage.move(legs(grid[i, j]))
        assert alone.status == status[i, j]
        assert_allclose(alone.position("P"), place[i, j], atol=1e-12)
        solved = alone.frame().solve().status
        assert solved == ("absent" if np.isnan(place[i, j, 0]) else status[i, j])


def test_elbow_does_not_flip_behind_a_singular_pose():
    """A straight path of the drives that touches the poses at which the rods are stretched, and paths on either side.

    On one side it leads on, the elbow C where it was; on the other it ends. Where it touches, both ways are as good.
    """

    def reach(s, heading):
        turned = np.exp(1j * s * np.array([np.cos(heading), np.sin(heading)]))
        return np.abs(1.0 + (0.3 + 0.8j) * turned[1] - (-0.3 + 0.8j) * turned[0])

    def farthest(heading):
        return minimize_scalar(lambda s: -reach(s, heading), bounds=(1.5, 2.0), options={"xatol": 1e-12})

    heading = brentq(lambda angle: -farthest(angle).fun - 2.0 * np.sqrt(1.28), 0.09, 0.17, xtol=1e-15)
    touching, linkage = farthest(heading).x, five_bar()
    told = {}
    for aside in (-1e-6, 0.0, 1e-6):
        s = np.array([1.0, touching, 2.5])
        drives = {"A": s * np.cos(heading + aside), "E": s * np.sin(heading + aside)}
        motion = linkage.move(drives)
        told[aside] = motion.status[[0, 2]].tolist()
        for k in range(3):
            alone = linkage.move({name: value[k] for name, value in drives.items()})
            assert alone.status == motion.status[k]
            assert_allclose(alone.position("C"), motion.position("C")[k], atol=1e-9)
        if aside == 0.0:
            assert motion.status[1] == "singular (direct-kinematic, type II; dead point of C)"
    assert told == {-1e-6: ["regular", OTHER], 0.0: ["regular", OTHER], 1e-6: ["regular", "regular"]}


def parallel_cranks() -> Linkage:
    """Three equal cranks and a rod, one rod too many."""
    linkage = Linkage(A=(0, 0), B=(1, 0), C=(2.5, 0), D=(0, 1), E=(1, 1), F=(2.5, 1))
    linkage.link("rod", "D", "E", "F")
    for name, (low, high) in {"a": "AD", "b": "BE", "c": "CF"}.items():
        linkage.link(name, low, high)
        linkage.revolute(low, "ground", name, drive=name == "a")
        linkage.revolute(high, name, "rod")
    return linkage


def test_change_points_of_overconstrained_loops_alone():
    """As in a sweep, and no raw error of linear algebra, at and around the poses where all bars lie in line."""
    theta = np.pi / 2 + np.array([0.0, 1e-12, 1e-9, 1e-6, -1e-9, 1.0])
    linkage = parallel_cranks()
    for turn in (0.0, -np.pi):
        sweep = linkage.move(A=theta + turn, rates={"A": 1.0})
        for k, value in enumerate(theta + turn):
            alone = linkage.move(A=value, rates={"A": 1.0})
            assert alone.status == sweep.status[k]
            assert_allclose(alone.position("E"), sweep.position("E")[k], atol=1e-12)
            assert_allclose(alone.velocity("E"), sweep.velocity("E")[k], atol=1e-9)
            alone.reactions().drive("A")
            alone.frame()
    turned = np.stack([-np.sin(theta - np.pi), np.cos(theta - np.pi), 0.0 * theta], axis=-1)
    assert_allclose(sweep.position("E"), np.array([1.0, 0.0, 0.0]) + turned, atol=1e-9)
